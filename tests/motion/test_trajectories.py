"""Trajectories: what is asked for every cycle, one after another, and how far they keep to their limits."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from layflat.errors import LayflatError, MachineError
from layflat.machine import Machine, changed, load, parameters
from layflat.motion.curve import ArcCurve, LineCurve
from layflat.motion.dynamics import hose_torques, rigid_torques
from layflat.motion.jerk_limited import plan_jerk_limited
from layflat.motion.kinematics import tip_motion, tip_position
from layflat.motion.limits import JointCapabilities, MotionLimits, TipLimits, joint_capabilities
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import JointLine, JointPath, JointSpline
from layflat.motion.planar import PlanarPath
from layflat.motion.trajectory import MotionSequence, PathMotion, RestMotion, States, Trajectory
from layflat.motion.travel import plan_travel

ARM, SLOW, SMALL = load("paper-arm-fast"), load("paper-arm"), load("paper-small-joint-fast")
HANGING = changed(ARM, "arm.gravity", 9.81)
FORTY = JointLine(np.radians([-20.0, -20.0]), np.radians([20.0, 20.0]))
TIP = tuple(tip_position(ARM, FORTY.start).tolist())
PATHS: dict[str, JointPath] = {
    "line": PlanarPath(ARM, LineCurve.from_points(TIP, (0.3, 0.45), "line"), FORTY.start, "line"),
    "arc": PlanarPath(ARM, ArcCurve.from_points(TIP, (0.5, 0.45), (0.4, 0.5), "arc"), FORTY.start, "arc"),
    "joint": FORTY,
    "via": JointSpline(ARM, [FORTY.start, np.radians([10.0, 30.0]), np.radians([20.0, -30.0])]),
}


def alone(torque: float, rate: float = 1e9, speed: float = 1e9) -> JointCapabilities:
    """What a joint can do without friction and stiffness."""
    none = np.zeros(1)
    most = (np.array([of]) for of in (speed, torque, -torque, rate))
    return JointCapabilities(*most, stiffness=none, friction=none, loss=none, damping=none)  # type: ignore[misc]


def inertia(machine: Machine) -> float:
    mass, _ = parameters.mass_and_pull(parameters.arm(machine), machine.arm.payload, [0.0])
    return float(mass[0, 0])


@given(st.floats(0.05, 1.8), st.floats(2.0, 30.0))
@settings(max_examples=10)
def test_one_joint_with_a_torque_alone_is_bang_bang(angle: float, torque: float) -> None:
    path = JointLine(np.array([-0.9]), np.array([angle - 0.9]))
    found = plan_time_optimal(SMALL, path, capabilities=alone(torque), reserve=0.0)
    assert found.duration == pytest.approx(2.0 * sqrt(angle * inertia(SMALL) / torque), rel=1e-3)


def test_friction_helps_to_brake() -> None:
    able = alone(20.0)._replace(friction=np.array([5.0]))
    found = plan_time_optimal(SMALL, JointLine(np.array([-0.5]), np.array([0.5])), capabilities=able, reserve=0.0)
    speeding, braking = 15.0 / inertia(SMALL), 25.0 / inertia(SMALL)
    assert found.duration == pytest.approx(sqrt(2.0 * (1.0 / speeding + 1.0 / braking)), rel=1e-3)


def test_a_pendulum_switches_where_its_phase_curves_meet() -> None:
    """Bobrow's solution by integration: full torque from the beginning, and back from the end."""
    machine, torque = changed(SMALL, "arm.gravity", 9.81), 24.0
    arm, mass = parameters.arm(machine), machine.arm.payload

    def squared_speed(begin: float, end: float, sign: float) -> tuple[np.ndarray, np.ndarray]:
        def slope(q: float, b: np.ndarray) -> np.ndarray:
            _, pull = parameters.mass_and_pull(arm, mass, [q])
            return 2.0 * (sign * torque + pull) / inertia(machine) + 0.0 * b

        at = np.linspace(begin, end, 2001)
        return at, solve_ivp(slope, (begin, end), [0.0], t_eval=at, rtol=1e-10, atol=1e-12).y[0]

    q, up = squared_speed(-0.6, 0.8, 1.0)
    down = squared_speed(0.8, -0.6, -1.0)[1][::-1]
    speed = np.sqrt(np.minimum(up, down))
    expected = float((2.0 * np.diff(q) / (speed[1:] + speed[:-1])).sum())
    found = plan_time_optimal(
        machine, JointLine(np.array([-0.6]), np.array([0.8])), capabilities=alone(torque), reserve=0.0
    )
    assert found.duration == pytest.approx(expected, rel=2e-3)


