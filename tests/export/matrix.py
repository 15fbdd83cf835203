"""Every target with every machine: the whole matrix, of which `make test` runs a corner.

    python -m tests.export.matrix [NAME|FILE ...]

Each line is a machine, a target, seconds and the outcome: "same" to the bit in a closed loop of 2 s with noise,
"skipped" for want of a tool, which is named, or the difference, which makes the status 1.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Any

import numpy as np
import pytest

from layflat.arrays import Array
from layflat.export import c_folder, export
from layflat.export.boards import EXAMPLE_BOARDS
from layflat.export.compiled import portable_entry
from layflat.export.entries import Entry
from layflat.export.firmware import folder as firmware
from layflat.export.fmu.libraries import C_COMPILERS
from layflat.export.host import HostControl
from layflat.export.recording import RecordedCycles, record
from layflat.export.targets import EXPORT_TARGETS
from layflat.export.web.module import WebMachine
from layflat.machine import Machine, load
from tests.export.builds import (
    LANGUAGES,
    LEVELS,
    SANITIZED,
    STRICT,
    build,
    needing,
    read_trace,
    run,
    run_board,
    target_runs_here,
    zig_compiler,
)
from tests.export.c_source.programs import different_cycles, last_line_of_example
from tests.export.fmu.runs import check_fmus
from tests.export.loops import python_trace
from tests.export.web.traces import check_trace, node_trace
from tests.test_outside_kinds import COMPILED, outside_machine

MACHINES = ("paper-arm", "paper-arm-tracking", "picking-arm")

Check = tuple[str, Callable[[], None]]  # name of a target, and a function that raises AssertionError where it differs


def computers(machine: Machine, folder: Path, reference: Array) -> Iterator[Check]:
    """Checks of the folder "c": processors of this computer, a 64-bit ARM in QEMU, Windows by Wine."""
    export(machine, "c", folder)

    def same(text: str) -> None:
        assert np.array_equal(read_trace(text)[:, 1:], reference[:, 1:])

    def native(compiler: str, target: str) -> None:
        if not target_runs_here(target):
            pytest.skip(f"no processor of {target}")
        same(run([build(folder, needing(compiler), *LANGUAGES["C"], *STRICT, *SANITIZED, target=target)], folder))

    def aarch64() -> None:
        needing("qemu-aarch64")
        program = build(folder, needing("aarch64-linux-gnu-gcc"), *LANGUAGES["C"], *STRICT, target="linux-aarch64")
        same(run(["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu", program], folder))

    def windows() -> None:
        needing("wine")
        compiler = (
            "x86_64-w64-mingw32-gcc" if which("x86_64-w64-mingw32-gcc") else zig_compiler(folder, "windows-x86-64")
        )
        program = build(folder, compiler, *LANGUAGES["C"], *STRICT, target="windows-x86-64")
        same(run(["wine", program], folder))

    def macos(target: str) -> None:
        build(folder, zig_compiler(folder, target), *LANGUAGES["C"], *STRICT, target=target)

    for compiler in ("gcc", "clang"):
        for target in LEVELS:
            yield f"{target} ({compiler})", lambda compiler=compiler, target=target: native(compiler, target)  # type: ignore[misc]
    yield "linux-aarch64", aarch64
    yield "windows-x86-64", windows
    for target in ("macos-x86-64", "macos-aarch64"):
        yield f"{target} (linked alone)", lambda target=target: macos(target)  # type: ignore[misc]


def single(machine: Machine, folder: Path) -> Iterator[Check]:
    """Check of the control law in single precision on this computer."""

    def check() -> None:
        export(machine, "c", folder, precision="single")
        program = build(folder, needing("gcc"), *LANGUAGES["C"], *STRICT)
        assert run([program], folder).splitlines()[-1].startswith("0 of ")

    yield "linux-x86-64, single", check


def sources(machine: Machine, folder: Path) -> Iterator[Check]:
    """Checks of the control law as readable C on this computer, in both precisions."""
    for precision in ("double", "single"):

        def check(precision: str = precision) -> None:
            export(machine, "c-source", folder / precision, precision=precision)
            for compiler in ("gcc", "clang"):
                assert list(different_cycles(machine, folder / precision, precision, needing(compiler))) == []
                assert last_line_of_example(folder / precision, compiler).startswith("0 of ")

        yield f"c-source, {precision}", check


def microcontrollers(machine: Machine, folder: Path) -> Iterator[Check]:
    """Checks of the control law on boards in QEMU, in both precisions."""
    for target, board in EXAMPLE_BOARDS.items():
        for precision in EXPORT_TARGETS[target].precisions:

            def check(target: str = target, precision: str = precision, tools: tuple[str, str] = board.tools) -> None:
                for tool in tools:
                    needing(tool)
                export(machine, target, folder / f"{target}-{precision}", precision=precision)
                assert run_board(folder / f"{target}-{precision}", *tools).startswith("0 of ")

            yield f"{target}, {precision}", check


def simulators(machine: Machine, folder: Path) -> Iterator[Check]:
    """Check of the FMUs on this computer."""

    def check() -> None:
        if find_spec("ziglang") is None and not any(map(which, C_COMPILERS)):
            pytest.skip("no ziglang, and no C compiler")
        check_fmus(machine, folder)

    yield "fmu, 2.0 and 3.0", check


def engines(machine: Machine, folder: Path) -> Iterator[Check]:
    """Checks of plant and control laws as WebAssembly under Node.js."""
    for target in ("wasm", "wasm-plain"):

        def check(target: str = target) -> None:
            needing("node")
            place = folder / target
            export(machine, target, place / "package")
            for law in WebMachine(machine).laws:
                check_trace(node_trace(place / "package", place, machine, law), machine, law, interpreted=20)

        yield target, check


def checks(machine: Machine, folder: Path) -> Iterator[Check]:
    """All checks of a machine."""
    yield from computers(machine, folder / "c", python_trace(machine))
    yield from single(machine, folder / "single")
    yield from sources(machine, folder / "source")
    yield from microcontrollers(machine, folder)
    yield from simulators(machine, folder / "fmu")
    yield from engines(machine, folder)


@contextmanager
def compiled_once() -> Iterator[None]:
    """Keep the portable text of a machine's entries, and its recording, for all targets."""
    kept: dict[tuple[str, ...], Any] = {}

    def text_of(entry: Entry, prefix: str, precision: str) -> str:
        key = entry.name, prefix, precision
        if key not in kept:
            kept[key] = portable_entry(entry, prefix, precision)
        return str(kept[key])

    def recording_of(machine: Machine, control: HostControl) -> RecordedCycles:
        key = machine.name, control.dtype.__name__
        if key not in kept:
            kept[key] = record(machine, control)
        return kept[key]  # type: ignore[no-any-return]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(c_folder, "portable_entry", text_of)
        patch.setattr(firmware, "portable_entry", text_of)
        patch.setattr(c_folder, "record", recording_of)
        yield


def outcome(check: Callable[[], None]) -> str:
    """Return "same", the tool that is missing, or the difference."""
    try:
        check()
    except pytest.skip.Exception as missing:
        return f"skipped: {missing}"
    except AssertionError as error:
        return f"DIFFERS: {' '.join(str(error).split())[-120:] or 'other numbers'}"
    return "same"


def main(names: list[str]) -> int:
    """Run the matrix; return 1 if a target differs."""
    different = 0
    with TemporaryDirectory() as name:
        folder = Path(name)
        for described in names or [*MACHINES, str(outside_machine(folder, COMPILED))]:
            machine = load(described)
            with compiled_once():
                for target, check in checks(machine, folder / machine.name):
                    start = monotonic()
                    result = outcome(check)
                    different += result.startswith("DIFFERS")
                    sys.stdout.write(f"{machine.name:20} {target:28} {monotonic() - start:5.0f} s  {result}\n")
                    sys.stdout.flush()
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
