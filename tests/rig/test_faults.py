"""Every fault of the table: found in time, and what is done about it."""

from collections.abc import Callable

import numpy as np
import pytest

from layflat.machine import changed, load
from layflat.rig.device_state import DeviceState
from layflat.rig.safety.faults import Fault, Reaction, RigState, ValveMode
from layflat.rig.safety.state_machine import CENTRED_TIME
from tests.rig.fake_rig import Array, Rig

ARM = load("paper-arm-fast")
VENT = 10.0
CENTRE = 5.0


def moving(seed: int = 0, settle: float = 0.35) -> Rig:
    """The elbow amid a move."""
    rig = Rig(ARM, np.zeros(2), seed=seed).seconds(0.1)
    rig.host.demands = [0.0, -0.6]
    rig.seconds(settle)
    return rig


def found(rig: Rig, most: float) -> float:
    return rig.until(lambda: rig.supervisor.ledger.latched > Fault.NONE, most)


def put_angles(joint: int, value: float) -> Callable[[Array, Array], None]:
    return lambda angles, _: angles.__setitem__(joint, value)


def put_pressures(joint: int, value: float) -> Callable[[Array, Array], None]:
    return lambda _, pressures: pressures.__setitem__(joint, value)


def freeze_angle(rig: Rig) -> None:
    at = float(rig.host.rows[-1][13 + 13 + 2])
    rig.driver.spoil = put_angles(1, at)


def freeze_pressure(rig: Rig) -> None:
    at = float(rig.host.rows[-1][13 + 13 + 3])
    rig.driver.spoil = put_pressures(1, at)


def rail(rig: Rig) -> None:
    rig.driver.spoil = put_angles(1, np.radians(75.0))


def no_angle(rig: Rig) -> None:
    rig.driver.spoil = put_angles(1, np.nan)


def runaway(rig: Rig) -> None:
    rig.driver.spoil = lambda angles, _: angles.__setitem__(1, -0.5 + 0.2 * (rig.bench.k % 6))


def outside(rig: Rig) -> None:
    rig.driver.spoil = put_angles(1, np.radians(70.5))


def high_pressure(rig: Rig) -> None:
    rig.driver.spoil = put_pressures(1, 5e5)


def supply(bar: float) -> Callable[[Rig], None]:
    return lambda rig: setattr(rig.driver, "supply", 1e5 * bar)


def still_air(rig: Rig) -> None:
    """The dither's driver is dead: both spools stay in the middle."""
    rig.bench.held[:] = 0.0


def stuck(opening: float) -> Callable[[Rig], None]:
    return lambda rig: rig.bench.held.__setitem__(1, opening)


def burst(hose: int) -> Callable[[Rig], None]:
    return lambda rig: rig.bench.escaping.__setitem__((1, hose), 0.15)


def kinked(rig: Rig) -> None:
    rig.bench.kink(1, 0.05)


def link(rig: Rig) -> None:
    rig.driver.link = "crc"


def device(state: DeviceState) -> Callable[[Rig], None]:
    return lambda rig: setattr(rig.driver, "device", state)


def e_stop(rig: Rig) -> None:
    rig.driver.stopped = True


CASES = [
    ("angle at rail", rail, Fault.ANGLE_AT_RAIL, ValveMode.VENT_JOINT),
    ("angle not a number", no_angle, Fault.ANGLE_AT_RAIL, ValveMode.VENT_JOINT),
    ("pressure frozen", freeze_pressure, Fault.PRESSURE_FROZEN, ValveMode.VENT_JOINT),
    ("spool stuck in the middle", stuck(0.0), Fault.VALVE_UNRESPONSIVE, ValveMode.VENT),
    ("spool stuck open", stuck(1.0), Fault.VALVE_UNRESPONSIVE, ValveMode.VENT),
    ("hose A burst", burst(0), Fault.VALVE_UNRESPONSIVE, ValveMode.VENT),
    ("hose B burst", burst(1), Fault.VALVE_UNRESPONSIVE, ValveMode.VENT),
    ("over-speed", runaway, Fault.OVER_SPEED, ValveMode.VENT),
    ("outside", outside, Fault.OUTSIDE_STROKE, ValveMode.VENT),
    ("supply too high", supply(6.5), Fault.OVER_PRESSURE, ValveMode.VENT),
    ("differential pressure too high", high_pressure, Fault.OVER_PRESSURE, ValveMode.VENT),
    ("supply low", supply(2.0), Fault.SUPPLY_LOST, ValveMode.VENT),
    ("supply unknown", supply(float("nan")), Fault.OVER_PRESSURE, ValveMode.VENT),
    ("no ripple anywhere", still_air, Fault.SUPPLY_LOST, ValveMode.VENT),
    ("link", link, Fault.LINK_LOST, ValveMode.VENT),
    ("device centred", device(DeviceState.CENTRED), Fault.DEVICE_CENTRED, ValveMode.HOLD),
    ("device dumped", device(DeviceState.DUMPED), Fault.DEVICE_DUMPED, ValveMode.VENT),
    ("e-stop", e_stop, Fault.E_STOP, ValveMode.VENT),
]