@given(st.floats(0.1, 1.5), st.floats(1.0, 6.0), st.floats(10.0, 40.0), st.floats(200.0, 4000.0))
@settings(max_examples=15)
def test_one_joint_with_a_rate_of_torque_is_as_quick_as_ruckig(
    angle: float, speed: float, acceleration: float, jerk: float
) -> None:
    m, path = inertia(SMALL), JointLine(np.array([-0.7]), np.array([angle - 0.7]))
    found = plan_time_optimal(SMALL, path, capabilities=alone(m * acceleration, m * jerk, speed), reserve=0.0)
    expected = plan_travel(path.start, path.goal, MotionLimits((speed,), (acceleration,), (jerk,)))
    assert found.duration == pytest.approx(expected.duration, rel=3e-3)
    times = np.linspace(0.0, expected.duration, 50)
    assert_allclose(found.angles_at(times), expected.angles_at(times), atol=5e-3 * angle)


def used(machine: Machine, motion: Trajectory, able: JointCapabilities) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return shares of torque, of its rate, and of speed, (instants, joints) each, on a grid of its own."""
    times = np.linspace(0.0, motion.duration, 3001)
    states = motion.states(times)
    moving = rigid_torques(machine, states, machine.arm.payload) + able.damping * states.velocities
    rate = np.gradient(moving + able.stiffness * states.angles, times, axis=0)
    torque = able.torque_fractions(hose_torques(machine, able, states, machine.arm.payload))
    return torque, np.abs(rate) / able.rate, np.abs(states.velocities) / able.speed


@pytest.mark.parametrize("machine", [ARM, SLOW, HANGING], ids=["fast", "slow", "hanging"])
@pytest.mark.parametrize("name", PATHS)
def test_limits_hold_and_one_is_used_nearly_always(machine: Machine, name: str) -> None:
    motion, able = plan_time_optimal(machine, PATHS[name], reserve=0.2), joint_capabilities(machine).with_reserve(0.2)
    torque, rate, speed = used(machine, motion, able)
    assert torque.max() < 1.03
    assert speed.max() < 1.01
    # The grid's corners are rounded by its spline: for an instant a rate is passed.
    assert np.quantile(rate, 0.99) < 1.2
    most = np.maximum(np.maximum(torque, rate), speed).max(axis=1)
    assert np.mean(most > 0.93) > 0.95


def test_limits_of_the_tip_hold_in_the_quickest_motion() -> None:
    tip = TipLimits(speed=0.6, acceleration=6.0)
    for name, path in PATHS.items():
        motion = plan_time_optimal(ARM, path, tip=tip)
        assert motion.duration > plan_time_optimal(ARM, path).duration
        v, a = tip_motion(ARM, *motion.states(np.linspace(0.0, motion.duration, 801)))
        assert np.linalg.norm(v, axis=1).max() == pytest.approx(0.6, rel=0.01), name
        assert np.quantile(np.linalg.norm(a, axis=1), 0.99) < 6.0 * 1.02, name


@pytest.mark.parametrize("timed", [plan_time_optimal, plan_jerk_limited])
@pytest.mark.parametrize("name", PATHS)
def test_a_motion_is_from_rest_to_rest_and_its_rates_are_its_own(timed: object, name: str) -> None:
    path = PATHS[name]
    motion: Trajectory = timed(ARM, path)  # type: ignore[operator]
    ends = motion.states([0.0, motion.duration])
    assert_allclose(ends.angles, [path.evaluate(np.zeros(1)).value[0], path.end], atol=1e-9)
    assert_allclose(ends.velocities, 0.0, atol=1e-9)
    h = 1e-5
    times = np.linspace(h, motion.duration - h, 301)
    before, now, after = (motion.states(times + k * h) for k in (-1, 0, 1))
    assert_allclose((after.angles - before.angles) / (2 * h), now.velocities, atol=1e-5)
    assert_allclose((after.velocities - before.velocities) / (2 * h), now.accelerations, atol=0.1)


@pytest.mark.parametrize("name", PATHS)
@pytest.mark.parametrize("machine", [ARM, HANGING], ids=["level", "hanging"])
def test_a_jerk_limited_motion_keeps_its_limits_and_is_slower_than_the_quickest(machine: Machine, name: str) -> None:
    path, tip = PATHS[name], TipLimits(0.8, 5.0, 60.0)
    free, able = plan_jerk_limited(machine, path), joint_capabilities(machine).with_reserve(0.35)
    torque, _, speed = used(machine, free, able)
    assert torque.max() < 1.05  # but for what is damped
    assert speed.max() < 1.0 + 1e-9
    assert plan_time_optimal(machine, path).duration < free.duration
    gentle = plan_jerk_limited(machine, path, tip=tip)
    v, a = tip_motion(machine, *gentle.states(np.linspace(0.0, gentle.duration, 801)))
    assert np.linalg.norm(v, axis=1).max() < 0.8 + 1e-9
    assert np.linalg.norm(a, axis=1).max() < 5.0 * 1.01
    assert gentle.duration > free.duration


def test_a_jerk_limited_line_keeps_the_limits_of_its_tip_exactly() -> None:
    path = PATHS["line"]
    gentle = plan_jerk_limited(ARM, path, tip=TipLimits(0.3, 2.0, 30.0))
    expected = plan_travel(np.zeros(1), np.array([path.length]), MotionLimits((0.3,), (2.0,), (30.0,)))
    assert gentle.duration == pytest.approx(expected.duration)
    moved = tip_position(ARM, gentle.angles_at([0.2]))[0] - TIP
    assert np.linalg.norm(moved) == pytest.approx(expected.angles_at([0.2])[0, 0])


def test_more_payload_and_more_reserve_take_longer() -> None:
    durations = [
        plan_time_optimal(ARM, FORTY, payload=m, reserve=r).duration for m, r in ((0, 0.35), (1.5, 0.35), (3, 0.5))
    ]
    assert durations == sorted(durations)


@pytest.mark.parametrize("timed", [plan_time_optimal, plan_jerk_limited])
def test_an_arm_that_can_not_hold_itself_is_refused(timed: object) -> None:
    with pytest.raises(MachineError, match=r"joint 'large' can't hold 15 kg .* a smaller payload or reserve"):
        timed(HANGING, FORTY, payload=15.0)  # type: ignore[operator]


@pytest.mark.parametrize("timed", [plan_time_optimal, plan_jerk_limited])
def test_a_path_of_no_length_takes_no_time(timed: object) -> None:
    still: Trajectory = timed(ARM, JointLine(FORTY.start, FORTY.start))  # type: ignore[operator]
    assert still.duration == 0.0
    assert_allclose(still.rows(0.005).angles, [FORTY.start] * 2)  # a demand that can be followed


def test_a_programme_without_solution_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    from layflat.motion import optimal

    class Lost:
        status, message = 4, "numerical difficulties"

    monkeypatch.setattr(optimal, "linprog", lambda *_, **__: Lost)
    with pytest.raises(LayflatError, match="no quickest motion was found: numerical difficulties"):
        plan_time_optimal(ARM, FORTY)


def test_joints_that_can_not_change_their_torque_have_no_motion() -> None:
    shut = joint_capabilities(ARM)._replace(rate=np.zeros(2))
    with pytest.raises(LayflatError, match="no motion along the path keeps all limits"):
        plan_time_optimal(ARM, FORTY, capabilities=shut)


def test_a_single_hose_only_pulls() -> None:
    machine = changed(SMALL, "joint.small.acting", "single")
    able = joint_capabilities(machine)
    assert able.min_torque.tolist() == [0.0]
    assert_allclose(able.with_reserve(0.2).min_torque, 0.1 * able.torque)
    assert_allclose(able.with_reserve(0.2).torque, 0.9 * able.torque)
    assert_allclose(able.torque_fractions(np.array([[0.0], able.torque, 0.5 * able.torque])), [[1.0], [1.0], [0.0]])


def test_a_chain_goes_through_its_parts() -> None:
    there = plan_time_optimal(ARM, FORTY)
    chain = MotionSequence.join(RestMotion(0.3, FORTY.start), there, RestMotion(0.2, FORTY.goal))
    assert chain.duration == pytest.approx(0.5 + there.duration)
    assert chain.start_times.tolist() == [0.0, 0.3, 0.3 + there.duration]
    times = np.array([0.29, 0.3, 0.4, 0.3 + there.duration / 2, 0.31 + there.duration, 9.0])
    expected = np.vstack([FORTY.start, there.angles_at(times[1:4] - 0.3), FORTY.goal, FORTY.goal])
    assert_allclose(chain.angles_at(times), expected, atol=1e-12)


def test_rows_are_one_a_cycle_to_the_end() -> None:
    path = JointLine(np.zeros(1), np.ones(1))
    motion = PathMotion(0.0123, path, lambda t: (t / 0.0123, np.ones_like(t) / 0.0123, 0.0 * t))
    rows = motion.rows(0.005)
    assert isinstance(rows, States)
    assert_allclose(rows.angles[:, 0], [0.0, 0.005 / 0.0123, 0.01 / 0.0123, 1.0])
    assert len(replace(motion, duration=0.01).rows(0.005).angles) == 3


@given(st.permutations(range(12)))
def test_states_are_those_of_their_times_in_any_order(order: list[int]) -> None:
    move = plan_travel(FORTY.start, FORTY.goal, MotionLimits(*((2.0, 2.0) for _ in range(3))))
    inner = MotionSequence.join(move, RestMotion(0.1, FORTY.goal))
    times = np.linspace(-0.1, move.duration + 0.5, 12)
    for motion in (move, inner, MotionSequence.join(RestMotion(0.2, FORTY.start), inner)):
        for ascending, mixed in zip(motion.states(times), motion.states(times[order]), strict=True):
            assert_allclose(mixed, ascending[order], rtol=0.0, atol=0.0)
