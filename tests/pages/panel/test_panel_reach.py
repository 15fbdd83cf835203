"""What is shown as reachable is where the tip comes to."""

import numpy as np
import pytest

from layflat.machine import load
from layflat.motion.inverse import InverseKinematics
from layflat.pages.panel.search import GRID_ROWS, reachable_grid


@pytest.mark.parametrize(("name", "height"), [("paper-arm", 0.0), ("picking-arm", 0.3)])
def test_places_that_are_shown_are_reached(name: str, height: float) -> None:
    inverse = InverseKinematics(load(name))
    corners, there = reachable_grid(inverse, height)
    assert corners.shape == (GRID_ROWS, GRID_ROWS, 3)
    assert 0.1 < there.mean() < 0.9
    near = np.zeros(inverse.joints)
    some = np.random.default_rng(0).choice(np.flatnonzero(there), 20)
    for place in corners.reshape(-1, 3)[some]:
        found = inverse.solve_near(place[None], near)
        assert inverse.tip(found.angles[0]) == pytest.approx(place, abs=2e-4)
    assert corners[..., 2] == pytest.approx(height)
