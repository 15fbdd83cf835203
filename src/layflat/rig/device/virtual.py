"""The device at the other end of the wires: it obeys while it is commanded, and makes safe by itself when it is not.

    running --silence of some cycles--> centred --longer silence--> dumped --reset--> running
       ^------------a command-------------|              ^
       '------ e-stop, from any state -------------------'

Dumped is latched: only the edge of a reset with the e-stop released ends it, and a device that was just switched on
has to see the reset low first. Dumped, the supply line is open to the atmosphere; once it is empty, every valve is
opened fully to one end: a joint's hose A lets go through the line, its hose B through the exhaust. Those of an arm that
would fall stay centred: what they pass as they dither lets it down slowly. Digital outputs are off while it is dumped.
"""

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.physics.driven import Plant
from layflat.physics.sensor import read_sensor
from layflat.rig.abilities import falls
from layflat.rig.clock import SECOND, Clock
from layflat.rig.device.link import Link
from layflat.rig.device.supply import SupplyLine
from layflat.rig.driver import Capabilities, Command, DeviceState, Reading
from layflat.rig.wire.content import Wire

ANGLE, PRESSURE = 0, 1  # the two sensors of a joint
EMPTIES = 3 * SECOND // 10  # ns until valves open to a line that is let out; what is shut in stops the joints meanwhile
CHUNK = SECOND // 1000  # ns: while the supply's pressure changes, the plant is moved on by so much at a time


class Converters:
    """Sound converters of a machine's sensors, until told otherwise."""

    def __init__(self, machine: Machine) -> None:
        self._sensors = [(joint.angle_sensor, joint.pressure_sensor) for joint in parameters.joints(machine)]
        self._fixed: dict[tuple[int, int], float | None] = {}

    def fail(self, joint: int, sensor: int, rail: int | None = None) -> None:
        """From now on report the low (0) or high (1) end of the range; None: the next sample, again and again."""
        far = None if rail is None else (-1e9, 1e9)[rail]
        self._fixed[joint, sensor] = None if far is None else float(read_sensor(self._sensors[joint][sensor], far, 0.0))

    def mend(self, joint: int, sensor: int) -> None:
        """Report what the sensor says."""
        self._fixed.pop((joint, sensor), None)

    def convert(self, *samples: Array) -> None:
        """Put in place of angles and pressures what failed converters report."""
        for (joint, sensor), value in self._fixed.items():
            if value is None:
                self._fixed[joint, sensor] = float(samples[sensor][joint])
            else:
                samples[sensor][joint] = value


class VirtualDevice:
    """A remote I/O station or microcontroller with a machine behind it.

    As a real one it starts dumped, its line empty (the plant's hoses are whatever they are), unless it is `running`, as
    a rollout starts. The plant's time passes with the clock; `link` and `converters` hold what is wrong with wires and
    sensors. Raise MachineError if the machine has no valve or sensors.
    """

    def __init__(self, machine: Machine, plant: Plant, clock: Clock, *, running: bool = False) -> None:
        self.plant, self.clock, self.link, self.converters = plant, clock, Link(), Converters(machine)
        self.line = SupplyLine(machine.supply.pressure, machine.supply.ambient_pressure, air=running)
        self.capabilities = Capabilities.needed(machine)._replace(dithers=True, shortest_cycle=1e-3, lets_down=True)
        self.set_gauge = machine.supply.pressure_gauge  # of the regulator, Pa
        constants = np.array([parameters.torque_constant(joint) for joint in machine.joints.values()])
        self.strengths = self.set_gauge * constants  # greatest torque of each joint, N m
        self.brakes = np.array([joint.brake.torque for joint in machine.joints.values()])  # what they hold, N m
        self._centred = np.full(len(machine.joints), self.capabilities.centre_voltage)
        self._open = self._centred if falls(machine) else np.full_like(self._centred, self.capabilities.voltage_high)
        self._until_dump = round(machine.interface.dump_after * SECOND)
        self._until_centre = min(round(machine.interface.watchdog_cycles * machine.cycle * SECOND), self._until_dump)
        self._supply = Wire.of(machine).supply
        self._at = self._heard = clock.now()
        self._begin = self._at - round(plant.time * SECOND)
        self._stopped, self._reset = False, True
        self.output_names, self.outputs = machine.interface.outputs, 0  # these are those that are on, as bits
        self._opens: int | None = None
        self.state = DeviceState.RUNNING if running else DeviceState.DUMPED
        plant.supply = self.line.pressure
        plant.drive(self._centred if running else self._open)

    @property
    def stopped(self) -> bool:
        """True while the e-stop is pressed; pressing it dumps at once, releasing it changes nothing else."""
        return self._stopped

    @stopped.setter
    def stopped(self, pressed: bool) -> None:
        self.tick()
        self._stopped = pressed
        if pressed:
            self._dump()

    def obey(self, command: Command) -> None:
        """Take a command at this instant; one that is not finite is as none at all."""
        self.tick()
        if not np.isfinite(command.voltages).all():
            return
        edge, self._reset = command.reset and not self._reset, command.reset
        self._heard = self._at
        if self.state is DeviceState.DUMPED and not (edge and not self._stopped):
            return
        self.state, self._opens = DeviceState.RUNNING, None
        self.line.air, self.outputs = command.air, command.outputs
        self.plant.drive(command.voltages)

    def reading(self) -> Reading:
        """Return the readings of the converters at this instant."""
        self.tick()
        angles, pressures = self.plant.sense()
        self.converters.convert(angles, pressures)
        supply = self._supply.value(self._supply.count(self.line.pressure))
        return Reading(angles, pressures, supply, self._stopped, self.state)

    def tick(self) -> None:
        """Advance to the present time, with the watchdog's actions on the way."""
        now = self.clock.now()
        while self.state is not DeviceState.DUMPED:
            running = self.state is DeviceState.RUNNING
            due = self._heard + (self._until_centre if running else self._until_dump)
            if due > now:
                break
            self._pass(due)
            if due >= self._heard + self._until_dump:
                self._dump()
            else:
                self.state = DeviceState.CENTRED
                self.plant.drive(self._centred)
        if self._opens is not None and self._opens <= now:
            self._pass(self._opens)
            self._opens = None
            self.plant.drive(self._open)
        self._pass(now)

    def _dump(self) -> None:
        if self.state is not DeviceState.DUMPED:
            self._opens = self._at + EMPTIES
        if self.state is DeviceState.RUNNING:
            self.plant.drive(self._centred)
        self.state = DeviceState.DUMPED
        self.line.air, self.outputs = False, 0

    def _pass(self, until: int) -> None:
        """Move plant and line on to an instant."""
        while not self.line.steady and self._at < until:
            at = min(self._at + CHUNK, until)
            self.line.advance((at - self._at) / SECOND)
            self.plant.supply = self.line.pressure
            self.plant.advance((at - self._begin) / SECOND)
            self._at = at
        if self._at < until:
            self.plant.advance((until - self._begin) / SECOND)
            self._at = until
