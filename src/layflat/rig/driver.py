"""Interface of drivers, which move the valves and read the sensors for the loop.

    unconfigured --configure--> inactive --activate--> active --deactivate--> inactive --finalize--> finalized

Only an active driver moves anything: `activate` sends no command of its own, `deactivate` centres the valves and vents
the air. In every cycle the loop calls `read` once, then `write` once. Where the device answers commands (Modbus,
serial), `write` only stores the command and `read` makes one transaction of both: voltages are then a cycle late.
"""

from abc import ABC, abstractmethod
from enum import Enum
from typing import NamedTuple, Self

from layflat.arrays import Array
from layflat.errors import InputError, LayflatError
from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.rig.abilities import falls_without_air
from layflat.rig.device_state import DeviceState


class Lifecycle(Enum):
    """Lifecycle state of a driver."""

    UNCONFIGURED = "unconfigured"
    INACTIVE = "inactive"
    ACTIVE = "active"
    FINALIZED = "finalized"


class RigCommand(NamedTuple):
    """Command of a cycle to the device."""

    voltages: Array  # to the valves' drivers, V, (joints,)
    air: bool  # whether the dump valve connects the supply; else its line is open to the atmosphere
    reset: bool = False  # a device that has dumped obeys again at the rising edge, with the e-stop released
    outputs: int = 0  # digital outputs that are on, as bits: the first of the machine's is 1, the second 2


class SensorReading(NamedTuple):
    """Reading of the device in a cycle, as its converters report it."""

    angles: Array  # rad, (joints,)
    pressures: Array  # hose A less hose B, Pa, (joints,)
    supply: float  # in the line behind the dump valve, absolute, Pa
    stopped: bool  # whether the e-stop is pressed (its loop is open)
    device: DeviceState


class Capabilities(NamedTuple):
    """Capabilities of a driver and its device."""

    joints: int
    voltage_low: float
    voltage_high: float
    centre_voltage: float  # at which valves are closed, the fallback of the device, V
    dithers: bool  # whether the device adds the dither; nobody else does
    shortest_cycle: float  # s
    lets_down: bool = (
        False  # whether it keeps valves centred while it vents the supply line, so that an arm does not fall
    )
    outputs: int = 0  # digital outputs

    @classmethod
    def required_by(cls, machine: Machine) -> Self:
        """Return the capabilities that a machine requires; raise MachineError if it has no valve or sensors."""
        valve, _, _ = valve_and_sensors(machine)
        centre, span, dithers = valve.centre_voltage, valve.volts_to_full, valve.dithered is not None
        able = dithers, machine.cycle, falls_without_air(machine), len(machine.interface.outputs)
        return cls(len(machine.joints), centre - span, centre + span, centre, *able)

    def check(self, machine: Machine) -> None:
        """Check these capabilities against a machine's requirements; raise InputError where they do not suffice."""
        joints, low, high, centre, dithers, cycle, falling, outputs = Capabilities.required_by(machine)
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
            "it opens the valves as it vents the air, and the arm would fall": falling and not self.lets_down,
            f"it has {self.outputs} digital outputs, the machine {outputs}": self.outputs < outputs,
            f"its shortest cycle is {shortest}, the controller's {1e3 * cycle:g} ms": self.shortest_cycle > cycle,
        }
        for what, differs in wrong.items():
            if differs:
                right = "give the description of this rig, or set up its device for this one"
                raise InputError(f"the device does not fit {machine.name!r}: {what}", where="driver", right=right)


class LinkError(LayflatError):
    """Failed transaction; the loop counts these and goes on.

    Args:
        kind: "lost", "crc", "sequence" or "refused".
        reason: description of what came in place of a good reply; empty where it is unknown.
        right: remedy; empty where none is known.
    """

    def __init__(self, kind: str, reason: str = "", right: str = "") -> None:
        self.kind, self.reason, self.right = kind, reason, right
        super().__init__(f"no valid reply from the device: {kind}" + (f" ({reason})" if reason else ""))


class DriverError(InputError):
    """Driver that can't be set up: no device, no permission, a register map that does not fit."""


class Driver(ABC):
    """Base class of all drivers: it enforces the lifecycle; `_configure` and `_deactivate` do the work."""

    late = 0  # delay from `write` until the command reaches the device, control cycles
    runs_law = False  # whether the device runs the control law itself, and gets requests; known once configured

    def __init__(self) -> None:
        self.state = Lifecycle.UNCONFIGURED
        self.remark = ""  # peculiarity of the link for people, once it is detected

    def configure(self) -> Capabilities:
        """Connect and identify the device; return its capabilities, or raise DriverError if no fitting one answers."""
        self._expect("configure", Lifecycle.UNCONFIGURED)
        capabilities = self._configure()
        self.state = Lifecycle.INACTIVE
        return capabilities

    def activate(self) -> None:
        """Enter the active state, in which commands are obeyed; raise DriverError unless the driver is inactive."""
        self._expect("activate", Lifecycle.INACTIVE)
        self.state = Lifecycle.ACTIVE

    def deactivate(self) -> None:
        """Centre the valves and vent the supply line, if the link allows; raise DriverError unless active."""
        self._expect("deactivate", Lifecycle.ACTIVE)
        self.state = Lifecycle.INACTIVE
        self._deactivate()

    def finalize(self) -> None:
        """Release the device in any state, deactivating it first if it is active; a second call does nothing."""
        if self.state is Lifecycle.ACTIVE:
            self.deactivate()
        self.state = Lifecycle.FINALIZED

    def _expect(self, what: str, state: Lifecycle) -> None:
        """Raise DriverError, with `what` as the call that fails, unless the driver is in a state."""
        if self.state is not state:
            right = f"call it while {state.value}"
            raise DriverError(f"can't {what} while {self.state.value}", where=type(self).__name__, right=right)

    @abstractmethod
    def read(self) -> SensorReading:
        """Return the present readings of the sensors; raise LinkError if the device did not answer well."""

    @abstractmethod
    def write(self, command: RigCommand) -> None:
        """Set the command that is in force from now on, without blocking."""

    @abstractmethod
    def _configure(self) -> Capabilities: ...

    @abstractmethod
    def _deactivate(self) -> None: ...
