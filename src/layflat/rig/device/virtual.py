"""Virtual device: it obeys while commands come, and enters a safe state by itself when they do not.

    running --silence of some cycles--> centred --longer silence--> dumped --reset--> running
       ^------------a command-------------|              ^
       '------ e-stop, from any state -------------------'

Dumped is latched: only the edge of a reset with the e-stop released ends it, and a device that was just switched on
has to read the reset low first. Dumped, the supply line is open to the atmosphere; once it is empty, every valve is
opened fully to one end: a joint's hose A vents through the line, its hose B through the exhaust. Those of an arm that
would fall stay centred: their leakage lowers it slowly. Digital outputs are off while it is dumped.
"""

from enum import Enum
from math import exp, inf, log

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.physics.driven import MachinePlant
from layflat.physics.sensor import read_sensor
from layflat.rig.abilities import falls_without_air
from layflat.rig.clock import NS_PER_SECOND, LoopClock
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Capabilities, Driver, Lifecycle, LinkError, RigCommand, SensorReading
from layflat.rig.wire import Wire

ARRIVAL_PRESSURE = 1.0  # distance from its target at which a line has arrived, Pa
SOFT_TIME, FILL_TIME, DUMP_TIME = 0.3, 0.02, 0.03  # T of a soft start, an open dump valve, and venting, s
FULL_OPENING_FRACTION = 0.5  # of the regulator's gauge pressure, at which the dump valve opens fully
ANGLE, PRESSURE = 0, 1  # numbers of the two sensors of a joint
LINE_EMPTY_TIME = 3 * NS_PER_SECOND // 10  # until valves open to a vented line; enclosed air stops the joints first, ns
PLANT_STEP = NS_PER_SECOND // 1000  # step of the plant while the supply's pressure changes, ns


class SupplyLine:
    """Supply line with its pressure over time; pressures are absolute, Pa. With air on it starts full, else empty.

    p' = (p_0 - p)/T. While air is on p_0 is the regulator's pressure, and T is long up to a share of the gauge
    pressure, short above it: a soft start, as ISO 4414 asks for. While it is off the line is open to the atmosphere.
    """

    def __init__(self, regulator: float, ambient: float, *, air: bool = False) -> None:
        self.regulator, self.ambient, self.air = regulator, ambient, air
        self.pressure = self.target

    @property
    def target(self) -> float:
        """Return the pressure that the line approaches, Pa."""
        return self.regulator if self.air else self.ambient

    @property
    def is_steady(self) -> bool:
        """Return whether the pressure has reached its target."""
        return self.pressure == self.target

    def advance(self, seconds: float) -> None:
        """Advance the pressure by a time, s, with the time constant of the phase: venting, soft start or open valve."""
        if not self.air:
            self._approach(self.ambient, seconds / DUMP_TIME)
            return
        opens = self.ambient + FULL_OPENING_FRACTION * (self.regulator - self.ambient)
        if self.pressure < opens:
            soft = SOFT_TIME * log((self.regulator - self.pressure) / (self.regulator - opens))
            if soft > seconds:
                self._approach(self.regulator, seconds / SOFT_TIME)
                return
            self.pressure, seconds = opens, seconds - soft
        self._approach(self.regulator, seconds / FILL_TIME)

    def _approach(self, end: float, time_constants: float) -> None:
        """Approach a pressure for a number of time constants; within `ARRIVAL_PRESSURE` it is reached."""
        pressure = end + (self.pressure - end) * exp(-time_constants)
        self.pressure = end if abs(pressure - end) < ARRIVAL_PRESSURE else pressure


class ReplyFault(Enum):
    """Fault of a reply."""

    LOST = "lost"
    CRC = "crc"
    SEQUENCE = "sequence"
    LATE = "late"


