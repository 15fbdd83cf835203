"""Firmware of a microcontroller as a folder of C: supervisor and control law behind four functions of a board."""

from collections.abc import Iterator
from typing import Any

from layflat.export.boards import EXAMPLE_BOARDS, ExampleBoard
from layflat.export.compiled import CompiledEntry, compiled_entry, portable_entry
from layflat.export.firmware.controller import controller_sources
from layflat.export.firmware.station import DEVICE_FOLDER
from layflat.export.firmware.supervisor import SupervisorEntries
from layflat.export.header import Api
from layflat.export.numbers import check_single
from layflat.export.targets import EXPORT_TARGETS
from layflat.export.templates import fill_template
from layflat.jit.objects import code_size
from layflat.machine import Machine

C_PREFIX = "rig"  # of the supervisor's names in C
STACK_SIZE = 1 << 16  # that a board's memory holds at least, bytes


def firmware_files(
    machine: Machine, target: str, precision: str, board: ExampleBoard
) -> Iterator[tuple[str, str | bytes]]:
    """Yield name and content of each file of a machine's firmware.

    Args:
        machine: the machine.
        target: a key of `boards.EXAMPLE_BOARDS`.
        precision: "double" or "single".
        board: board of the example.

    Raises:
        InputError: single precision does not hold a parameter, or the law reports more than a frame carries.
        MachineError: the machine can't be a rig.
    """
    entries = SupervisorEntries(machine)
    if precision == "single":
        for table in entries.tables():
            check_single(table.like, table.name, machine.origin)
    compiled = {
        entry.name: compiled_entry(entry, portable_entry(entry, C_PREFIX, precision), C_PREFIX, EXPORT_TARGETS[target])
        for entry in entries
    }
    for name, entry in compiled.items():
        yield f"lib/{name}.o", board.with_exact_sums(entry.code)
    api = Api(C_PREFIX, precision, tuple(entries), entries.comments)
    yield (
        f"{C_PREFIX}.h",
        api.header(f"Supervisor and control law of {machine.name}", entries.constants(), entries.tables()),
    )
    yield f"{C_PREFIX}.c", api.source(f"{C_PREFIX}.h", entries.tables())
    yield from controller_sources(machine, precision)
    boards = {one.device for one in EXAMPLE_BOARDS.values()} - {board.device}
    for path in sorted(path for path in DEVICE_FOLDER.iterdir() if path.name not in boards):
        yield path.name, path.read_text(encoding="utf-8")
    yield from _board_files(machine, board, precision, compiled)


def _board_files(
    machine: Machine, board: ExampleBoard, precision: str, compiled: dict[str, CompiledEntry]
) -> Iterator[tuple[str, str]]:
    """Yield the files that build the programs, start the processor, and tell about them."""
    values: dict[str, Any] = {
        **board.values(precision), "title": machine.name, "firmware": True, "baud": machine.interface.serial.baud,
        "stack_size": STACK_SIZE, "cycle_ms": f"{1e3 * machine.cycle:g}",
        "stack": max(entry.stack for entry in compiled.values()),
        "sizes": {name: code_size(entry.code) for name, entry in compiled.items()},
        "joints": list(machine.joints), "outputs": machine.interface.outputs,
    }  # fmt: skip
    started = ("startup.c", "board.ld") if board.template == "cortex" else ()
    for name in (*started, *(("sums.c",) if values["sums"] else ())):
        yield name, fill_template(name, **values)
    for name in ("Makefile", "README.md"):
        yield name, fill_template(f"{name}.firmware", **values)
