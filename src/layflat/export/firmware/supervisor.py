"""Supervisor of a rig as an entry: the whole control cycle, from samples and requests to voltages, states and faults.

It is the compiled cycle of the rig's loop itself (`rig/safety/supervision.py`), on the caller's memory.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

from layflat.control import CONTROL_LAWS
from layflat.export.entries import Argument, Entry, number_of
from layflat.export.header import Constant, Table
from layflat.lanes import Like, read_numbers
from layflat.machine import Machine, parameters
from layflat.rig.device_state import DeviceState
from layflat.rig.law import ArmLaw
from layflat.rig.named import NamedRows
from layflat.rig.safety.core import RigNumbers
from layflat.rig.safety.cycle import CycleLikes
from layflat.rig.safety.cycle_numbers import (
    FIRST_COMMAND,
    FIRST_RESULTS,
    INPUTS_TEMPLATE,
    JOINT_INPUTS_TEMPLATE,
    NO_EVENT,
    CycleRows,
    LawRows,
    max_events,
)
from layflat.rig.safety.faults import Fault, RigState, ValveMode
from layflat.rig.safety.ledger import RESET_REFUSED, START_BARRED, START_UNRECORDED, STATE_ENTERED
from layflat.rig.safety.supervision import COMMAND_PART, CONTROL_PART, run_cycle


class SupervisorSettings(NamedTuple):
    """Settings of supervisor and control law."""

    rig: Any  # of the machine as a whole
    joints: tuple[Any, ...]  # base to tip
    arm: Any  # parameters of the arm
    law: Any  # of the control law


class SupervisorInputs(NamedTuple):
    """Inputs of a cycle."""

    rig: Any  # reading of the machine as a whole, and requests
    joints: tuple[Any, ...]  # samples and demands, base to tip


class SupervisorMemory(NamedTuple):
    """Memory of supervisor and control law from cycle to cycle, which may be copied."""

    rig: Any  # of the machine as a whole
    joints: tuple[Any, ...]  # base to tip
    law: Any  # of the control law


class SupervisorResults(NamedTuple):
    """Results of a cycle: commands, and what happened."""

    rig: Any  # command to the device, state and faults
    joints: tuple[Any, ...]  # base to tip
    events: tuple[Any, ...]  # the first `rig.events` count
    report: tuple[Any, ...]  # of the control law, for each joint


class SupervisorWorkspace(NamedTuple):
    """Workspace of a cycle, whose content does not matter between calls."""

    numbers: tuple[float, ...]


class SupervisorEntries:
    """Supervisor of a machine's rig as an entry.

    Args:
        machine: the machine.
        late: control cycles after which the valves get the voltages, besides the valve's own delay.

    Raises:
        MachineError: the machine has no valve, sensors, controller or gains.
        KindError: the law is plain Python, or commands a fraction of brake, dither or supply.
    """

    def __init__(self, machine: Machine, late: int = 0) -> None:
        law = ArmLaw(machine, late)
        kind = CONTROL_LAWS.kind_of(law.settings_as_given)
        kind.check_compiled("in C")
        numbers, n = RigNumbers(machine), len(machine.joints)
        self.machine, self.joints = machine, n
        self._rejection_column = list(kind.signals).index(kind.gives_up) if kind.gives_up is not None else -1
        self.settings = SupervisorSettings(
            _rows(numbers.rig)[0], _rows(numbers.settings), parameters.arm(machine), law.settings.like
        )
        self.inputs = SupervisorInputs(INPUTS_TEMPLATE, (JOINT_INPUTS_TEMPLATE,) * n)
        self.memory = SupervisorMemory(_rows(numbers.machine)[0], _rows(numbers.memory), law.memory.like)
        self.results = SupervisorResults(
            FIRST_RESULTS, (FIRST_COMMAND,) * n, (NO_EVENT,) * max_events(n), (law.report.like,) * n
        )
        self.workspace = SupervisorWorkspace((0.0,) * ((2 * n + 4) * (n + 1)))
        signals = {name: f"{meaning}, {unit}" for name, (unit, meaning) in kind.signals.items()}
        self.comments: dict[type, dict[str, str]] = {kind.report: signals}

    def tables(self) -> Iterator[Table]:
        """Yield the settings, and the content of the memory before the first cycle."""
        yield Table("supervisor_settings", self.settings, f"Settings of {self.machine.name}.")
        yield Table("supervisor_memory", self.memory, "Memory before the first cycle.")

    def constants(self) -> Iterator[Constant]:
        """Yield the macros: joints, cycle, and the numbers of states, modes, faults and events."""
        yield Constant("JOINTS", self.joints, "number of joints")
        yield Constant("CYCLE", self.machine.cycle, "control cycle, s")
        kinds = {"STATE": RigState, "MODE": ValveMode, "DEVICE": DeviceState}
        for prefix, kind in kinds.items():
            for one in kind:
                yield Constant(f"{prefix}_{one.name}", int(one), f"number of the {prefix.lower()}")
        for fault in list(Fault)[1:]:
            yield Constant(f"FAULT_{fault.name}", int(fault), fault.title)
        yield Constant("EVENT_STATE", int(STATE_ENTERED), "and the number of the state that was entered")
        yield Constant("EVENT_START_BARRED", int(START_BARRED), "no start: a fault is latched")
        yield Constant("EVENT_START_UNRECORDED", int(START_UNRECORDED), "no start: nothing is recorded")
        yield Constant("EVENT_RESET_REFUSED", int(RESET_REFUSED), "no reset: the fault is still there")

    def __iter__(self) -> Iterator[Entry]:
        """Yield the entry."""
        arguments = (
            ("settings", "settings", self.settings),
            ("inputs", "inputs of this cycle", self.inputs),
            ("memory", "memory, which advances by a cycle", self.memory),
            ("results", "results of this cycle", self.results),
            ("workspace", "workspace", self.workspace),
        )
        yield Entry(
            "supervisor_cycle",
            "Run a whole control cycle: judge the samples, decide on states, run the control law, command the valves.",
            tuple(
                Argument(
                    name, comment, like, output=name not in ("settings", "inputs"), split=True,
                    struct=f"supervisor_{name}",
                )
                for name, comment, like in arguments
            ),
            self._cycle(),
            lanes=False,
        )  # fmt: skip

    def _cycle(self) -> Any:
        from numba import carray  # type: ignore[attr-defined]  # noqa: PLC0415  # only where something is exported

        n, nothing, column = self.joints, (0.0,) * self.joints, self._rejection_column
        settings, memory, results = self.settings, self.memory, self.results
        arm_like, law_like, law_memory_like = map(Like.from_tuple, (settings.arm, settings.law, memory.law))
        rig_size, settings_size, arm_size, law_size = _sizes(settings)
        inputs_size, samples_size = _sizes(self.inputs)
        memory_size, joints_size, law_memory_size = _sizes(memory)
        results_size, commands_size, events_size, report_size = _sizes(results)
        events_count, parts = len(results.events), CONTROL_PART | COMMAND_PART

        def cycle(  # type: ignore[no-untyped-def]
            rig, settings, arm, law, inputs, samples, memory, joints, law_memory, results, commands, events, report,
            workspace,
        ):  # fmt: skip
            rows = CycleRows(
                carray(rig, (rig_size,)), carray(settings, (n, settings_size)), carray(inputs, (inputs_size,)),
                carray(samples, (n, samples_size)), carray(memory, (memory_size,)), carray(joints, (n, joints_size)),
                carray(results, (results_size,)), carray(commands, (n, commands_size)),
                carray(events, (events_count, events_size)),
            )  # fmt: skip
            law_rows = LawRows(
                carray(arm, (arm_size,)), carray(law, (law_size,)), carray(law_memory, (law_memory_size,)),
                carray(report, (n, report_size)), carray(workspace, (2 * n + 4, n + 1)),
            )  # fmt: skip
            run_cycle(CycleLikes(arm_like, law_like, law_memory_like), nothing, column, rows, law_rows, parts)

        return cycle


def _sizes(parts: Any) -> list[int]:
    """Return the number of numbers in each field of a tuple, or in a row of it where that is an array."""
    return [number_of(part[0] if type(part) is tuple else part) for part in parts]


def _rows(rows: NamedRows) -> tuple[Any, ...]:
    """Return the rows as tuples."""
    return tuple(read_numbers(rows.like, row) for row in rows.array)
