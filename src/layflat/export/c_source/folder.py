"""Folders of readable C: the control law as source, its parameters, an example with a recorded check, and a page."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from layflat._version import __version__
from layflat.export.c_folder import recorded_values
from layflat.export.c_interface import CInterface
from layflat.export.c_source.c_types import type_of_tuple
from layflat.export.c_source.entry import entry_lines
from layflat.export.c_source.program import Program
from layflat.export.c_source.text import program_text
from layflat.export.numbers import c_number
from layflat.export.recording import DURATION, MOVE_TIME, cycles_of, move_target
from layflat.export.templates import fill_template
from layflat.files import check_folder, write_text
from layflat.machine import Machine


def write_source_folder(machine: Machine, folder: Path, *, target: str, precision: str) -> Iterator[Path]:  # noqa: ARG001
    """Write a folder with the control law as readable C; yield its files.

    Args:
        machine: the machine.
        folder: the folder.
        target: "c-source".
        precision: "double" or "single".

    Raises:
        InputError: the precision is unknown, or does not hold a parameter.
        MachineError: the machine lacks a controller, valve or sensor.
        KindError: the control law is plain Python, or has a construct without a counterpart in C.
        OutputError: a file can't be written.
    """
    interface = CInterface(machine, precision, plant=False)
    check_folder(folder, f"{interface.prefix}.h")
    texts = list(folder_texts(interface))
    for name, text in texts:
        yield write_text(folder / name, text)


def folder_texts(interface: CInterface) -> Iterator[tuple[str, str]]:
    """Yield name and content of the files of a folder."""
    prefix, values = interface.prefix, folder_values(interface)
    yield f"{prefix}.h", interface.api.header(values["title"], interface.constants({}), interface.tables)
    yield f"{prefix}.c", law_text(interface)
    yield "parameters.c", interface.api.source(f"{prefix}.h", interface.tables, checked=False)
    yield "recorded.h", fill_template("recorded.h", **values, **recorded_values(interface))
    yield "example.c", fill_template("recorded.c", **values)
    for name in ("Makefile", "CMakeLists.txt", "README.md"):
        yield name, fill_template(f"source/{name}", **values)


def folder_values(interface: CInterface) -> dict[str, Any]:
    """Return the values of all templates."""
    machine = interface.machine
    return {
        "title": machine.name, "version": __version__, "prefix": interface.prefix, "macro": interface.prefix.upper(),
        "real": interface.api.real, "precision": interface.precision,
        "digits": 17 if interface.precision == "double" else 9, "joints": len(machine.joints),
        "duration": f"{DURATION:g}", "cycle_ms": f"{1e3 * machine.cycle:g}", "cycles": cycles_of(DURATION, machine),
        "move_cycle": cycles_of(MOVE_TIME, machine),
        "target": [c_number(angle, interface.api.real) for angle in move_target(machine)],
    }  # fmt: skip


def law_text(interface: CInterface) -> str:
    """Return the source of the control law.

    Raises:
        KindError: a construct of the law has no counterpart in C.
    """
    program, entries = Program(interface.api, interface.precision), tuple(interface.control)
    for entry in entries:
        for argument in entry.arguments:
            if argument.like is not None:
                program.share(type_of_tuple(argument.like), interface.api.struct(argument))
    functions = {
        entry.name: entry_lines(program, entry, interface.api.prototype(entry).split("\n")) for entry in entries
    }
    head = fill_template("source/head.c", title=interface.machine.name, version=__version__, prefix=interface.prefix)
    return "\n".join([head.rstrip("\n"), *program_text(program, functions), ""])
