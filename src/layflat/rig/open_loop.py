"""Control cycles without a controller: read, check that it is safe to go on, write."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.rig.abilities import falls_without_air, find_sinking_joints, vent_time
from layflat.rig.clock import NS_PER_SECOND, Deadlines, LoopClock
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Driver, Lifecycle, LinkError, RigCommand, SensorReading
from layflat.rig.safety.core import RigNumbers
from layflat.rig.safety.detectors.sample import MOTION_LEVEL
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.limits import detector_limits
from layflat.rig.safety.state_machine import RESET_HIGH_CYCLES, RESET_LOW_CYCLES

MAX_TEST_ANGLE = np.radians(1.5)  # motion that ends a pulse; the joint moves on by some degrees, on the air it has
MAX_SINK_ANGLE = np.radians(15.0)  # the same of a joint that gravity moves
OPENING_RATE = 0.05  # of full opening, at which the valve opens; faster pulses throw a light joint further, 1/s
MAX_PULSE_TIME = 5.0  # within which a pulse has to move something, s
MIN_PRESSURE_RESPONSE = 0.1e5  # change of a differential pressure that is a response, Pa
BLOCKED_PRESSURE_FRACTION = 0.8  # of the supply's gauge pressure, at which a joint that does not move is blocked
AVERAGED_CYCLES = 4  # cycles over which samples are averaged: a period of the dither
REST_TIME = 1.0  # between two pulses, and after the soft start: hoses fill through the valves' leaks, s
# Diagnosis by the signs of the responses of the angle to pulses towards hose A and B, then of the pressure to both.
SIGN_DIAGNOSES: dict[tuple[int, ...], str] = {
    (1, 1, 1, 1): "",
    (-1, -1, -1, -1): "its valve goes the wrong way: swap its two hoses",
    (1, 1, -1, -1): "its pressure sensor goes the wrong way: swap its two lines",
    (-1, -1, 1, 1): "its angle sensor goes the wrong way: turn its sign",
    (0, 0, 0, 0): "nothing stirs: look at the plug of its valve, and at its lines",
}


class CheckResult(NamedTuple):
    """Result of one check."""

    what: str  # subject of the check
    finding: str  # finding, for people
    action: str = ""  # remedy; empty where the check passed

    @property
    def has_passed(self) -> bool:
        """Return whether the check passed."""
        return not self.action


class UnsafeError(LayflatError):
    """Fault that ends a check with air at once; the message names it."""


class OpenLoopRig:
    """Rig without a controller: a configured driver, the deadlines of its cycles, and statistics of the link."""

    def __init__(self, machine: Machine, driver: Driver, clock: LoopClock) -> None:
        self.machine, self.driver, self.clock = machine, driver, clock
        self.names = list(machine.joints)
        self.cycle = machine.cycle
        self.limits = [detector_limits(machine, name) for name in self.names]
        valve, self.angle_part, self.pressure_part = valve_and_sensors(machine)
        self.span = valve.volts_to_full
        self.centred = np.full(len(self.names), valve.centre_voltage)
        self.sinking = find_sinking_joints(machine)  # joints that gravity moves, (joints,)
        self.deadlines = Deadlines(clock, self.cycle)
        self.transactions: list[float] = []  # time that each took, s
        self.failures: list[LinkError] = []  # transactions without a good reply
        self._numbers = RigNumbers(machine)
        self._judge = self._numbers.bind_detectors(MOTION_LEVEL)
        self._numbers.inputs["elapsed"][0] = self.cycle
        self._obeyed = False

    def cycles(self, seconds: float) -> int:
        """Return the number of control cycles in a time (s), to the nearest."""
        return round(seconds / self.cycle)

    def read(self) -> SensorReading | None:
        """Wait for the next cycle and read; return None where the reply was lost, and add its error to `failures`."""
        self.deadlines.wait()
        begun = self.clock.now()
        try:
            reading = self.driver.read()
        except LinkError as error:
            self.failures.append(error)
            reading = None
        self.transactions.append((self.clock.now() - begun) / NS_PER_SECOND)
        return reading

    def act(self, voltages: Array, *, reset: bool = False) -> SensorReading:
        """Read, check the reading for faults, and write voltages with air on; repeat until a reply is not lost.

        Args:
            voltages: V, (joints,).
            reset: whether to set the reset bit of the command.

        Returns:
            The reading of the last cycle.

        Raises:
            UnsafeError: a fault was detected, or `Fault.LINK_LOST.cycles` replies in succession were lost.
        """
        lost = 0
        while True:
            if (reading := self.read()) is not None:
                self._check_reading(reading)
            elif (lost := lost + 1) >= Fault.LINK_LOST.cycles:
                raise UnsafeError(Fault.LINK_LOST.title)
            self.driver.write(RigCommand(voltages.copy(), air=True, reset=reset))
            if reading is not None:
                return reading

    def stay_centred(self, seconds: float) -> None:
        """Keep the valves centred with air on for a time, s; errors as from `act`."""
        for _ in range(self.cycles(seconds)):
            self.act(self.centred)

    def vent(self) -> None:
        """Switch the air off, wait until the hoses are empty, and deactivate the driver.

        Valves are centred for 0.1 s, then opened to one end; those of an arm that would fall stay centred. It has no
        effect unless the driver is active.
        """
        if self.driver.state is not Lifecycle.ACTIVE:
            return
        opened = self.centred if falls_without_air(self.machine) else self.centred + self.span
        for voltages, seconds in ((self.centred, 0.1), (opened, vent_time(self.machine))):
            for _ in range(self.cycles(seconds)):
                self.read()
                self.driver.write(RigCommand(voltages.copy(), air=False))
        self.driver.deactivate()

    def _check_reading(self, reading: SensorReading) -> None:
        """Raise UnsafeError for the first fault of a reading: of the rig, its device, its e-stop or a joint."""
        self._numbers.load_reading(reading)
        self._numbers.inputs["supply"][0] = reading.supply
        self._judge()
        fault, faults = self._numbers.detected_faults
        self._obeyed = self._obeyed or reading.device is DeviceState.RUNNING
        if self._obeyed and reading.device is not DeviceState.RUNNING:
            fault = Fault.DEVICE_DUMPED if reading.device is DeviceState.DUMPED else Fault.DEVICE_CENTRED
        if reading.stopped:
            fault = Fault.E_STOP
        if fault:
            raise UnsafeError(fault.title)
        for name, joint_fault in zip(self.names, faults, strict=True):
            if joint_fault:
                raise UnsafeError(f"joint {name!r}: {joint_fault.title}")


class ValvePulse(NamedTuple):
    """Response to a pulse, which opens a valve slowly in one direction."""

    direction: int  # 1: fills hose A, -1: fills hose B
    opening: float  # reached, as a fraction of full opening
    angles: Array  # changes, rad, (joints,)
    pressures: Array  # changes, Pa, (joints,)


def check_signs(bench: OpenLoopRig, tell: Callable[[str], object] = str) -> list[CheckResult]:
    """Supply air to a rig that passed the checks without, test the signs of every joint, and vent it in any case.

    `tell` is called with the name of each step. A fault ends the test: it is the last result, no error.
    """
    findings: list[CheckResult] = []
    bench.driver.activate()
    try:
        tell("soft start")
        findings.append(_supply_air(bench))
        if findings[-1].has_passed:
            for joint, name in enumerate(bench.names):
                tell(f"joint {name}")
                findings.append(
                    judge_pulses([_apply_pulse(bench, joint, sign) for sign in (1, -1)], joint, bench.names)
                )
    except UnsafeError as error:
        findings.append(CheckResult("ended early", str(error), "find the cause; the air was vented"))
    finally:
        tell("venting the air")
        bench.vent()
    return findings


def _supply_air(bench: OpenLoopRig) -> CheckResult:
    """Supply air with centred valves; return the result: the time until it is ready, or failure after `start_time`.

    Errors as from `OpenLoopRig.act`.
    """
    safety, supply = bench.machine.safety, bench.machine.supply
    ready, edge = (
        supply.ambient_pressure + safety.supply_ready * supply.pressure_gauge,
        RESET_LOW_CYCLES + RESET_HIGH_CYCLES,
    )
    for k in range(edge):
        reading = bench.act(bench.centred, reset=k >= RESET_LOW_CYCLES)
    for took in range(edge + 1, bench.cycles(safety.start_time) + 2):
        reading = bench.act(bench.centred)
        if reading.supply >= ready:
            bench.stay_centred(REST_TIME)
            return CheckResult("air", f"there {took * bench.cycle:.2f} s after it was asked for")
    gauge = (reading.supply - supply.ambient_pressure) / 1e5
    right = "look at compressor, regulator, dump valve and the sensor behind it"
    return CheckResult("air", f"{gauge:.2f} bar after {safety.start_time:g} s", right)


def _apply_pulse(bench: OpenLoopRig, joint: int, direction: int) -> ValvePulse:
    """Open a valve slowly until any joint moves, a pressure nears the supply's, or `MAX_PULSE_TIME` is over; centre it.

    Return the response at the end of the opening, after `REST_TIME` with centred valves; errors as from `act`. Joints
    that gravity moves may sink by `MAX_SINK_ANGLE` before they count as moving.
    """
    recent = [bench.act(bench.centred) for _ in range(AVERAGED_CYCLES)]
    angles, pressures = np.mean([r.angles for r in recent], axis=0), np.mean([r.pressures for r in recent], axis=0)
    voltages, opening = bench.centred.copy(), 0.0
    is_tested = np.arange(len(bench.names)) == joint
    for k in range(bench.cycles(MAX_PULSE_TIME)):
        opening = OPENING_RATE * (k + 1) * bench.cycle
        voltages[joint] = bench.centred[joint] + direction * opening * bench.span
        recent = [*recent[1:], bench.act(voltages)]
        change = np.mean([r.pressures for r in recent], axis=0) - pressures
        blocked = np.abs(change).max() > BLOCKED_PRESSURE_FRACTION * bench.machine.supply.pressure_gauge
        # Joints sink while hoses fill and leak: the valve causes such a motion if the joint's pressure responds.
        sinks = bench.sinking & ~(is_tested & (np.abs(change) > MIN_PRESSURE_RESPONSE))
        if blocked or (np.abs(recent[-1].angles - angles) > np.where(sinks, MAX_SINK_ANGLE, MAX_TEST_ANGLE)).any():
            break
    pulse = ValvePulse(direction, opening, recent[-1].angles - angles, change)
    bench.stay_centred(REST_TIME)
    return pulse


def judge_pulses(pulses: list[ValvePulse], joint: int, names: list[str]) -> CheckResult:
    """Return the result of the check of a joint's valve and sensors by their signs.

    Args:
        pulses: responses to two pulses, one in each direction.
        joint: number of the joint whose valve was opened.
        names: names of the joints, from base to tip.
    """
    turned = [_sign(pulse.direction * pulse.angles[joint], MAX_TEST_ANGLE / 2) for pulse in pulses]
    pressed = [_sign(pulse.direction * pulse.pressures[joint], MIN_PRESSURE_RESPONSE) for pulse in pulses]
    if other := _find_responding_joint(pulses, joint, names):
        wrong = f"its valve moves {other}: swap their plugs or hoses"
    elif not any(turned):
        wrong = "it does not turn: it is blocked, or its angle sensor is loose"
    elif not any(pressed):
        wrong = "its pressure does not answer: look at the pressure sensor's lines"
    else:
        wrong = "it does not go one way with its valve: look at the valve's centre, and for leaks"
    responses = "; ".join(
        f"{pulse.direction * 100 * pulse.opening:+.1f} % open gave {pulse.pressures[joint] / 1e5:+.2f} bar, "
        f"{np.degrees(pulse.angles[joint]):+.1f} deg"
        for pulse in pulses
    )
    return CheckResult(
        f"signs of {names[joint]}", responses, wrong if other else SIGN_DIAGNOSES.get((*turned, *pressed), wrong)
    )


def _find_responding_joint(pulses: list[ValvePulse], joint: int, names: list[str]) -> str:
    """Return the name of another joint that answers: the first with the greatest pressure change of a pulse; else ''.

    That change must exceed 3 times the tested joint's, and 3 times `MIN_PRESSURE_RESPONSE`.
    """
    for pulse in pulses:
        strongest = int(np.abs(pulse.pressures).argmax())
        response = abs(pulse.pressures[strongest])
        tested = abs(pulse.pressures[joint])
        if strongest != joint and response > 3.0 * MIN_PRESSURE_RESPONSE and tested < response / 3.0:
            return names[strongest]
    return ""


def _sign(value: float, threshold: float) -> int:
    """Return 1 or -1, the sign of a value of at least the threshold; 0 below it."""
    return int(np.sign(value)) if abs(value) >= threshold else 0