EMPTIES = CENTRED_TIME + 0.01
"""In which the supply line is let out, before valves are opened, s."""


@pytest.mark.parametrize(("what", "fail", "fault", "act"), CASES, ids=[case[0] for case in CASES])
@pytest.mark.parametrize("settle", [0.08, 0.35])
def test_found_in_time_and_latched(
    what: str, fail: Callable[[Rig], None], fault: Fault, act: ValveMode, settle: float
) -> None:
    rig = moving(settle=settle)
    assert rig.shows(Fault.NONE)
    fail(rig)
    took = rig.until(lambda: rig.supervisor.ledger.latched is fault, 1.0)
    assert rig.shows(fault), rig.host.lines
    assert took <= (fault.seconds or fault.cycles * 0.005) + 1e-9
    assert rig.shows(RigState.FAULT)
    command = rig.driver.commands[-1]
    assert command.air is (act is ValveMode.HOLD)
    if act is not ValveMode.HOLD:
        if fault is Fault.VALVE_UNRESPONSIVE:
            assert command.voltages[0] == CENTRE
            assert command.voltages[1] in {CENTRE - 5.0, CENTRE + 5.0}, "the fuller hose is let out at once"
        else:
            assert list(command.voltages) == [CENTRE, CENTRE], "what is shut in brakes until the line is empty"
        rig.seconds(EMPTIES)
        command = rig.driver.commands[-1]
    assert rig.shows(act)
    if act is ValveMode.VENT:
        assert list(command.voltages) == [VENT, VENT]
    if act is ValveMode.VENT_JOINT:
        assert list(command.voltages) == [CENTRE, VENT]
        assert [bool(f) for f in rig.supervisor.ledger.joints] == [False, True]


def freeze_during_a_move(seed: int, after: float) -> tuple[Rig, float]:
    """A sensor of the elbow's angle that freezes some time after a demand; how long it then takes to be found."""
    rig = Rig(ARM, np.zeros(2), seed=seed).seconds(0.5)
    rig.host.demands = [0.0, 0.6]
    rig.seconds(after)
    freeze_angle(rig)
    return rig, found(rig, 3.0)


@pytest.mark.parametrize("after", [0.0, 0.03, 0.06, 0.1, 0.15, 0.2])
def test_a_frozen_angle_is_found_while_its_joint_moves(after: float) -> None:
    rig, took = freeze_during_a_move(3, after)
    assert rig.shows(Fault.ANGLE_FROZEN), (took, rig.host.lines)
    # Where the joint had not set off yet, it has to be driven for some time first.
    assert took <= (Fault.ANGLE_FROZEN.seconds if 0.08 <= after <= 0.15 else 0.3)
    rig.seconds(EMPTIES)
    assert rig.shows(ValveMode.VENT_JOINT)


def test_a_kinked_hose_is_found_as_soon_as_its_valve_is_driven() -> None:
    rig = moving()
    kinked(rig)
    rig.seconds(0.5)
    rig.host.demands = [0.0, 0.0]
    assert found(rig, 1.0) <= Fault.VALVE_UNRESPONSIVE.seconds
    assert rig.shows(Fault.VALVE_UNRESPONSIVE)


def test_every_fault_has_a_row_and_severity_grows_with_its_number() -> None:
    assert [int(fault) for fault in Fault] == list(range(len(Fault)))
    reactions = [fault.reaction for fault in Fault]
    assert reactions == sorted(reactions)
    assert all(fault.title and (fault.seconds > 0.0 or fault.cycles > 0) for fault in Fault if fault)