class DeviceLink:
    """Link of a device, without a fault until some are set.

    A faulty reply follows a command that was received. While the link is silent, commands are not received either.
    """

    def __init__(self) -> None:
        self.mend()

    def spoil(self, kind: ReplyFault, replies: float = inf) -> None:
        """Set the fault of a number of coming replies, by default of all; it replaces an earlier fault."""
        self._kind, self._left = kind, replies

    def mend(self) -> None:
        """Clear all faults."""
        self.silent, self._kind, self._left = False, ReplyFault.LOST, 0.0

    def next(self) -> ReplyFault | None:
        """Return the fault of the coming reply, which then counts as sent; None where it is sent unchanged."""
        if self.silent:
            return ReplyFault.LOST
        if self._left < 1.0:
            return None
        self._left -= 1.0
        return self._kind


class SensorConverters:
    """Converters of a machine's sensors, without a failure until some are set."""

    def __init__(self, machine: Machine) -> None:
        self._sensors = [(joint.angle_sensor, joint.pressure_sensor) for joint in parameters.joints(machine)]
        self._fixed: dict[tuple[int, int], float | None] = {}

    def fail(self, joint: int, sensor: int, rail: int | None = None) -> None:
        """Fix the report of a sensor.

        Args:
            joint: number of the joint.
            sensor: ANGLE or PRESSURE.
            rail: end of the range that is reported, 0 low or 1 high; None: the next sample is repeated.
        """
        far = None if rail is None else (-1e9, 1e9)[rail]
        self._fixed[joint, sensor] = None if far is None else float(read_sensor(self._sensors[joint][sensor], far, 0.0))

    def mend(self, joint: int, sensor: int) -> None:
        """Report the samples of a sensor again."""
        self._fixed.pop((joint, sensor), None)

    def convert(self, *samples: Array) -> None:
        """Replace the values of failed converters in angles and pressures, (joints,) each, in place.

        A converter that repeats its next sample keeps the value of the first call.
        """
        for (joint, sensor), value in self._fixed.items():
            if value is None:
                self._fixed[joint, sensor] = float(samples[sensor][joint])
            else:
                samples[sensor][joint] = value


