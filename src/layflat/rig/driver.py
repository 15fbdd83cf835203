"""What the loop asks of whatever moves the valves and reads the sensors.

    unconfigured --configure--> inactive --activate--> active --deactivate--> inactive --finalize--> finalized

Only an active driver moves anything: `activate` sends no command of its own, `deactivate` centres the valves and lets
out the air. In every cycle the loop calls `read` once, then `write` once. Where the device answers commands (Modbus,
serial), `write` only keeps the command and `read` makes one transaction of both: voltages are then a cycle late.
"""

from abc import ABC, abstractmethod
from enum import Enum, IntEnum
from typing import NamedTuple, Self

from layflat.arrays import Array
from layflat.errors import InputError, LayflatError
from layflat.machine import Machine
from layflat.machine.parameters import drive_parts
from layflat.rig.abilities import falls


class Lifecycle(Enum):
    """Where a driver stands."""

    UNCONFIGURED = "unconfigured"
    INACTIVE = "inactive"
    ACTIVE = "active"
    FINALIZED = "finalized"


class DeviceState(IntEnum):
    """What the device does by itself."""

    RUNNING = 0  # it obeys
    CENTRED = 1  # it heard nothing for some cycles: the valves are centred
    DUMPED = 2  # it heard nothing for longer, or the e-stop is pressed: the air is let out; it obeys after a `reset`


class Command(NamedTuple):
    """What a cycle asks for."""

    voltages: Array  # to the valves' drivers, V, (joints,)
    air: bool  # whether the dump valve lets air in; else the supply line is open to the atmosphere
    reset: bool = False  # asks a device that has dumped to obey again; it does on the edge, with the e-stop released
    outputs: int = 0  # digital outputs that are on, as bits: the first of the machine's is 1, the second 2


class Reading(NamedTuple):
    """What a cycle is told, as the converters report it."""

    angles: Array  # rad, (joints,)
    pressures: Array  # hose A less hose B, Pa, (joints,)
    supply: float  # in the line behind the dump valve, absolute, Pa
    stopped: bool  # whether the e-stop is pressed (its loop is open)
    device: DeviceState


class Capabilities(NamedTuple):
    """What a driver and its device can do."""

    joints: int
    voltage_low: float
    voltage_high: float
    centre_voltage: float  # at which valves are closed, the fallback of the device, V
    dithers: bool  # whether the device adds the dither; nobody else does
    shortest_cycle: float  # s
    lets_down: bool = False  # whether it keeps valves centred while it lets out the air, so that an arm does not fall
    outputs: int = 0  # digital outputs

    @classmethod
    def needed(cls, machine: Machine) -> Self:
        """What a machine needs of them; raise MachineError if it has no valve or sensors."""
        valve, _, _ = drive_parts(machine)
        centre, span, dithers = valve.centre_voltage, valve.volts_to_full, valve.dithered is not None
        able = dithers, machine.cycle, falls(machine), len(machine.interface.outputs)
        return cls(len(machine.joints), centre - span, centre + span, centre, *able)

    def check(self, machine: Machine) -> None:
        """Make sure that this fits a machine; raise InputError if it does not."""
        joints, low, high, centre, dithers, cycle, falling, outputs = Capabilities.needed(machine)
        mine, shortest = f"{self.voltage_low:g} to {self.voltage_high:g} V", f"{1e3 * self.shortest_cycle:g} ms"
        wrong = {
            f"it has {self.joints} joints, the machine {joints}": self.joints != joints,
            f"its voltages are {mine}, the valves need {low:g} to {high:g} V": (
                self.voltage_low > low or self.voltage_high < high
            ),
            f"it falls back to {self.centre_voltage:g} V, the valves are closed at {centre:g} V": (
                abs(self.centre_voltage - centre) > 1e-3 * (high - centre)
            ),
            "it does not add the dither": dithers and not self.dithers,
            "it opens the valves as it lets out the air, and the arm would fall": falling and not self.lets_down,
            f"it has {self.outputs} digital outputs, the machine {outputs}": self.outputs < outputs,
            f"its shortest cycle is {shortest}, the controller's {1e3 * cycle:g} ms": self.shortest_cycle > cycle,
        }
        for what, differs in wrong.items():
            if differs:
                raise InputError(f"the device does not fit {machine.name!r}: {what}", where="driver")


class LinkError(LayflatError):
    """A transaction failed; the loop counts these and goes on.

    Args:
        kind: "lost", "crc", "sequence" or "refused".
        reason: what came in place of a good reply, where that is known.
        right: what would help.
    """

    def __init__(self, kind: str, reason: str = "", right: str = "") -> None:
        self.kind, self.reason, self.right = kind, reason, right
        super().__init__(f"the device's reply: {kind}" + (f" ({reason})" if reason else ""))


class DriverError(InputError):
    """A driver can't be set up: no device, no permission, a map that does not fit."""


class Driver(ABC):
    """Base of all drivers: it keeps to the lifecycle, the methods with an underscore do the work."""

    late = 0  # control cycles after which a command that is written reaches the device

    def __init__(self) -> None:
        self.state = Lifecycle.UNCONFIGURED
        self.remark = ""  # what is to be known of the link, once it is

    def configure(self) -> Capabilities:
        """Connect, and ask what is there; raise DriverError if nothing fit is there."""
        self._expect("configure", Lifecycle.UNCONFIGURED)
        found = self._configure()
        self.state = Lifecycle.INACTIVE
        return found

    def activate(self) -> None:
        """From now on commands are obeyed."""
        self._expect("activate", Lifecycle.INACTIVE)
        self.state = Lifecycle.ACTIVE

    def deactivate(self) -> None:
        """Centre the valves and let out the air, as far as the link allows."""
        self._expect("deactivate", Lifecycle.ACTIVE)
        self.state = Lifecycle.INACTIVE
        self._deactivate()

    def finalize(self) -> None:
        """Let go of the device, whatever state it is in; a second call does nothing."""
        if self.state is Lifecycle.ACTIVE:
            self.deactivate()
        self.state = Lifecycle.FINALIZED

    def _expect(self, what: str, state: Lifecycle) -> None:
        if self.state is not state:
            raise DriverError(f"can't {what} while {self.state.value}", where=type(self).__name__)

    @abstractmethod
    def read(self) -> Reading:
        """What the sensors say now; raise LinkError if the device did not answer well."""

    @abstractmethod
    def write(self, command: Command) -> None:
        """What is asked for from now on. It does not block."""

    @abstractmethod
    def _configure(self) -> Capabilities: ...

    @abstractmethod
    def _deactivate(self) -> None: ...
