"""Control cycles without a controller: read, check that it is safe to go on, write."""

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

VENT_OPENING = 0.05  # opening to the exhaust at which the valve of a single hose rests: leaks would fill the hose


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
        self.is_single = np.array([joint.acting == "single" for joint in machine.joints.values()])  # (joints,)
        self.resting = self.centred - self.is_single * VENT_OPENING * self.span  # (joints,)
        self.sinking = find_sinking_joints(machine) & ~self.is_single  # joints that gravity moves at rest, (joints,)
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
