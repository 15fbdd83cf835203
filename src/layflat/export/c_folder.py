"""Folders of C: machine code by target, header, parameters, an example that compiles as it is, and a page about it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from layflat._version import __version__
from layflat.errors import InputError
from layflat.export.boards import EXAMPLE_BOARDS
from layflat.export.c_interface import CInterface
from layflat.export.compiled import CompiledEntry, compiled_entry, portable_entry
from layflat.export.firmware.folder import firmware_files
from layflat.export.host import HostControl
from layflat.export.numbers import c_number
from layflat.export.recording import DURATION, MOVE_TIME, cycles_of, move_target, record
from layflat.export.targets import EXPORT_TARGETS
from layflat.export.templates import fill_template
from layflat.files import check_folder, whole_file, write_text
from layflat.jit.objects import code_size
from layflat.machine import Machine

COMPUTER_TARGETS = tuple(name for name in EXPORT_TARGETS if name.startswith(("linux-", "windows-", "macos-")))
"""Targets of the folder "c": all computers."""


class _Built(NamedTuple):
    """Interface of a machine with the machine code of its entries."""

    interface: CInterface
    texts: dict[str, str]  # portable text by entry
    code: dict[str, dict[str, CompiledEntry]]  # by target and entry

    def stack(self) -> dict[str, int]:
        """Return the upper bound of each entry's stack over all targets, bytes."""
        return {one.name: max(code[one.name].stack for code in self.code.values()) for one in self.interface.entries}


def write_c_folder(machine: Machine, folder: Path, *, target: str, precision: str) -> Iterator[Path]:
    """Write a folder of C; yield its files.

    Args:
        machine: the machine.
        folder: the folder.
        target: "c" for all computers, or a processor of `targets.EXPORT_TARGETS`.
        precision: "double" or "single"; in single precision the control law alone is exported.

    Raises:
        InputError: the precision is unknown, or does not hold a parameter.
        MachineError: the machine lacks a controller, valve or sensor.
        KindError: the control law is plain Python.
        OutputError: a file can't be written.
    """
    names = COMPUTER_TARGETS if target == "c" else (target,)
    interface = CInterface(machine, precision, plant=target == "c")
    check_folder(folder, f"{interface.prefix}.h")
    built = _build(interface, names)
    board = EXAMPLE_BOARDS.get(target)
    firmware, no_rig = _firmware(machine, target, precision)
    texts = list(_texts(built, board, firmware=bool(firmware), no_rig=no_rig))
    for name, entries in built.code.items():
        for entry, compiled in entries.items():
            path = folder / "lib" / name / f"{entry}{EXPORT_TARGETS[name].object_suffix}"
            yield _write(path, board.with_exact_sums(compiled.code) if board else compiled.code)
    for name, text in texts:
        yield write_text(folder / name, text)
    for name, content in firmware:
        yield _write(folder / "firmware" / name, content)


def _build(interface: CInterface, targets: tuple[str, ...]) -> _Built:
    """Compile all entries of an interface for targets."""
    prefix = interface.prefix
    texts = {one.name: portable_entry(one, prefix, interface.precision) for one in interface.entries}
    code = {
        name: {
            one.name: compiled_entry(one, texts[one.name], prefix, EXPORT_TARGETS[name]) for one in interface.entries
        }
        for name in targets
    }
    return _Built(interface, texts, code)


def _write(path: Path, content: str | bytes) -> Path:
    """Write a text file or an object file, and return its path."""
    if isinstance(content, str):
        return write_text(path, content)
    with whole_file(path) as temporary:
        temporary.write_bytes(content)
    return path


def _firmware(machine: Machine, target: str, precision: str) -> tuple[list[tuple[str, str | bytes]], str]:
    """Return name and content of each file of the firmware, and why there are none where the machine can't be a rig."""
    if target not in EXAMPLE_BOARDS:
        return [], ""
    try:
        return list(firmware_files(machine, target, precision, EXAMPLE_BOARDS[target])), ""
    except InputError as error:
        return [], str(error)


def _texts(built: _Built, board: Any, *, firmware: bool, no_rig: str) -> Iterator[tuple[str, str]]:
    """Yield name and content of each text file of a folder, of which the page tells whether there is firmware."""
    interface, prefix = built.interface, built.interface.prefix
    values = _values(built)
    yield f"{prefix}.h", interface.api.header(values["title"], interface.constants(built.stack()), interface.tables)
    yield f"{prefix}.c", interface.api.source(f"{prefix}.h", interface.tables)
    if interface.plant is None:
        yield "recorded.h", fill_template("recorded.h", **values, **recorded_values(interface, built.texts))
    yield "example.c", fill_template("recorded.c" if interface.plant is None else "loop.c", **values)
    if board is None:
        yield "Makefile", fill_template("Makefile", **values)
        yield "CMakeLists.txt", fill_template("CMakeLists.txt", **values)
    else:
        yield from board.texts(values)
    sums = board is not None and board.has_sums(interface.precision)
    about = {"board": None if board is None else board.name, "firmware": firmware, "no_rig": no_rig, "sums": sums}
    yield "README.md", fill_template("README.md", **values, **about)


def _values(built: _Built) -> dict[str, Any]:
    """Return the values of all templates."""
    interface, machine = built.interface, built.interface.machine
    names = [one.name for one in interface.entries]
    sizes = [
        {"target": name, "title": EXPORT_TARGETS[name].title, "sizes": [_size_text(code[one]) for one in names]}
        for name, code in built.code.items()
    ]
    return {
        "title": machine.name, "version": __version__, "prefix": interface.prefix,
        "macro": interface.prefix.upper(), "real": interface.api.real, "precision": interface.precision,
        "digits": 17 if interface.precision == "double" else 9, "plant": interface.plant is not None,
        "steps": interface.plant.steps if interface.plant is not None else 0, "joints": len(machine.joints),
        "duration": f"{DURATION:g}", "cycle_ms": f"{1e3 * machine.cycle:g}", "cycles": cycles_of(DURATION, machine),
        "move_cycle": cycles_of(MOVE_TIME, machine), "names": names, "sizes": sizes,
        "target": [c_number(angle, interface.api.real) for angle in move_target(machine)],
    }  # fmt: skip


def _size_text(compiled: CompiledEntry) -> str:
    return f"{code_size(compiled.code)}, stack {compiled.stack}"


def recorded_values(interface: CInterface, texts: dict[str, str] | None = None) -> dict[str, Any]:
    """Return the values of recorded.h, as C.

    Args:
        interface: the interface.
        texts: portable text by entry, if it is there already.
    """
    prefix, precision, real = interface.prefix, interface.precision, interface.api.real
    if texts is None:
        texts = {one.name: portable_entry(one, prefix, precision) for one in interface.control}
    recording = record(interface.machine, HostControl(interface.control, texts, prefix, precision))
    n = len(interface.machine.joints)

    def row(numbers: Any) -> str:
        return f"{{{', '.join(c_number(float(number), real) for number in numbers)}}}"

    def readings(numbers: Any) -> str:
        return f"{{{row(numbers[:n])}, {row(numbers[n:])}}}"

    return {
        "rest": readings(recording.rest),
        "sensed": [readings(numbers) for numbers in recording.sensed],
        "voltage": [row(numbers) for numbers in recording.voltage],
    }
