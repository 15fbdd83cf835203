"""Demands that move: extrapolated, derived, limited, and let through to a law that plans its own motion."""

from math import inf, nan, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.motion.trajectory import JUMP_ACCELERATION, JUMP_JERK
from layflat.rig.abilities import demand_limits, plan_smooth_motion
from layflat.rig.plan import check_accelerations
from layflat.rig.safety.demands import (
    DEMAND_LIMITED,
    DEMAND_REFUSED,
    EXTRAPOLATION_TIME,
    DemandStream,
    MovingDemand,
    MovingDemandLimits,
    brake_at_border,
    derive_stream,
    extrapolate_demand,
    gate_demand,
    reverses_joint,
)
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.safety.limits import detector_limits, moving_demand_limits
from layflat.rig.trials.soak import EFFORT_FRACTION, run_soak
from layflat.virtual_rig import VirtualRig
from tests.rig.fake_rig import Rig

ARM = load("paper-arm-tracking")
CYCLE, WORKING, B = 0.005, radians(60.0), 20.0
LIMITS = MovingDemandLimits(WORKING, inf, 10.0, 300.0, B, CYCLE, JUMP_ACCELERATION, JUMP_JERK)


def streamed(angles: list[float], apart: float = CYCLE) -> DemandStream:
    stream = DemandStream()
    for angle in angles:
        stream = derive_stream(LIMITS, stream, angle, 0.0, apart)
    return stream


def test_rates_of_what_streams_smoothly_are_derived_and_a_jump_has_none() -> None:
    t = CYCLE * np.arange(20)
    stream = streamed((0.5 * t + 2.0 * t**2).tolist())
    now, limited = extrapolate_demand(LIMITS, stream, stream.angle, nan, nan)
    assert not limited
    assert now.velocity == pytest.approx(0.5 + 4.0 * t[-1])
    assert now.acceleration == pytest.approx(4.0)
    for angles in ([0.0, 0.0, 0.7], [0.0, 0.0, 0.7, 0.7], [0.3]):
        stream = streamed(angles)
        assert extrapolate_demand(LIMITS, stream, stream.angle, nan, nan)[0] == MovingDemand(angles[-1], 0.0, 0.0)


def test_angles_that_come_seldom_are_led_on_until_the_next_is_due() -> None:
    apart = 0.02
    stream = streamed((0.4 * apart * np.arange(6)).tolist(), apart)
    for cycle in range(1, 8):
        stream = derive_stream(LIMITS, stream, 0.04, cycle * CYCLE, CYCLE)
        now, _ = extrapolate_demand(LIMITS, stream, 0.04, nan, nan)
        t = cycle * CYCLE
        expected = MovingDemand(0.04 + 0.4 * t, 0.4, 0.0) if t <= 0.03 + 1e-9 else MovingDemand(0.04, 0.0, 0.0)
        assert now == pytest.approx(expected), t


def test_a_motion_that_nobody_renews_goes_on_for_a_while_and_comes_to_rest() -> None:
    after = [extrapolate_demand(LIMITS, DemandStream(since=t), 0.0, 1.0, 2.0)[0] for t in np.arange(0.0, 0.3, 1e-3)]
    v = np.array([now.velocity for now in after])
    assert after[40].angle == pytest.approx(0.04 + 0.04**2)
    assert v[50] == pytest.approx(1.0 + 2.0 * EXTRAPOLATION_TIME)
    assert np.diff(v).min() > -1.001e-3 * B
    assert v[-1] == 0.0
    assert after[-1].angle == pytest.approx(EXTRAPOLATION_TIME + EXTRAPOLATION_TIME**2 + 1.1**2 / (2.0 * B))


def test_what_the_arm_cannot_do_is_limited() -> None:
    for velocity, acceleration in ((11.0, 0.0), (-inf, 0.0), (1.0, 400.0)):
        now, limited = extrapolate_demand(LIMITS, DemandStream(), 0.1, velocity, acceleration)
        assert limited
        assert abs(now.velocity) <= 10.0
        assert abs(now.acceleration) <= 300.0
        assert gate_demand(LIMITS, 0.1, 0.1, now, limited, CYCLE)[1] == DEMAND_LIMITED
    assert not extrapolate_demand(LIMITS, DemandStream(), 0.1, 9.0, 200.0)[1]


@given(st.floats(-3.0, 3.0), st.floats(-10.0, 10.0), st.floats(-300.0, 300.0))
def test_nothing_that_moves_leaves_the_stroke(angle: float, velocity: float, acceleration: float) -> None:
    now, outcome = gate_demand(LIMITS, 0.0, angle, MovingDemand(angle, velocity, acceleration), False, CYCLE)
    assert abs(now.angle) <= WORKING + 1e-9
    s = np.sign(now.velocity)
    b = max(B, -s * acceleration)
    assert s * now.angle + now.velocity**2 / (2.0 * b) <= WORKING + 1e-6
    if outcome == 0:
        assert now == MovingDemand(angle, velocity, acceleration)


def test_a_target_that_leaves_the_stroke_is_braked_to_the_border_and_met_there_again() -> None:
    t, v = np.arange(0.0, 0.6, CYCLE), 2.0
    found = [brake_at_border(LIMITS, MovingDemand(0.4 + v * x, v, 0.0)) for x in t]
    q, speed = np.array([one.angle for one, _ in found]), np.array([one.velocity for one, _ in found])
    assert q[-1] == pytest.approx(WORKING)
    assert np.diff(q).min() >= -1e-9
    assert np.abs(np.diff(q) / CYCLE - (speed[1:] + speed[:-1]) / 2.0).max() < 0.05, "its speed is its angle's rate"
    assert np.diff(speed).min() >= -B * CYCLE - 1e-9
    back, _ = brake_at_border(LIMITS, MovingDemand(WORKING + 0.1, -v, 0.0))
    assert back == MovingDemand(WORKING, 0.0, 0.0)


