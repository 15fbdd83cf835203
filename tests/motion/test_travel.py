import sys
from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.description.change import changed_all
from layflat.errors import InputError, MachineError
from layflat.machine import Machine, changed, load, parameters
from layflat.motion.limits import MotionLimits, arm_limits
from layflat.motion.trajectory import States
from layflat.motion.travel import DEMAND_LEAD, PlannedMove, plan_move, plan_transfer, plan_travel, tip_peaks
from layflat.rig.safety.demands import DemandGate, GatedDemand, follow_demand, stop_margin
from layflat.sim import rollout

ARM = load("paper-arm-fast")
CYCLE = 0.005
DEGREES = st.tuples(st.floats(-58, 58), st.floats(-58, 58)).map(np.radians)


@given(DEGREES, DEGREES)
def test_a_move_goes_from_rest_to_rest_within_its_limits(start: np.ndarray, end: np.ndarray) -> None:
    path = plan_move(ARM, start, end)
    q = path.demand(CYCLE)
    assert q[0] == pytest.approx(start, abs=1e-9)
    assert q[-1] == pytest.approx(end, abs=1e-9)
    assert len(q) == pytest.approx(path.duration / CYCLE + 1.5, abs=0.51)
    h = 1e-3
    fine = path.angles_at(np.arange(-3 * h, path.duration + 4 * h, h))
    for order, most in enumerate((path.limits.speed, path.limits.acceleration, path.limits.jerk), start=1):
        assert np.all(np.abs(np.diff(fine, n=order, axis=0)).max(axis=0) / h**order <= np.array(most) * (1 + 1e-4))


@given(DEGREES, DEGREES, st.floats(0.0, 0.4))
def test_a_demand_that_leads_stays_between_start_and_end(start: np.ndarray, end: np.ndarray, lead: float) -> None:
    path = plan_move(ARM, start, end)
    plain, ahead = path.demand(CYCLE), path.demand(CYCLE, lead=lead)
    assert ahead[0] == pytest.approx(start, abs=1e-9)
    assert ahead[-1] == pytest.approx(end, abs=1e-9)
    assert np.all(np.abs(ahead - end) <= np.abs(plain - end) + 1e-9)
    assert np.all((ahead - start) * (end - start) >= -1e-12)


def test_a_lead_is_the_time_by_which_the_demand_is_ahead() -> None:
    path = plan_travel(np.zeros(1), np.ones(1), MotionLimits((0.5,), (50.0,), (1e4,)))
    middle = round(path.duration / 2 / CYCLE)
    assert path.demand(CYCLE, lead=0.1)[middle] == pytest.approx(path.demand(CYCLE)[middle] + 0.05)


def test_the_way_is_straight_between_both_postures() -> None:
    start, end = np.radians([-30.0, 10.0]), np.radians([20.0, -35.0])
    share = (plan_move(ARM, start, end).demand(CYCLE) - start) / (end - start)
    assert share[:, 0] == pytest.approx(share[:, 1], abs=1e-9)


@given(DEGREES, DEGREES, st.floats(0.5, 8.0))
def test_a_limit_of_the_tips_acceleration_is_met_exactly(start: np.ndarray, end: np.ndarray, most: float) -> None:
    free = plan_move(ARM, start, end)
    gentle = plan_move(ARM, start, end, tip_acceleration=most)
    if tip_peaks(ARM, free)[1] <= most:
        assert gentle.duration == free.duration
    else:
        assert tip_peaks(ARM, gentle)[1] == pytest.approx(most, rel=1e-3)
        assert gentle.duration > free.duration


def test_a_move_to_where_the_arm_is_takes_no_time() -> None:
    path = plan_move(ARM, np.zeros(2), np.zeros(2), tip_acceleration=1.0)
    assert path.duration == 0.0
    assert path.demand(CYCLE, lead=DEMAND_LEAD).tolist() == [[0.0, 0.0]] * 2  # a file of one row is no demand over time


def test_a_lift_takes_the_time_of_its_limits() -> None:
    """Without jerk to speak of: up to speed, along, and down again."""
    path = plan_travel(np.array([0.15]), np.array([0.05]), MotionLimits((0.5,), (5.0,), (1e6,)))
    assert path.duration == pytest.approx(0.1 / 0.5 + 0.5 / 5.0, abs=1e-3)


def test_a_position_that_is_no_number_is_refused() -> None:
    with pytest.raises(InputError, match="not finite"):
        plan_travel(np.array([np.nan]), np.zeros(1), MotionLimits((1.0,), (1.0,), (1.0,)))