class VirtualDevice:
    """Remote I/O station or microcontroller with a machine behind it.

    As a real one it starts dumped with an empty line (the plant's hoses keep their state), unless it is `running`, as a
    rollout starts. The plant's time passes with the clock; `link` and `converters` set the faults of wire and sensors.

    Raises:
        MachineError: the machine has no valve or sensors.
    """

    def __init__(self, machine: Machine, plant: MachinePlant, clock: LoopClock, *, running: bool = False) -> None:
        self.plant, self.clock, self.link, self.converters = plant, clock, DeviceLink(), SensorConverters(machine)
        self.line = SupplyLine(machine.supply.pressure, machine.supply.ambient_pressure, air=running)
        self.capabilities = Capabilities.required_by(machine)._replace(
            dithers=True, shortest_cycle=1e-3, lets_down=True
        )
        self.set_gauge = machine.supply.pressure_gauge  # of the regulator, Pa
        constants = np.array([parameters.torque_constant(joint) for joint in machine.joints.values()])
        self.strengths = self.set_gauge * constants  # greatest torque of each joint, N m
        self.brakes = np.array([joint.brake.torque for joint in machine.joints.values()])  # what they hold, N m
        self._centred = np.full(len(machine.joints), self.capabilities.centre_voltage)
        self._open = (
            self._centred if falls_without_air(machine) else np.full_like(self._centred, self.capabilities.voltage_high)
        )
        self._until_dump = round(machine.interface.dump_after * NS_PER_SECOND)
        self._until_centre = min(
            round(machine.interface.watchdog_cycles * machine.cycle * NS_PER_SECOND), self._until_dump
        )
        self._supply = Wire.for_machine(machine).supply
        self._at = self._last_command = clock.now()
        self._begin = self._at - round(plant.time * NS_PER_SECOND)
        self._stopped, self._reset = False, True
        self.output_names, self.outputs = machine.interface.outputs, 0  # names, and those that are on, as bits
        self._vent_instant: int | None = None
        self.state = DeviceState.RUNNING if running else DeviceState.DUMPED
        plant.supply = self.line.pressure
        plant.drive(self._centred if running else self._open)

    @property
    def stopped(self) -> bool:
        """Return whether the e-stop is pressed; pressing it dumps at once, releasing it changes nothing else."""
        return self._stopped

    @stopped.setter
    def stopped(self, pressed: bool) -> None:
        self.tick()
        self._stopped = pressed
        if pressed:
            self._dump()

    def obey(self, command: RigCommand) -> None:
        """Receive a command at this instant: obey it, and restart the watchdog; one that is not finite is ignored.

        A dumped device only obeys at the rising edge of `reset` with the e-stop released.
        """
        self.tick()
        if not np.isfinite(command.voltages).all():
            return
        edge, self._reset = command.reset and not self._reset, command.reset
        self._last_command = self._at
        if self.state is DeviceState.DUMPED and not (edge and not self._stopped):
            return
        self.state, self._vent_instant = DeviceState.RUNNING, None
        self.line.air, self.outputs = command.air, command.outputs
        self.plant.drive(command.voltages)

    def reading(self) -> SensorReading:
        """Return the readings of the converters at this instant."""
        self.tick()
        angles, pressures = self.plant.sense()
        self.converters.convert(angles, pressures)
        supply = self._supply.value(self._supply.count(self.line.pressure))
        return SensorReading(angles, pressures, supply, self._stopped, self.state)

    def tick(self) -> None:
        """Advance to the present time, with the watchdog's actions on the way."""
        now = self.clock.now()
        while self.state is not DeviceState.DUMPED:
            running = self.state is DeviceState.RUNNING
            due = self._last_command + (self._until_centre if running else self._until_dump)
            if due > now:
                break
            self._pass(due)
            if due >= self._last_command + self._until_dump:
                self._dump()
            else:
                self.state = DeviceState.CENTRED
                self.plant.drive(self._centred)
        if self._vent_instant is not None and self._vent_instant <= now:
            self._pass(self._vent_instant)
            self._vent_instant = None
            self.plant.drive(self._open)
        self._pass(now)

    def _dump(self) -> None:
        """Dump: shut off the air, switch all outputs off, centre the valves, and schedule their opening.

        They open `LINE_EMPTY_TIME` later; that time stays if the device has dumped already.
        """
        if self.state is not DeviceState.DUMPED:
            self._vent_instant = self._at + LINE_EMPTY_TIME
        if self.state is DeviceState.RUNNING:
            self.plant.drive(self._centred)
        self.state = DeviceState.DUMPED
        self.line.air, self.outputs = False, 0

    def _pass(self, until: int) -> None:
        """Advance plant and line to an instant, ns."""
        while not self.line.is_steady and self._at < until:
            at = min(self._at + PLANT_STEP, until)
            self.line.advance((at - self._at) / NS_PER_SECOND)
            self.plant.supply = self.line.pressure
            self.plant.advance((at - self._begin) / NS_PER_SECOND)
            self._at = at
        if self._at < until:
            self.plant.advance((until - self._begin) / NS_PER_SECOND)
            self._at = until


class SimulatedDriver(Driver):
    """Driver of a virtual rig in this process; its clock should be the loop's. Voltages act as soon as written."""

    def __init__(self, device: VirtualDevice) -> None:
        super().__init__()
        self.device = device

    def read(self) -> SensorReading:
        """Return the present readings of the sensors; raise LinkError if a fault of the link is set."""
        spoilt = self.device.link.next()
        if spoilt is not None:
            raise LinkError("lost" if spoilt is ReplyFault.LATE else spoilt.value)
        return self.device.reading()

    def write(self, command: RigCommand) -> None:
        """Send a command, which is obeyed at once; raise DriverError if the driver is not active."""
        self._expect("write", Lifecycle.ACTIVE)
        self._send(command)

    def _send(self, command: RigCommand) -> None:
        """Pass a command to the device, unless the link is silent."""
        if not self.device.link.silent:
            self.device.obey(command)

    def _configure(self) -> Capabilities:
        return self.device.capabilities

    def _deactivate(self) -> None:
        """Centre the valves and switch the air off, unless the link is silent."""
        limits = self.device.capabilities
        self._send(RigCommand(np.full(limits.joints, limits.centre_voltage), air=False))
