"""Demands that move: extrapolated, derived, limited, and let through to a law that plans its own motion."""

from math import inf, nan, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.cli.virtual_rig import VirtualRig
from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.motion.rates import JERK, SURGE
from layflat.rig.abilities import demand_limits
from layflat.rig.plan import check_accelerations
from layflat.rig.safety.demands import LIMITED, REFUSED
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.limits import demands_move, joint_limits
from layflat.rig.safety.moving import GOES_ON, Limits, Moving, Stream, by_now, derived, inside, let_through, turns
from layflat.rig.safety.states import State
from layflat.rig.smooth import smooth
from layflat.rig.trials.soak import quiet
from layflat.rig.trials.work import HARD
from tests.rig.fake_rig import Rig

ARM = load("paper-arm-tracking")
CYCLE, WORKING, B = 0.005, radians(60.0), 20.0
LIMITS = Limits(WORKING, inf, 10.0, 300.0, B, CYCLE, SURGE, JERK)


def streamed(angles: list[float], apart: float = CYCLE) -> Stream:
    stream = Stream()
    for angle in angles:
        stream = derived(LIMITS, stream, angle, 0.0, apart)
    return stream


def test_rates_of_what_streams_smoothly_are_derived_and_a_jump_has_none() -> None:
    t = CYCLE * np.arange(20)
    stream = streamed((0.5 * t + 2.0 * t**2).tolist())
    now, limited = by_now(LIMITS, stream, stream.angle, nan, nan)
    assert not limited
    assert now.velocity == pytest.approx(0.5 + 4.0 * t[-1])
    assert now.acceleration == pytest.approx(4.0)
    for angles in ([0.0, 0.0, 0.7], [0.0, 0.0, 0.7, 0.7], [0.3]):
        stream = streamed(angles)
        assert by_now(LIMITS, stream, stream.angle, nan, nan)[0] == Moving(angles[-1], 0.0, 0.0)


def test_angles_that_come_seldom_are_led_on_until_the_next_is_due() -> None:
    apart = 0.02
    stream = streamed((0.4 * apart * np.arange(6)).tolist(), apart)
    for cycle in range(1, 8):
        stream = derived(LIMITS, stream, 0.04, cycle * CYCLE, CYCLE)
        now, _ = by_now(LIMITS, stream, 0.04, nan, nan)
        t = cycle * CYCLE
        expected = Moving(0.04 + 0.4 * t, 0.4, 0.0) if t <= 0.03 + 1e-9 else Moving(0.04, 0.0, 0.0)
        assert now == pytest.approx(expected), t


def test_a_motion_that_nobody_renews_goes_on_for_a_while_and_comes_to_rest() -> None:
    after = [by_now(LIMITS, Stream(since=t), 0.0, 1.0, 2.0)[0] for t in np.arange(0.0, 0.3, 1e-3)]
    v = np.array([now.velocity for now in after])
    assert after[40].angle == pytest.approx(0.04 + 0.04**2)
    assert v[50] == pytest.approx(1.0 + 2.0 * GOES_ON)
    assert np.diff(v).min() > -1.001e-3 * B
    assert v[-1] == 0.0
    assert after[-1].angle == pytest.approx(GOES_ON + GOES_ON**2 + 1.1**2 / (2.0 * B))


def test_what_the_arm_cannot_do_is_limited() -> None:
    for velocity, acceleration in ((11.0, 0.0), (-inf, 0.0), (1.0, 400.0)):
        now, limited = by_now(LIMITS, Stream(), 0.1, velocity, acceleration)
        assert limited
        assert abs(now.velocity) <= 10.0
        assert abs(now.acceleration) <= 300.0
        assert let_through(LIMITS, 0.1, 0.1, now, limited, CYCLE)[1] == LIMITED
    assert not by_now(LIMITS, Stream(), 0.1, 9.0, 200.0)[1]


