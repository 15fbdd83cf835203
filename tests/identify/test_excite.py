"""The bench sequence: within its limits for every machine that can follow it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.excite import FIT_DURATION, SEQUENCE_PARTS, VALIDATION_DURATION, plan_sequence
from layflat.machine import Machine, changed, load, names
from layflat.motion.dynamics import torque_margin_at_rest
from layflat.motion.limits import joint_capabilities
from layflat.sim import rollout


def _follows(machine: Machine) -> bool:
    lacking = machine.control_law.gains is not None and any(joint.gains is None for joint in machine.joints.values())
    return machine.controller is not None and not lacking


FOLLOWING = [name for name in names() if _follows(load(name))]


@pytest.mark.parametrize("name", FOLLOWING)
@pytest.mark.parametrize(("reach", "speed"), [(0.3, 5.0), (0.45, 2.0), (0.02, 20.0)])
def test_reach_and_speed_are_kept_and_it_begins_and_ends_at_rest(name: str, reach: float, speed: float) -> None:
    machine = load(name)
    assert machine.controller is not None
    time, demand = plan_sequence(machine, reach=reach, speed=speed, seed=1)
    cycle = machine.controller.cycle
    assert np.diff(time) == pytest.approx(cycle)
    assert demand.shape == (len(time), len(machine.joints))
    assert time[-1] == pytest.approx(FIT_DURATION + VALIDATION_DURATION, abs=20 * cycle)
    strokes = np.array([joint.stops.working_stroke for joint in machine.joints.values()])
    largest = np.abs(demand).max(axis=0)
    assert (largest <= reach * strokes * (1.0 + 1e-12)).all()
    assert (largest > 0.5 * reach * strokes).all()
    assert np.abs(np.diff(demand, axis=0)).max() <= speed * cycle * (1.0 + 1e-12)
    assert not demand[time < 0.9 * SEQUENCE_PARTS[0][0] * FIT_DURATION].any()
    assert not demand[-round(0.2 / cycle) :].any()


def test_the_last_third_holds_all_of_it_again_in_other_sizes() -> None:
    time, demand = plan_sequence(load("paper-small-joint"))
    starts = FIT_DURATION * np.cumsum([0.0, *(share for share, _ in SEQUENCE_PARTS)])

    def moves(first: float, last: float) -> np.ndarray:
        return np.diff(demand[(time >= first) & (time < last), 0])

    for a, b in pairwise(starts[1:]):
        before, after = (
            moves(a, b),
            moves(
                FIT_DURATION + a * VALIDATION_DURATION / FIT_DURATION,
                FIT_DURATION + b * VALIDATION_DURATION / FIT_DURATION,
            ),
        )
        assert before.any()
        assert after.any()
        n = min(len(before), len(after))
        assert not np.array_equal(before[:n], after[:n])


def test_a_seed_gives_one_sequence_and_joints_differ() -> None:
    arm = load("paper-arm")
    first, again, other = (plan_sequence(arm, seed=seed)[1] for seed in (4, 4, 5))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    shape = first / np.abs(first).max(axis=0)
    assert np.abs(shape[:, 0] - shape[:, 1]).max() > 0.5


def test_limits_that_leave_no_room_and_machines_without_gains() -> None:
    small = load("paper-small-joint")
    for reach in (0.0, 0.5, float("nan")):
        with pytest.raises(InputError, match=r"reach: .* fraction of the stroke, 0.02 to 0.45"):
            plan_sequence(small, reach=reach)
    for speed in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match=r"speed: .* give more than zero"):
            plan_sequence(small, speed=speed)
    with pytest.raises(InputError, match=r"rig-kevlar: controller: has no gains .* `layflat tune`"):
        plan_sequence(load("rig-kevlar"))


@pytest.mark.compiled
@pytest.mark.parametrize(("name", "payload"), [("picking-arm", 0.5), ("picking-arm", 0.0), ("single-joint-lift", 0.75)])
def test_arms_that_carry_what_they_weigh_or_nothing_follow_it(name: str, payload: float) -> None:
    machine = changed(load(name), "arm.payload", payload)
    time, demand = plan_sequence(machine)
    run = rollout(machine, demand, duration=float(len(time) * machine.cycle), start=0.0, seed=1)
    limits = np.array([0.5 * joint.stops.working_stroke for joint in machine.joints.values()])
    assert (np.abs(run["angle"].to_numpy()).max(axis=0) < limits).all()
    assert (np.sqrt(np.mean((run["angle"].to_numpy()[:-1] - demand) ** 2, axis=0)) < np.radians(1.0)).all()


def test_all_joints_accelerate_at_once_and_have_the_torque_for_it() -> None:
    machine = load("picking-arm")
    _, demand = plan_sequence(machine)
    accelerations = np.abs(np.diff(demand, 2, axis=0)).max(axis=0) / machine.cycle**2
    assert (accelerations > 1.0).all()
    room, inertia = torque_margin_at_rest(machine, joint_capabilities(machine), demand[::50], machine.arm.payload)
    assert (inertia @ accelerations < room).all()


def test_what_an_arm_can_not_lift_is_refused_with_what_it_can() -> None:
    arm = load("picking-arm")
    with pytest.raises(
        InputError, match=r"reach: joint 'wrist' can't move a payload of 6 kg .* give the arm a smaller payload"
    ):
        plan_sequence(changed(arm, "arm.payload", 6.0))
    upright = changed(arm, "arm.gravity", ("-9.81 m/s^2", "0 m/s^2", "0 m/s^2"))
    heavy = changed(upright, "arm.payload", 4.5)
    with pytest.raises(
        InputError, match=r"can't move a payload of 4.5 kg against gravity at a reach of 0.3; give 0.(\d+), or"
    ) as no:
        plan_sequence(heavy)
    smaller = float(str(no.value).partition("; give ")[2].partition(", or")[0])
    plan_sequence(heavy, reach=smaller)
