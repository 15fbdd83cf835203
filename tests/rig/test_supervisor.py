"""States without faults: start, stop, demands, stale setpoints; and no false trip."""

from math import nan, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.machine import changed, load
from layflat.rig.device_state import DeviceState
from layflat.rig.safety.demands import DEMAND_LIMITED, DemandGate, GatedDemand, follow_demand, stop_margin
from layflat.rig.safety.faults import Fault, RigState, ValveMode
from layflat.sim.run import rollout
from tests.rig.fake_rig import Rig

ARM = load("paper-arm-fast")
WORKING, SPEED = ARM.joint["small"].stops.working_stroke / 2, ARM.safety.demand_speed
GATE = DemandGate(WORKING, ARM.joint["small"].stops.mechanical_stroke / 2, SPEED)


def test_a_soft_start_brings_the_air_and_then_obeys() -> None:
    rig = Rig(ARM, np.array([0.1, -0.2]), filled=False).seconds(0.5)
    assert rig.shows(RigState.OFF)
    assert set(rig.driver.commands[-1].voltages) == {5.0}
    assert not rig.driver.commands[-1].air
    rig.host.start = True
    rig.cycles(1)
    assert rig.shows(RigState.STARTING)
    rig.until(lambda: rig.supervisor.state is RigState.READY, 4.0)
    assert rig.shows(Fault.NONE)
    ambient, supply = rig.bench.around.ambient_pressure, rig.bench.around.supply_pressure
    for state in rig.bench.states:
        held = 0.5 * (state.hose_a.pressure + state.hose_b.pressure)
        assert held - ambient > 0.35 * (supply - ambient), "joints with less air are soft"
    rig.seconds(1.0)
    at = [state.motion.angle for state in rig.bench.states]
    assert at == pytest.approx([0.1, -0.2], abs=radians(3.0))
    rig.host.demands = [0.3, 0.3]
    rig.seconds(3.0)
    assert rig.shows(RigState.MOVING)
    assert [state.motion.angle for state in rig.bench.states] == pytest.approx([0.3, 0.3], abs=radians(0.5))
    assert rig.shows(Fault.NONE)


@pytest.mark.parametrize("name", ["paper-arm-fast", "paper-arm-tracking"])
def test_joints_that_lie_at_their_stops_are_led_inside(name: str) -> None:
    machine = load(name)
    stops = [0.5 * joint.stops.mechanical_stroke for joint in machine.joints.values()]
    rig = Rig(machine, np.array([-stops[0], stops[1] + radians(0.1)]), filled=False).cycles(2)
    rig.host.start = True
    rig.until(lambda: rig.supervisor.state is RigState.READY, 6.0)
    rig.seconds(1.0)
    rig.host.demands = [-0.3, 0.3]
    rig.seconds(5.0)
    assert rig.shows(RigState.MOVING)
    assert [state.motion.angle for state in rig.bench.states] == pytest.approx([-0.3, 0.3], abs=radians(0.5))
    assert rig.supervisor.ledger.latched is Fault.NONE


def test_air_that_does_not_come_is_a_fault() -> None:
    rig = Rig(ARM, filled=False).cycles(2)
    rig.driver.supply = 1.2e5
    rig.host.start = True
    took = rig.until(lambda: rig.supervisor.ledger.latched is Fault.NO_AIR, 6.0)
    assert took == pytest.approx(ARM.safety.start_time, abs=0.05)
    rig.seconds(1.0)
    assert not rig.supervisor.is_pressurised


def test_the_air_that_a_rig_takes_is_estimated() -> None:
    rig = Rig(ARM, np.zeros(2)).seconds(0.1)
    taken = [(state.ledger.air_taken, told) for state, told in zip(rig.bench.states, told_air(rig), strict=True)]
    for demand in (0.5, -0.4, 0.3):
        rig.host.demands = [demand, -demand]
        rig.seconds(1.5)
    for (truth_0, told_0), state, told in zip(taken, rig.bench.states, told_air(rig), strict=True):
        assert told - told_0 == pytest.approx(state.ledger.air_taken - truth_0, rel=0.25)


def told_air(rig: Rig) -> list[float]:
    layout = rig.loop.layout
    return list(layout.named(rig.loop.row, "estimated_air"))


@pytest.mark.parametrize("name", ["paper-arm-fast", "paper-arm-tracking"])
def test_a_hold_keeps_the_air_and_the_joints_where_they_are_until_a_start(name: str) -> None:
    rig = Rig(load(name), np.zeros(2)).seconds(0.1)
    rig.host.demands = [0.6, -0.6]
    rig.seconds(0.15)
    rig.host.hold = True
    rig.cycles(1)
    assert rig.shows(RigState.HOLDING)
    held = rig.supervisor.demands.copy()
    rig.seconds(1.5)
    assert rig.supervisor.is_pressurised
    assert rig.supervisor.demands.tolist() == held.tolist()
    assert [state.motion.velocity for state in rig.bench.states] == pytest.approx([0.0, 0.0], abs=0.02)
    rig.host.demands = [0.1, 0.1]
    rig.seconds(0.2)
    assert rig.shows(RigState.HOLDING), "demands move nothing"
    rig.host.start = True
    rig.seconds(2.0)
    assert rig.shows(RigState.MOVING)
    assert [state.motion.angle for state in rig.bench.states] == pytest.approx([0.1, 0.1], abs=radians(1.0))
    assert rig.shows(Fault.NONE)


