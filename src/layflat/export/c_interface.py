"""Interface of a machine in C: entries, structs, constants and tables of parameters, in a precision."""

from layflat.errors import InputError
from layflat.export.compiled import SIZE_BY_PRECISION
from layflat.export.entries import ControlEntries, Entry, PlantEntries
from layflat.export.header import Api, Constant, Table
from layflat.export.layout import c_name
from layflat.export.numbers import check_single
from layflat.export.run_entry import record_comments, run_entry
from layflat.machine import Machine


class CInterface:
    """Interface of a machine in C: its control law, and its plant in double precision.

    Args:
        machine: the machine.
        precision: "double" or "single".
        plant: whether the plant is a part of it.

    Raises:
        InputError: the precision is unknown, or does not hold a parameter.
        MachineError: the machine lacks a controller, valve or sensor.
        KindError: the control law is plain Python.
    """

    def __init__(self, machine: Machine, precision: str, *, plant: bool) -> None:
        if precision not in SIZE_BY_PRECISION:
            raise InputError(f"{precision!r} is not a precision", where="precision", right="give double or single")
        self.machine, self.precision, self.prefix = machine, precision, c_name(machine.name)
        self.control = ControlEntries(machine, SIZE_BY_PRECISION[precision])
        self.plant = PlantEntries(machine) if plant and precision == "double" else None
        run = run_entry(self.control, self.plant) if self.plant is not None else ()
        self.entries: tuple[Entry, ...] = (*self.control, *(self.plant or ()), *run)
        self.tables = [Table("settings", self.control.settings, f"Settings of the control law of {machine.name}.")]
        if precision == "single":
            check_single(self.control.settings, "settings", machine.origin)
        if self.plant is not None:
            self.tables.append(Table("parameters", self.plant.setting, f"Parameters of the plant of {machine.name}."))
        self.api = Api(self.prefix, precision, self.entries, self.control.comments | record_comments())

    def constants(self, stack: dict[str, int]) -> list[Constant]:
        """Return the macros of the header.

        Args:
            stack: upper bound of the stack of each entry over all targets, bytes.
        """
        constants = [
            Constant("JOINTS", len(self.machine.joints), "number of joints"),
            Constant("CYCLE", self.machine.cycle, "control cycle, s"),
        ]
        if self.plant is not None:
            constants.append(Constant("STEPS", self.plant.steps, "steps of the plant in a control cycle"))
        for name, size in stack.items():
            what = f"stack of {self.prefix}_{name} at most, without the compiler's library, bytes"
            constants.append(Constant(f"STACK_{name.upper()}", size, what))
        return constants
