"""The bench sequence: within its limits for every machine that can follow it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.excite import AGAIN, PARTS, WHOLE, sequence
from layflat.machine import Machine, load, names


def _follows(machine: Machine) -> bool:
    return machine.controller is not None and all(joint.gains is not None for joint in machine.joints.values())


FOLLOWING = [name for name in names() if _follows(load(name))]


@pytest.mark.parametrize("name", FOLLOWING)
@pytest.mark.parametrize(("reach", "speed"), [(0.3, 5.0), (0.45, 2.0), (0.02, 20.0)])
def test_reach_and_speed_are_kept_and_it_begins_and_ends_at_rest(name: str, reach: float, speed: float) -> None:
    machine = load(name)
    assert machine.controller is not None
    time, demand = sequence(machine, reach=reach, speed=speed, seed=1)
    cycle = machine.controller.cycle
    assert np.diff(time) == pytest.approx(cycle)
    assert demand.shape == (len(time), len(machine.joints))
    assert time[-1] == pytest.approx(WHOLE + AGAIN, abs=20 * cycle)
    strokes = np.array([joint.stops.working_stroke for joint in machine.joints.values()])
    largest = np.abs(demand).max(axis=0)
    assert (largest <= reach * strokes * (1.0 + 1e-12)).all()
    assert (largest > 0.5 * reach * strokes).all()
    assert np.abs(np.diff(demand, axis=0)).max() <= speed * cycle * (1.0 + 1e-12)
    assert not demand[time < 0.9 * PARTS[0][0] * WHOLE].any()
    assert not demand[-round(0.2 / cycle) :].any()


def test_the_last_third_holds_all_of_it_again_in_other_sizes() -> None:
    time, demand = sequence(load("paper-small-joint"))
    starts = WHOLE * np.cumsum([0.0, *(share for share, _ in PARTS)])

    def moves(first: float, last: float) -> np.ndarray:
        return np.diff(demand[(time >= first) & (time < last), 0])

    for a, b in pairwise(starts[1:]):
        before, after = moves(a, b), moves(WHOLE + a * AGAIN / WHOLE, WHOLE + b * AGAIN / WHOLE)
        assert before.any()
        assert after.any()
        n = min(len(before), len(after))
        assert not np.array_equal(before[:n], after[:n])


def test_a_seed_gives_one_sequence_and_joints_differ() -> None:
    arm = load("paper-arm")
    first, again, other = (sequence(arm, seed=seed)[1] for seed in (4, 4, 5))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    shape = first / np.abs(first).max(axis=0)
    assert np.abs(shape[:, 0] - shape[:, 1]).max() > 0.5


def test_limits_that_leave_no_room_and_machines_without_gains() -> None:
    small = load("paper-small-joint")
    for reach in (0.0, 0.5, float("nan")):
        with pytest.raises(InputError, match=r"reach: .* share of the stroke, 0.02 to 0.45"):
            sequence(small, reach=reach)
    for speed in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match=r"speed: .* give more than zero"):
            sequence(small, speed=speed)
    with pytest.raises(InputError, match=r"rig-kevlar: controller: has no gains .* `layflat tune`"):
        sequence(load("rig-kevlar"))