def test_a_controlled_stop_holds_centres_and_vents() -> None:
    rig = Rig(ARM, np.zeros(2)).seconds(0.1)
    rig.host.demands = [0.5, 0.5]
    rig.seconds(0.3)
    rig.host.stop = True
    acts = []
    for _ in range(500):
        rig.cycles(1)
        acts.append(rig.supervisor.valve_mode)
    assert list(dict.fromkeys(acts)) == [ValveMode.HOLD, ValveMode.CENTRE, ValveMode.VENT]
    assert acts.count(ValveMode.HOLD) * 0.005 == pytest.approx(ARM.safety.hold_time, abs=0.011)
    assert rig.shows(RigState.STOPPED)
    assert rig.supervisor.is_vented
    for state in rig.bench.states:
        assert max(state.hose_a.pressure, state.hose_b.pressure) < 1.1 * rig.bench.around.ambient_pressure
    assert rig.shows(Fault.NONE)
    rig.host.start = True
    rig.until(lambda: rig.supervisor.state is RigState.MOVING, 4.0)


def test_digital_outputs_that_were_on_when_the_device_dumped_come_on_by_the_host_alone() -> None:
    rig = Rig(ARM, np.zeros(2)).seconds(0.1)
    rig.host.switched = [(0, True), (2, True)]
    rig.cycles(1)
    assert rig.driver.commands[-1].outputs == 5
    rig.host.switched = [(0, False)]
    rig.cycles(2)
    assert rig.driver.commands[-1].outputs == 4
    assert rig.loop.layout.named(rig.host.rows[-1], "outputs") == 4
    rig.driver.device = DeviceState.DUMPED
    rig.host.switched = [(1, True)]
    rig.cycles(5)
    assert rig.driver.commands[-1].outputs == 0
    rig.driver.device = DeviceState.RUNNING
    assert rig.cycles(5).driver.commands[-1].outputs == 0
    rig.host.switched = [(2, True)]
    assert rig.cycles(1).driver.commands[-1].outputs == 4


def test_stale_setpoints_hold_and_then_vent() -> None:
    rig = Rig(ARM, np.zeros(2)).seconds(0.1)
    rig.host.age = 0.094
    rig.cycles(1)
    assert rig.shows(RigState.MOVING)
    rig.host.age = 0.0999
    rig.cycles(1)
    assert rig.supervisor.ledger.now is Fault.SETPOINT_STALE
    assert rig.shows(ValveMode.HOLD)
    rig.host.age = 0.0
    rig.seconds(2.5)
    assert rig.shows(RigState.STOPPED)
    assert rig.supervisor.is_vented


def test_stale_setpoints_in_a_fault_that_holds_vent_too() -> None:
    rig = Rig(ARM, np.zeros(2)).seconds(0.1)
    rig.driver.device = DeviceState.CENTRED
    rig.cycles(1)
    assert rig.shows(ValveMode.HOLD)
    rig.host.age = 1.0
    rig.seconds(1.0)
    assert rig.shows(ValveMode.VENT)


def test_a_dead_recorder_is_told_and_bars_a_start() -> None:
    rig = Rig(ARM, np.zeros(2)).seconds(0.2)
    rig.host.recording = False
    rig.seconds(0.2)
    assert rig.supervisor.ledger.now is Fault.RECORDER_DEAD
    assert rig.shows(RigState.MOVING)
    rig.host.stop = True
    rig.seconds(2.5)
    rig.host.start = True
    rig.seconds(0.1)
    assert rig.shows(RigState.STOPPED)
    rig.host.recording = True
    rig.seconds(0.2)
    rig.host.start = True
    rig.cycles(1)
    assert rig.shows(RigState.STARTING)


@pytest.mark.parametrize("outside", [radians(60.1), -radians(90.0), nan, float("inf")])
def test_a_demand_outside_is_refused(outside: float) -> None:
    rig = Rig(ARM, np.zeros(2)).seconds(0.1)
    rig.host.demands = [0.2, outside]
    rig.seconds(0.2)
    assert rig.supervisor.ledger.now is Fault.DEMAND_REFUSED
    assert rig.supervisor.demands.tolist() == [0.2, 0.0]
    assert sum("refused" in line for line in rig.host.lines) == 1
    assert rig.shows(RigState.MOVING)


@given(st.lists(st.floats(-1.2, 1.2) | st.just(nan), min_size=1, max_size=40), st.integers(1, 50))
def test_the_gate_lets_through_only_what_joints_can_follow(asked: list[float], each: int) -> None:
    lead, before = 0.5, GatedDemand(0.0, 0.0)
    for demand in asked:
        for _ in range(each):
            now, _ = follow_demand(GATE, before, demand, lead, 0.005)
            assert abs(now.demand) <= WORKING + 1e-9
            assert abs(now.demand - before.demand) <= lead + 1e-12
            turned_back = (now.demand - before.demand) * (before.demand - before.reference) < 0.0
            begin = before.demand if turned_back else before.reference
            assert abs(now.demand - begin) <= lead + 1e-12
            assert abs(now.reference - begin) <= SPEED * 0.005 + 1e-12
            before = now