def test_a_law_that_gives_up_is_told_and_tries_again_with_another_demand() -> None:
    described = load("paper-arm-tracking")
    rig = Rig(changed(described, "arm.payload", "12 kg"), np.zeros(2), described=described).seconds(0.1)
    rig.host.demands = [0.5, -0.5]
    rig.until(lambda: rig.supervisor.ledger.now is Fault.MODEL_DOUBTED, 1.5)
    rig.seconds(0.2)
    assert rig.shows(RigState.MOVING, Fault.MODEL_DOUBTED)
    assert list(rig.driver.commands[-1].voltages) == [CENTRE, CENTRE]
    assert sum(Fault.MODEL_DOUBTED.title in line for line in rig.host.lines) == 1
    rig.host.demands = [0.0, 0.0]
    rig.until(lambda: list(rig.driver.commands[-1].voltages) != [CENTRE, CENTRE], 0.5)
    assert rig.shows(Fault.NONE)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 10.001, -0.001])
def test_a_bad_voltage_never_leaves(bad: float) -> None:
    rig = moving()
    core = rig.supervisor.core
    core.between = lambda: core.law_voltages.__setitem__(1, bad)
    rig.cycles(1)
    assert rig.shows(Fault.BAD_COMMAND)
    assert rig.driver.commands[-1].voltages[1] == CENTRE
    assert rig.shows(ValveMode.HOLD)
    core.between = None
    rig.seconds(0.5)
    assert rig.shows(ValveMode.HOLD)
    assert core.law is not None
    assert np.isfinite(core.law.memory.array).all()
    assert all(0.0 <= v <= 10.0 for command in rig.driver.commands for v in command.voltages)


def test_one_lost_reply_is_told_and_forgiven() -> None:
    rig = moving()
    link(rig)
    rig.cycles(2)
    assert rig.supervisor.ledger.worst.name == "REPLY_LOST"
    rig.driver.link = None
    rig.seconds(1.0)
    assert rig.shows(RigState.MOVING)
    assert rig.supervisor.ledger.worst.name == "NONE"
    assert Fault.REPLY_LOST.title in rig.host.lines


def test_a_blocked_joint_is_held_where_it_is() -> None:
    machine = ARM
    rig = Rig(machine, np.zeros(2)).seconds(0.1)
    rig.host.demands = [0.0, 0.75]
    rig.bench.brakes[1] = 4.0
    rig.bench.load[1] = -16.0
    took = rig.until(lambda: rig.supervisor.ledger.latched > Fault.NONE, 2.0)
    assert rig.shows(Fault.FOLLOWING_ERROR)
    assert took > 0.3
    assert rig.shows(ValveMode.HOLD)
    assert rig.supervisor.demands[1] == pytest.approx(rig.bench.states[1].motion.angle, abs=0.1)


def test_the_worst_wins_and_a_milder_one_does_not_bring_back_the_air() -> None:
    rig = moving()
    device(DeviceState.CENTRED)(rig)
    rig.cycles(1)
    assert rig.shows(ValveMode.HOLD)
    rail(rig)
    rig.cycles(3)
    rig.seconds(EMPTIES)
    assert rig.shows(ValveMode.VENT_JOINT)
    e_stop(rig)
    rig.cycles(1)
    assert rig.shows(ValveMode.VENT)
    assert rig.supervisor.ledger.reaction is Reaction.DUMP
    rig.driver.stopped = False
    rig.seconds(1.0)
    assert rig.shows(Fault.E_STOP)
    assert not rig.driver.commands[-1].air


def test_a_reset_needs_an_edge_and_the_fault_to_be_gone() -> None:
    rig = moving()
    e_stop(rig)
    rig.cycles(1)
    rig.host.reset = True
    rig.cycles(1)
    assert rig.shows(RigState.FAULT)
    rig.driver.stopped = False
    rig.seconds(3.0)
    assert rig.shows(RigState.FAULT)
    rig.host.reset = True
    rig.cycles(1)
    assert rig.shows(RigState.OFF)
    assert not rig.supervisor.is_pressurised
    rig.seconds(1.0)
    assert rig.shows(RigState.OFF)
    resets = [command.reset for command in rig.driver.commands]
    assert any(resets)
    assert not resets[-1]


def test_after_a_hold_a_reset_holds_and_a_start_goes_on() -> None:
    rig = moving()
    device(DeviceState.CENTRED)(rig)
    rig.cycles(2)
    rig.driver.device = DeviceState.RUNNING
    rig.cycles(2)
    rig.host.reset = True
    rig.cycles(2)
    assert rig.shows(RigState.HOLDING)
    rig.host.start = True
    rig.cycles(2)
    assert rig.shows(RigState.MOVING)
