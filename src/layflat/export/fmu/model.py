"""Model of an FMU: the numbers of an instance in sections, and the header model.h that tells them to the C sources."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from layflat.control import CONTROL_LAWS
from layflat.errors import InputError
from layflat.export.entries import Argument, ControlEntries, Entry, number_of
from layflat.export.fmu.noise import table_definitions
from layflat.export.fmu.plant import PlantFunctions
from layflat.export.fmu.variables import (
    ACCESS_CODES,
    Section,
    Variable,
    joint_outputs,
    parameter_variables,
    quoted,
    scenario_input,
)
from layflat.export.numbers import c_number
from layflat.machine import Machine
from layflat.machine.signals import SIGNALS
from layflat.physics.adjustable import DriveFractions

LAW_PREFIX = "model"  # of the names of the laws' functions
MAX_SEED = 2**31 - 1  # of the sensors' noise: FMI 2.0 has no larger integer

START_SIGNALS = {
    "start": ("rad", "angle at which the joint rests at the start"),
    "start_pressure_a": ("Pa", "absolute pressure in hose A at the start; 0: that which holds the arm"),
    "start_pressure_b": ("Pa", "absolute pressure in hose B at the start; 0: that which holds the arm"),
}
DEMAND_SIGNALS = ("demand", "demand_velocity", "demand_acceleration", "demand_stiffness")  # in the order of `Demand`
COMMANDED_SHARES = {
    f"{name}_command": ("1", f"fraction of the {name} that the control law commands") for name in DriveFractions._fields
}


@dataclass(frozen=True)
class FmuModel:
    """Model of an FMU: plant, control law or both, and the places of their numbers.

    Args:
        machine: the machine.
        plant: its plant.
        control: its control law.
        has_plant: whether the plant is in the FMU.
        has_control: whether the control law is in it.
    """

    machine: Machine
    plant: PlantFunctions
    control: ControlEntries
    has_plant: bool
    has_control: bool

    @property
    def entries(self) -> list[Entry]:
        """Functions of laws that its library holds."""
        return [*(self.plant if self.has_plant else ()), *(self.control if self.has_control else ())]

    @cached_property
    def sections(self) -> list[Section]:
        """Numbers of an instance, in order."""
        sections = [*self._plant_sections()] if self.has_plant else []
        sections += [*self._control_sections()] if self.has_control else []
        return [*sections, Section("MEASURED", self._measured())]

    @cached_property
    def variables(self) -> list[tuple[int, Variable]]:
        """Variables of real numbers with their value references.

        Raises:
            InputError: two have the same name.
        """
        numbers = enumerate(item for section in self.sections for item in section.items)
        variables = [(reference, item) for reference, item in numbers if isinstance(item, Variable)]
        names = [item.name for _, item in variables]
        twice = (
            next((name for i, name in enumerate(names) if name in names[:i]), None)
            if len({*names}) < len(names)
            else None
        )
        if twice is not None:
            raise InputError(
                f"two variables of the FMU are called {twice!r}", where=self.machine.name, right="rename a joint"
            )
        return variables

    @property
    def size(self) -> int:
        """Number of real numbers; the references of seed, noise and time follow on them."""
        return sum(len(section.items) for section in self.sections)

    def _joints(self) -> list[str]:
        return [quoted(joint) for joint in self.machine.joints]

    def _plant_sections(self) -> Iterator[Section]:
        plant, joints = self.plant, self._joints()
        yield Section("PARAMETERS", (*parameter_variables(plant.parameters, "plant", self.machine.joints),))
        yield Section(
            "START",
            tuple(
                Variable(f"{joint}.{name}", "fixed", 0.0, *START_SIGNALS[name])
                for name in START_SIGNALS
                for joint in joints
            ),
        )
        yield Section("INPUTS", tuple(item for j in range(len(joints)) for item in self._joint_inputs(j)))
        yield Section(
            "SHARED", tuple(scenario_input(n, v) for n, v in zip(plant.shared._fields, plant.shared, strict=True))
        )
        hidden = () if self.has_control else ("voltage",)  # an input of the plant alone
        outputs = joint_outputs(self.machine.joints, plant.outputs, SIGNALS, hidden)
        yield Section("OUTPUTS", tuple(outputs))

    def _joint_inputs(self, j: int) -> Iterator[Variable | float]:
        """Yield the numbers of a joint's `DriveInputs`: what the control law commands is no variable beside it."""
        inputs, joint = self.plant.inputs[j], self._joints()[j]
        commands = [scenario_input("voltage", inputs.voltage, joint)]
        commands += [Variable(f"{joint}.{name}", "input", 1.0, *COMMANDED_SHARES[name]) for name in COMMANDED_SHARES]
        yield from (item.start for item in commands) if self.has_control else commands
        for name in ("brake", "dither", "load", "drift"):
            yield scenario_input(name, getattr(inputs, name), joint)

    def _control_sections(self) -> Iterator[Section]:
        joints, control = self._joints(), self.control
        yield Section("SETTINGS", (*parameter_variables(control.settings, "controller", self.machine.joints),))
        yield Section("DEMAND", tuple(scenario_input(name, 0.0, joint) for name in DEMAND_SIGNALS for joint in joints))
        commands = [Variable(f"{joint}.voltage", "output", start, *SIGNALS["voltage"], held=True)
                    for joint, start in zip(joints, control.command.voltage, strict=True)]  # fmt: skip
        for joint, shares in zip(joints, control.command.shares, strict=True):
            names = zip(COMMANDED_SHARES, shares, strict=True)
            commands += [
                Variable(f"{joint}.{name}", "output", start, *COMMANDED_SHARES[name], held=True)
                for name, start in names
            ]
        yield Section("COMMAND", tuple(item.start if self.has_plant else item for item in commands))
        signals = CONTROL_LAWS.kind_of(control.settings).signals
        yield Section("REPORT", tuple(joint_outputs(self.machine.joints, control.report.joints, signals, held=True)))

    def _measured(self) -> tuple[Variable | float, ...]:
        """Return the readings of the sensors: inputs of the control law alone; the plant's outputs hold them, too."""
        names = ("measured_angle", "measured_pressure")
        items = [
            Variable(f"{joint}.{name}", "input", 0.0, *SIGNALS[name]) for name in names for joint in self._joints()
        ]
        return (0.0,) * len(items) if self.has_plant else tuple(items)

    def header(self, token: str) -> str:
        """Return model.h, with a token by which an importer's description is known to belong to the library."""
        n, place = len(self.machine.joints), 0
        defined: dict[str, str | int] = {
            "TOKEN": f'"{token}"', "PLANT": int(self.has_plant), "CONTROLLER": int(self.has_control), "JOINTS": n,
            "CYCLE": self.plant.cycle.hex(), "STEPS": self.plant.steps,
            "STATE": number_of(self.plant.states) if self.has_plant else 1,
            "MEMORY": number_of(self.control.memory) if self.has_control else 1,
            "INPUT_COLUMNS": number_of(self.plant.inputs[0]), "OUTPUT_VALUES": number_of(self.plant.outputs),
        }  # fmt: skip
        for section in self.sections:
            defined[section.name] = place
            place += len(section.items)
        defined |= {"VALUES": place, "SEED": place, "NOISE": place + 1, "TIME": place + 2}
        lines = ["#include <math.h>", "#include <stdint.h>"]
        lines += [f"#define MODEL_{name} {value}" for name, value in defined.items()]
        lines += [f"#define ACCESS_{name.upper()} {number}" for name, number in ACCESS_CODES.items()]
        items = [item for section in self.sections for item in section.items]
        uses = [ACCESS_CODES[item.use] if isinstance(item, Variable) else ACCESS_CODES["none"] for item in items]
        starts = [number for section in self.sections for number in section.start_values]
        lines += _table("double model_start", [c_number(float(number), "double") for number in starts])
        lines += _table("unsigned char model_access", [str(use) for use in uses])
        lines += [f"{prototype(entry)};" for entry in self.entries]
        return "\n".join([*lines, *(table_definitions() if self.has_plant else ()), ""])


def _table(declared: str, numbers: list[str]) -> list[str]:
    return [f"static const {declared}[{len(numbers)}] = {{{', '.join(numbers)}}};"]


def prototype(entry: Entry, end: str = "") -> str:
    """Return the declaration of a law's function, of addresses of rows of numbers, whose names have this end."""
    taken = ", ".join(f"{_c_type(one)}{one.name}{'' if one.like is None else end}" for one in entry.arguments)
    return f"{'int32_t' if entry.result else 'void'} {LAW_PREFIX}_{entry.name}({taken})"


def _c_type(argument: Argument) -> str:
    if argument.like is None:
        return "double " if argument.number == "real" else f"{argument.number} "
    return f"{'' if argument.output else 'const '}void *"
