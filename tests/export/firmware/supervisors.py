"""Supervisor as it is exported: on this computer, in the loop of a rig or on recorded inputs, and on a board."""

import ctypes
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.export.compiled import object_file, portable_entry
from layflat.export.entries import number_of
from layflat.export.firmware.supervisor import SupervisorEntries
from layflat.export.header import Api
from layflat.export.targets import EXPORT_TARGETS, Target
from layflat.jit import objects
from layflat.lanes import leaves
from layflat.machine import Machine
from layflat.rig.safety.core import CycleCore
from tests.export.firmware.boards import SOURCES, Board, execute, link
from tests.export.firmware.recordings import REALS
from tests.rig.mishaps import MishapRig


class Trace(NamedTuple):
    """Trace of a supervisor: a row a cycle."""

    inputs: Array
    after: Array  # memory, then results
    events: list[list[str]]  # texts of each cycle


def changed_numbers(core: CycleCore) -> list[Array]:
    """Return the arrays of memory and results, in the order of the structs of C."""
    law, rows = core.law, core.rows
    memory = rows.memory, rows.joints, law.memory.array[0]
    return [*memory, rows.results, rows.commands, rows.events, law.report.array]


def record_supervisor(machine: Machine, cycles: int, seed: int = 1, other: "HostSupervisor | None" = None) -> Trace:
    """Return the trace of a rig's loop with all kinds of requests and mishaps.

    Args:
        machine: the machine.
        cycles: number of control cycles.
        seed: seed of all that happens.
        other: supervisor that takes the place of the loop's own.
    """
    mishaps, inputs, after, events = MishapRig(machine, seed), [], [], []
    core = mishaps.rig.supervisor.core
    if other is not None:
        other.take_over(core)
    for rig in mishaps.cycles(cycles):
        inputs.append(np.concatenate([core.rows.inputs, core.rows.samples.ravel()]))
        after.append(np.concatenate([part.ravel() for part in changed_numbers(core)]))
        events.append(rig.take_lines())
    return Trace(np.array(inputs), np.array(after), events)


class HostSupervisor:
    """Supervisor of a machine as an object file of this computer."""

    def __init__(self, machine: Machine, precision: str) -> None:
        self.entries, self.real, self.precision = SupervisorEntries(machine), REALS[precision], precision
        (entry,) = self.entries
        self.text = portable_entry(entry, "rig", precision)
        code = object_file(entry, self.text, "rig", Target(objects.host(), "host"))
        loaded: Any = objects.load(code, "rig_supervisor_cycle")
        self._function = ctypes.cast(loaded, ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 5))
        parts = entry_parts(self.entries)
        self._settings, self._inputs, self.memory, self.results, self._workspace = (
            np.array(list(leaves(part)), self.real) for part in parts
        )
        self._start = self.memory.copy(), self.results.copy()

    def cycle(self, inputs: Array) -> Array:
        """Return memory and results after a cycle."""
        self._inputs[:] = inputs
        order = self._settings, self._inputs, self.memory, self.results, self._workspace
        self._function(*(one.ctypes.data for one in order))
        return np.concatenate([self.memory, self.results])

    def take_over(self, core: CycleCore) -> None:
        """Run the cycles of a rig's loop from its start."""
        self.memory[:], self.results[:] = self._start
        places = changed_numbers(core)
        ends = np.cumsum([place.size for place in places])[:-1]

        def run(_: int) -> None:
            after = self.cycle(np.concatenate([core.rows.inputs, core.rows.samples.ravel()]))
            for place, part in zip(places, np.split(after, ends), strict=True):
                place[:] = part.reshape(place.shape)

        core._run = run


def entry_parts(entries: SupervisorEntries) -> tuple[Any, ...]:
    """Return the structs of the entry, in order."""
    return entries.settings, entries.inputs, entries.memory, entries.results, entries.workspace


class Replay(NamedTuple):
    """Results of a board, and what they cost."""

    after: Array
    instructions: Array
    stack: int  # bytes
    flash: int  # bytes
    ram: int  # bytes, with the stack


def program_parts(supervisor: HostSupervisor, target: str, folder: Path) -> Iterator[Path]:
    """Yield the object files of a supervisor; its header and settings are written beside them."""
    entries = supervisor.entries
    api, tables = Api("rig", supervisor.precision, entries, entries.comments), list(entries.tables())
    (folder / "rig.h").write_text(api.header("rig", entries.constants(), tables))
    (folder / "rig.c").write_text(api.source("rig.h", tables))
    for entry in entries:
        path = folder / f"{entry.name}.o"
        path.write_bytes(object_file(entry, supervisor.text, "rig", EXPORT_TARGETS[target]))
        yield path


def replay_inputs(supervisor: HostSupervisor, inputs: Array, target: str, board: Board, folder: Path) -> Replay:
    """Return what a supervisor on a board makes of inputs.

    Args:
        supervisor: the supervisor, whose portable code is used.
        inputs: inputs, a row a cycle.
        target: name of the target.
        board: the board.
        folder: folder for the program.
    """
    parts = list(program_parts(supervisor, target, folder))
    image = link(board, [folder / "rig.c", SOURCES / "supervisor.c"], parts, folder)
    inputs.astype(supervisor.real).tofile(folder / "in.bin")
    execute(image)
    size = number_of(supervisor.entries.memory) + number_of(supervisor.entries.results)
    kind = np.dtype([("measured", np.uint32, 2), ("numbers", supervisor.real, size)])
    rows = np.fromfile(folder / "out.bin", kind)
    ticks, stack = rows["measured"].T
    return Replay(rows["numbers"], ticks * board.tick, int(stack[-1]), image.flash, image.ram + int(stack[-1]))