def test_without_ruckig_it_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ruckig", None)
    with pytest.raises(InputError, match=r"pip install 'layflat\[motion\]'"):
        plan_travel(np.zeros(1), np.ones(1), MotionLimits((1.0,), (1.0,), (1.0,)))


WAIT = 0.5


def _settled(demand: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Angles less the end, rad, (records, joints), of the arm that follows a demand."""
    rest = np.tile(demand[-1:], (round(2.5 / CYCLE) - len(demand), 1))
    waiting = np.tile(demand[:1], (round(WAIT / CYCLE), 1))
    rows = np.vstack([waiting, demand, rest])
    run = rollout(ARM, rows, duration=CYCLE * len(rows))
    return np.asarray(run["angle"].to_numpy() - end)


@pytest.mark.parametrize(
    "ends", [((-20, -20), (20, 20)), ((20, 20), (-20, -20)), ((0, 30), (-40, -10)), ((-30, -50), (25, 0))]
)
def test_the_papers_arm_follows_and_swings_less_than_after_a_step(ends: tuple[tuple[float, ...], ...]) -> None:
    start, end = (np.radians(np.array(angles, dtype=np.float64)) for angles in ends)
    path = _settled(plan_move(ARM, start, end).demand(CYCLE, lead=DEMAND_LEAD), end)
    step = _settled(np.vstack([start, end]), end)
    assert np.abs(path[-40:].mean(axis=0)).max() < radians(0.3)
    way = np.sign(end - start)
    assert (way * path).max() < (way * step).max()


QUICK = {"valve.conductance": "2 dm^3/(s bar)", "joint.large.valve_size": 1.5, "joint.large.hose.dead_volume": "0.1 l"}


@pytest.mark.parametrize(
    "machine", [load("paper-small-joint-fast"), changed_all(load("paper-large-joint"), QUICK)], ids=["small", "large"]
)
def test_limits_are_about_what_a_joint_does_with_its_valve_fully_open(machine: Machine) -> None:
    limits = arm_limits(machine, np.array([-0.7]), np.array([0.7]))
    run = rollout(machine, opening=1.0, start="-40 deg", duration="1.5 s", noise=False, records=5)
    before_stops = run.sel(joint=machine.arm.joints[0], time=run.time < float(run.time[_first_at(run, 40.0)]))
    time, v = before_stops["time"].to_numpy(), before_stops["velocity"].to_numpy()
    # For a moment the hose that is emptied gives way to being squeezed.
    assert 0.3 * limits.speed[0] < v.max() < 1.2 * limits.speed[0]
    assert 0.5 * limits.acceleration[0] < np.gradient(v, time).max() < 1.05 * limits.acceleration[0]
    locked = changed(machine, f"joint.{machine.arm.joints[0]}.brake.torque", 5e3)
    held = rollout(locked, opening=1.0, duration="0.1 s", noise=False, records=20)
    difference = (held["pressure_a"] - held["pressure_b"]).to_numpy()[:, 0]
    rate = np.gradient(difference, held["time"].to_numpy()).max()
    # jerk / acceleration is rate / torque, and torque is that of the whole supply, less the brake's
    K = parameters.torque_constant(machine.joint[machine.arm.joints[0]])
    torque = K * machine.supply.pressure_gauge - machine.joint[machine.arm.joints[0]].brake.torque
    planned = limits.jerk[0] / limits.acceleration[0] * torque / K
    assert 0.9 * planned < rate < 1.5 * planned  # air is warmed by what comes in: up to 1.4 times as fast


def test_a_larger_valve_turns_its_joint_faster() -> None:
    machine = load("paper-large-joint")
    ends = np.array([-0.7]), np.array([0.7])
    twice = changed(machine, "joint.large.valve_size", 2.0 * machine.joint["large"].valve_size)
    assert arm_limits(twice, *ends).speed[0] == pytest.approx(2.0 * arm_limits(machine, *ends).speed[0])


def _first_at(run: object, degrees: float) -> int:
    return int(np.argmax(run["angle"].to_numpy()[:, 0] > radians(degrees)))  # type: ignore[index]


def test_an_arm_that_can_not_hold_itself_is_refused() -> None:
    hanging = changed(changed(load("paper-small-joint-fast"), "arm.gravity", 9.81), "arm.payload", 20.0)
    with pytest.raises(MachineError, match=r"can't hold 20 kg"):
        arm_limits(hanging, np.zeros(1), np.array([0.5]))


def test_gravity_leaves_less_for_acceleration() -> None:
    hanging = changed(ARM, "arm.gravity", 9.81)
    start, end = np.zeros(2), np.array([0.3, 0.3])
    level = np.array(arm_limits(ARM, start, end).acceleration)
    assert np.all(np.array(arm_limits(hanging, start, end).acceleration) < level)


def test_limits_grow_with_their_shares_and_fall_with_the_payload() -> None:
    start, end = np.radians([-20.0, -20.0]), np.radians([20.0, 20.0])
    whole = arm_limits(ARM, start, end)
    part = whole.scaled(0.5, 0.25, 0.1)
    assert part.speed == pytest.approx(0.5 * np.array(whole.speed))
    assert part.acceleration == pytest.approx(0.25 * np.array(whole.acceleration))
    assert part.jerk == pytest.approx(0.1 * np.array(whole.jerk))
    assert plan_move(ARM, start, end).limits == whole.scaled(0.3, 0.6, 0.6)
    heavy = arm_limits(ARM, start, end, payload=4.0)
    assert heavy.speed == whole.speed
    assert np.all(np.array(heavy.acceleration) < whole.acceleration)


def test_slower_limits_stretch_the_same_way() -> None:
    start, end = np.radians([-20.0, 10.0]), np.radians([20.0, 0.0])
    path = plan_move(ARM, start, end)
    slow: PlannedMove = plan_travel(start, end, path.limits.slowed(1.7))
    times = np.linspace(0.0, path.duration, 50)
    assert slow.duration == pytest.approx(1.7 * path.duration)
    assert slow.angles_at(1.7 * times) == pytest.approx(path.angles_at(times), abs=1e-9)


def _gated(rows: np.ndarray, machine: Machine) -> np.ndarray:
    """What the rig's gates let through of demands, as its supervisor asks them."""
    safety, stops = machine.safety, [joint.stops for joint in machine.joints.values()]
    gates = [DemandGate(s.working_stroke / 2, s.mechanical_stroke / 2, safety.demand_speed) for s in stops]
    now, through = [GatedDemand(at, at) for at in rows[0]], []
    for row in rows:
        left = min(stop_margin(*one) for one in zip(gates, now, row, strict=True))
        lead = min(safety.demand_step, safety.demand_margin * left)
        now = [follow_demand(*one, lead, CYCLE)[0] for one in zip(gates, now, row, strict=True)]
        through.append([one.demand for one in now])
    return np.array(through)


@given(DEGREES, DEGREES)
def test_a_rig_lets_demands_pass_in_time_and_unchanged_at_300_degrees_a_second(
    start: np.ndarray, end: np.ndarray
) -> None:
    rows = plan_move(ARM, start, end).demand(CYCLE, lead=DEMAND_LEAD)
    if np.abs(end - start).max() <= radians(60):
        assert _gated(rows, changed(ARM, "safety.demand_speed", radians(300))) == pytest.approx(rows)
    slowed = _gated(np.vstack([rows, np.tile(end, (200, 1))]), ARM)
    arrived = CYCLE * (1 + int(np.flatnonzero(np.any(slowed != end, axis=1)).max(initial=0)))
    longest = np.abs(end - start).max() / ARM.safety.demand_speed
    assert arrived <= max(longest, CYCLE * len(rows)) + CYCLE


@settings(max_examples=30)
@given(st.lists(st.floats(-0.6, 0.6), min_size=8, max_size=8))
def test_a_motion_goes_on_into_another(numbers: list[float]) -> None:
    q, v, end, w = np.array(numbers).reshape(4, 2)
    limits = MotionLimits((2.0, 2.0), (9.0, 9.0), (200.0, 200.0))
    path = plan_transfer(States(q, v, 0 * v), States(end, w, 0 * w), limits)
    rows = path.states(np.linspace(0.0, path.duration, 2001))
    assert np.allclose([rows.angles[0], rows.velocities[0]], [q, v])
    assert np.allclose([rows.angles[-1], rows.velocities[-1]], [end, w], atol=1e-6)
    assert (np.abs(rows.accelerations) <= 9.0 + 1e-6).all()
    slow = plan_transfer(States(q, v, 0 * v), States(end, w, 0 * w), limits, duration=path.duration + 1.0)
    assert slow.duration >= path.duration + 1.0 - 1e-9