def test_a_step_is_let_through_whole_unless_the_file_says_how_fast_demands_go() -> None:
    far = MovingDemand(0.9, 0.0, 0.0)
    assert gate_demand(LIMITS, -0.9, 0.9, far, False, CYCLE) == (far, 0)
    slow, outcome = gate_demand(LIMITS._replace(pace=1.0), -0.9, 0.9, far, False, CYCLE)
    assert (slow, outcome) == (MovingDemand(-0.9 + CYCLE, 1.0, 0.0), DEMAND_LIMITED)
    assert gate_demand(LIMITS, 0.2, 1.2, MovingDemand(1.2, 0.0, 0.0), False, CYCLE) == (
        MovingDemand(0.2, 0.0, 0.0),
        DEMAND_REFUSED,
    )
    assert gate_demand(LIMITS, 0.2, nan, MovingDemand(nan, 0.0, 0.0), False, CYCLE) == (
        MovingDemand(0.2, 0.0, 0.0),
        DEMAND_REFUSED,
    )
    set_by_hand = changed(ARM, "safety.demand_speed", radians(30.0))
    assert moving_demand_limits(ARM, "small").pace == inf
    assert moving_demand_limits(set_by_hand, "small").pace == pytest.approx(radians(30.0))


def test_a_fast_joint_is_not_turned_round() -> None:
    assert reverses_joint(LIMITS, 0.0, 5.0, MovingDemand(-0.5, 0.0, 0.0))
    assert reverses_joint(LIMITS, 0.0, 5.0, MovingDemand(0.4, 0.0, 0.0)), "25/40 rad to stop"
    assert not reverses_joint(LIMITS, 0.0, 5.0, MovingDemand(0.7, 0.0, 0.0))
    assert not reverses_joint(LIMITS, 0.0, 0.5, MovingDemand(-0.5, 0.0, 0.0))


def test_limits_come_from_the_machine() -> None:
    found = demand_limits(ARM)
    assert (found.acceleration > found.braking).all()
    assert (found.pace < found.speed).all()
    paper = load("paper-arm-fast")
    for name in ARM.joints:
        own, others = detector_limits(ARM, name), detector_limits(paper, name)
        assert own.valve_unresponsive.ripple > 0.0, "a rig's dither does not stop"
        assert own.following.held_back_time < others.following.held_back_time
        assert own.suspicion.warmth > others.suspicion.warmth == 0.0


def test_a_plan_beyond_the_arm_is_refused() -> None:
    most = demand_limits(ARM).acceleration
    check_accelerations(ARM, np.array([most, -most]), "file")
    with pytest.raises(InputError, match=r"file: asks joint 'small' for .* deg/s2 at 0.005 s; it can do"):
        check_accelerations(ARM, np.array([[0.0, 0.0], [0.0, -1.01 * most[1]]]), "file")
    check_accelerations(load("paper-arm-fast"), np.array([1e6 * most]), "file")


def rig_at(*angles: float) -> Rig:
    return Rig(ARM, np.array(angles), seed=3).seconds(0.3)


def test_a_step_of_40_degrees_arrives_through_loop_and_supervisor() -> None:
    rig = rig_at(-0.35, 0.35)
    rig.host.demands = [0.35, -0.35]
    rig.seconds(0.5)
    angles = [state.motion.angle for state in rig.bench.states]
    assert angles == pytest.approx([0.35, -0.35], abs=radians(0.4))
    assert rig.shows(RigState.MOVING)
    assert rig.shows(Fault.NONE)


@pytest.mark.parametrize("rates", [True, False])
def test_a_motion_is_followed_with_its_rates_given_or_derived(rates: bool) -> None:
    start = np.array([-0.4, 0.3])
    rig, states = rig_at(*start), plan_smooth_motion(ARM, start, np.array([0.4, -0.5]), EFFORT_FRACTION)
    off = []
    for q, v, a in zip(*states, strict=True):
        rig.host.demands = q.tolist()
        rig.host.rates = (v.tolist(), a.tolist()) if rates else None
        rig.cycles(1)
        off.append([state.motion.angle for state in rig.bench.states] - q)
    row = rig.loop.layout.named(np.array(rig.host.rows), "demand_velocity")
    assert np.abs(row).max() > 1.0
    assert np.sqrt(np.mean(np.square(off))) < radians(0.5)
    assert rig.shows(Fault.NONE)


def test_a_moving_demand_that_leaves_the_stroke_is_told_and_stops_at_the_border() -> None:
    rig = rig_at(0.0, 0.5)
    for k in range(200):
        rig.host.demands, rig.host.rates = [0.0, 0.5 + 1.0 * k * CYCLE], ([0.0, 1.0], [0.0, 0.0])
        rig.cycles(1)
    assert rig.supervisor.ledger.now is Fault.DEMAND_LIMITED
    assert sum("limited" in line for line in rig.host.lines) == 1
    assert rig.supervisor.demands[1] == pytest.approx(radians(60.0))
    rig.seconds(0.3)
    assert rig.bench.states[1].motion.angle == pytest.approx(radians(60.0), abs=radians(0.4))


def test_nothing_is_found_of_a_sound_rig_that_moves_fast() -> None:
    found = run_soak(ARM, VirtualRig(ARM), 60.0 / 3600.0, seed=5)
    assert found.moves > 20
    assert found.trips == 0, found.messages