def test_a_demand_that_turns_back_on_its_way_leaps_no_further_than_one_from_rest() -> None:
    now = GatedDemand(0.0, 0.0)
    for _ in range(20):
        now, _ = follow_demand(GATE, now, radians(50.0), radians(20.0), 0.005)
    back, _ = follow_demand(GATE, now, radians(-50.0), radians(20.0), 0.005)
    assert back.demand == pytest.approx(now.demand - radians(20.0))


def test_a_step_of_the_paper_passes_as_it_is_and_a_greater_one_is_limited() -> None:
    lead = ARM.safety.demand_step
    now, outcome = follow_demand(GATE, GatedDemand(0.0, 0.0), radians(40.0), lead, 0.005)
    assert (now.demand, outcome) == (radians(40.0), 0)
    now, outcome = follow_demand(GATE, GatedDemand(-radians(40.0), -radians(40.0)), radians(40.0), lead, 0.005)
    assert (now.demand, outcome) == (pytest.approx(radians(5.0)), DEMAND_LIMITED)
    for _ in range(200):
        now, outcome = follow_demand(GATE, now, radians(40.0), lead, 0.005)
    assert (now.demand, outcome) == (radians(40.0), 0)


def test_near_the_stops_demands_jump_less_and_the_moves_of_the_paper_pass_as_they_are() -> None:
    held = GatedDemand(-radians(20.0), -radians(20.0))
    assert ARM.safety.demand_margin * stop_margin(GATE, held, radians(20.0)) >= radians(40.0)
    held = GatedDemand(-radians(55.0), -radians(55.0))
    assert stop_margin(GATE, held, radians(20.0)) == pytest.approx(radians(15.0))
    assert stop_margin(GATE, held, nan) == pytest.approx(radians(15.0))


@pytest.mark.parametrize(
    "name", ["paper-arm", "paper-arm-fast", "paper-small-joint", "paper-large-joint", "earlier-actuator"]
)
def test_no_false_trip_in_minutes_of_random_moves(name: str) -> None:
    machine = load(name)
    n, rng = len(machine.joints), np.random.default_rng(7)
    rig = Rig(machine, np.zeros(n), seed=7)
    half = min(joint.stops.working_stroke for joint in machine.joints.values()) / 3
    while rig.bench.k * rig.bench.cycle < 60.0:
        rig.host.demands = list(half * rng.uniform(-1.0, 1.0, n))
        rig.bench.around = rig.bench.around._replace(payload=machine.arm.payload * rng.uniform(0.4, 1.6))
        rig.seconds(rng.uniform(1.0, 3.0))
        assert rig.shows(Fault.NONE), (rig.now, rig.host.lines[-3:])
    assert rig.shows(RigState.MOVING)


@pytest.mark.parametrize("name", ["paper-arm", "paper-arm-fast"])
@pytest.mark.parametrize("drift", [-0.4, 0.4])
def test_no_false_trip_with_a_shifted_centre(name: str, drift: float) -> None:
    rig = Rig(load(name), np.zeros(2), seed=1)
    rig.bench.drift[:] = drift
    for demand in ([0.5, -0.4], [-0.1, 0.3], [0.4, 0.5]):
        rig.host.demands = demand
        rig.seconds(2.0)
    assert rig.shows(Fault.NONE), rig.host.lines


@pytest.mark.parametrize("name", ["paper-arm", "paper-arm-fast"])
def test_no_false_trip_of_an_arm_that_differs_from_its_description(name: str) -> None:
    described = load(name)
    larger = changed(described, "valve.conductance", 1.25 * described.valve.conductance)  # type: ignore[union-attr]
    rig = Rig(larger, np.zeros(2), described=described)
    for demand in ([0.5, -0.4], [-0.1, 0.3], [0.4, 0.5], [0.0, 0.0]):
        rig.host.demands = demand
        rig.seconds(2.0)
    assert rig.shows(Fault.NONE), rig.host.lines


def test_the_loop_gives_the_trace_of_a_run_bit_for_bit() -> None:
    demand = np.zeros((500, 2))
    demand[:100], demand[100:300], demand[300:] = (-0.35, -0.35), (0.35, -0.35), (0.35, 0.35)
    run = rollout(ARM, demand, duration=2.5, seed=3)
    rig = Rig(ARM, demand[0], seed=3)
    for k in range(500):
        rig.host.demands = demand[k].tolist()
        rig.cycles(1)
    rows = np.array(rig.host.rows)
    layout = rig.loop.layout
    for name, at in layout.columns.items():
        if name not in {"joint_fault", "demand_velocity", "estimated_air"}:
            assert np.array_equal(layout.joint_rows(rows)[:, :, at], run[name].to_numpy()[:500]), name