@given(st.floats(-3.0, 3.0), st.floats(-10.0, 10.0), st.floats(-300.0, 300.0))
def test_nothing_that_moves_leaves_the_stroke(angle: float, velocity: float, acceleration: float) -> None:
    now, outcome = let_through(LIMITS, 0.0, angle, Moving(angle, velocity, acceleration), False, CYCLE)
    assert abs(now.angle) <= WORKING + 1e-9
    s = np.sign(now.velocity)
    b = max(B, -s * acceleration)
    assert s * now.angle + now.velocity**2 / (2.0 * b) <= WORKING + 1e-6
    if outcome == 0:
        assert now == Moving(angle, velocity, acceleration)


def test_a_target_that_leaves_the_stroke_is_braked_to_the_border_and_met_there_again() -> None:
    t, v = np.arange(0.0, 0.6, CYCLE), 2.0
    found = [inside(LIMITS, Moving(0.4 + v * x, v, 0.0)) for x in t]
    q, speed = np.array([one.angle for one, _ in found]), np.array([one.velocity for one, _ in found])
    assert q[-1] == pytest.approx(WORKING)
    assert np.diff(q).min() >= -1e-9
    assert np.abs(np.diff(q) / CYCLE - (speed[1:] + speed[:-1]) / 2.0).max() < 0.05, "its speed is its angle's rate"
    assert np.diff(speed).min() >= -B * CYCLE - 1e-9
    back, _ = inside(LIMITS, Moving(WORKING + 0.1, -v, 0.0))
    assert back == Moving(WORKING, 0.0, 0.0)


def test_a_step_is_let_through_whole_unless_the_file_says_how_fast_demands_go() -> None:
    far = Moving(0.9, 0.0, 0.0)
    assert let_through(LIMITS, -0.9, 0.9, far, False, CYCLE) == (far, 0)
    slow, outcome = let_through(LIMITS._replace(pace=1.0), -0.9, 0.9, far, False, CYCLE)
    assert (slow, outcome) == (Moving(-0.9 + CYCLE, 1.0, 0.0), LIMITED)
    assert let_through(LIMITS, 0.2, 1.2, Moving(1.2, 0.0, 0.0), False, CYCLE) == (Moving(0.2, 0.0, 0.0), REFUSED)
    assert let_through(LIMITS, 0.2, nan, Moving(nan, 0.0, 0.0), False, CYCLE) == (Moving(0.2, 0.0, 0.0), REFUSED)
    set_by_hand = changed(ARM, "safety.demand_speed", radians(30.0))
    assert demands_move(ARM, "small").pace == inf
    assert demands_move(set_by_hand, "small").pace == pytest.approx(radians(30.0))


def test_a_fast_joint_is_not_turned_round() -> None:
    assert turns(LIMITS, 0.0, 5.0, Moving(-0.5, 0.0, 0.0))
    assert turns(LIMITS, 0.0, 5.0, Moving(0.4, 0.0, 0.0)), "25/40 rad to stop"
    assert not turns(LIMITS, 0.0, 5.0, Moving(0.7, 0.0, 0.0))
    assert not turns(LIMITS, 0.0, 0.5, Moving(-0.5, 0.0, 0.0))


def test_limits_come_from_the_machine() -> None:
    found = demand_limits(ARM)
    assert (found.acceleration > found.braking).all()
    assert (found.pace < found.speed).all()
    paper = load("paper-arm-fast")
    for name in ARM.joints:
        own, others = joint_limits(ARM, name), joint_limits(paper, name)
        assert own.valve_unresponsive.ripple > 0.0, "a rig's dither does not stop"
        assert own.following.long < others.following.long
        assert own.doubt.warmth > others.doubt.warmth == 0.0


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
    assert rig.shows(State.MOVING)
    assert rig.shows(Fault.NONE)


@pytest.mark.parametrize("rates", [True, False])
def test_a_motion_is_followed_with_its_rates_given_or_derived(rates: bool) -> None:
    start = np.array([-0.4, 0.3])
    rig, states = rig_at(*start), smooth(ARM, start, np.array([0.4, -0.5]), HARD)
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
    found = quiet(ARM, VirtualRig(ARM), 60.0 / 3600.0, seed=5)
    assert found.moves > 20
    assert found.trips == 0, found.messages
