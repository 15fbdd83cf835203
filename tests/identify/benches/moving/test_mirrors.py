"""Elements of losses whose values can be exchanged for others that act nearly the same."""

from collections.abc import Callable

import numpy as np
import pytest

from layflat.identify import Fit, fit
from layflat.identify.benches.moving import ArmModel
from layflat.identify.benches.moving.blocks import mirrored_losses
from layflat.machine import Machine, changed, load
from layflat.sim import rollout

SMALL = load("paper-small-joint-fast")
PATHS = tuple(f"joint.small.losses.deflections.{i}" for i in range(3))


def test_a_mirrored_pair_keeps_stiffness_and_area_and_mirrors_back() -> None:
    weights = dict(zip(PATHS, SMALL.joint["small"].losses.weights, strict=True))
    columns = {path: np.asarray(value) for path, value in zip(PATHS, (0.004, 0.011, 0.05), strict=True)}
    pairs = list(mirrored_losses(SMALL, columns))
    assert [tuple(pair) for pair in pairs] == [PATHS[:2], PATHS[::2], PATHS[1:]]
    for pair in pairs:
        for power in (-1, 1):
            before, after = (sum(weights[path] * of[path] ** power for path in pair) for of in (columns, pair))
            assert after == pytest.approx(float(before))
        back = next(one for one in mirrored_losses(SMALL, columns | pair) if list(one) == list(pair))
        assert all(back[path] == pytest.approx(float(columns[path])) for path in pair)


def test_where_one_of_a_pair_is_not_sought_it_has_no_mirror() -> None:
    assert not list(mirrored_losses(SMALL, {PATHS[1]: np.asarray(0.01)}))


def fitted(degrees: tuple[float, float], demand: Callable[[float], list[float]]) -> Fit:
    """Fit losses to a log of elements that slip at these angles, begun in the mirror of them."""
    run = rollout(slipping_at(degrees), demand, duration=6.0, start=0.0, seed=2)
    log = run[["voltage", "measured_pressure"]].assign(angle=run["measured_angle"])
    return fit(ArmModel(slipping_at(degrees[::-1]), {"log": log}, blocks=["losses"]), starts=0)


def slipping_at(degrees: tuple[float, float]) -> Machine:
    machine = SMALL
    for path, value in zip(PATHS, np.radians(degrees), strict=False):
        machine = changed(machine, path, float(value))
    return machine


def rich(t: float) -> list[float]:
    return [0.1 * np.sign(np.sin(2.0 * t)) * (t % 3.1 < 2.0) + 0.02 * np.sin(5.0 * t) + 0.006 * np.sin(11.0 * t)]


def poor(t: float) -> list[float]:
    return [0.3 * np.sin(1.5 * t)]


def test_a_search_that_begins_in_the_mirror_leaves_it() -> None:
    degrees = 0.27, 0.42
    found = fitted(degrees, rich)
    for path, value in zip(PATHS, np.radians(degrees), strict=False):
        assert found.estimate(path).identified
        assert found.estimate(path).low <= value <= found.estimate(path).high, path


def test_where_logs_can_not_tell_the_two_apart_intervals_hold_both() -> None:
    degrees = 0.27, 0.42
    found = fitted(degrees, poor)
    for path, value in zip(PATHS, np.radians(degrees), strict=False):
        assert not found.estimate(path).identified
        assert found.estimate(path).low <= value <= found.estimate(path).high, path
