"""The tracking law on an arm in space, with payloads that it does not know: benchmarks/picking.py, in small."""

import numpy as np
import pytest
from benchmarks.picking import CLOSE, followed, lines, moves, places, settled

from layflat.machine import load
from layflat.motion.inverse import Inverse
from layflat.motion.kinematics import Kinematics

PICKING = load("picking-arm")


@pytest.mark.compiled
def test_the_tip_comes_to_places_within_a_second() -> None:
    postures = places(PICKING, 33, seed=11)
    tips = Kinematics(PICKING).tip(postures)
    assert np.all(np.ptp(tips, axis=0) > 0.5 * np.ptp(Inverse(PICKING).tips, axis=0))
    times = settled(PICKING, moves(postures, 1), seed=12)
    assert np.mean(times <= 1.0) >= 0.95
    assert np.median(times) < 0.5


@pytest.mark.compiled
def test_straight_lines_are_followed() -> None:
    found = followed(PICKING, lines(PICKING, 6, seed=13), seed=14)
    assert np.all(found < CLOSE)
