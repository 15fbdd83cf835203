"""Sizes of exported code, the stack it takes, and the time of a call: the table of docs/export.md.

`python -m benchmarks.export_sizes --write` measures for some minutes, and writes the table to the page. Sizes are those
of this version of LLVM; instructions on simulated boards need QEMU and the compiler of ARM boards, FMUs zig. Times are
those of this computer, hence of its own target alone.
"""

import argparse
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from layflat.export.compiled import compiled_entry
from layflat.export.fmu.writer import write_fmus
from layflat.export.targets import EXPORT_TARGETS
from layflat.export.web.module import WebMachine, web_module
from layflat.jit.objects import code_size
from layflat.machine import load
from tests.export.firmware.boards import BOARDS
from tests.export.firmware.recordings import HostLaw, Recording, record_closed_loop
from tests.export.firmware.replays import input_bytes, replay, write_law

PAGE = Path(__file__).parents[1] / "docs" / "export.md"
MACHINES = ("paper-arm", "paper-arm-tracking", "picking-arm")
STEPS: tuple[tuple[str, str], ...] = (
    ("linux-x86-64", "double"), ("linux-aarch64", "double"), ("cortex-m7", "double"), ("cortex-m7", "single"),
    ("cortex-m4f", "double"), ("cortex-m4f", "single"), ("cortex-m33", "single"), ("riscv32", "double"),
)  # fmt: skip
"""Targets and precisions whose step of the control law is measured."""

FILES = ("fmu", "wasm")  # whose files are measured
CYCLES = 120  # that a board replays
TIMED_TARGET = "linux-x86-64"  # whose calls are timed here
TIMING_PROGRAM = Path(__file__).parent / "time_law.c"
FLASH = 4 << 20  # of a board, bytes: emulated double precision of four joints needs more than most have


def row_titles() -> list[str]:
    """Return the first column of the table."""
    return [f"`{target}`" + (", single" if precision == "single" else "") for target, precision in STEPS] + [
        f"`{name}`, file" for name in FILES
    ]


@cache
def _law(name: str, precision: str) -> tuple[HostLaw, Recording]:
    machine = load(name)
    return HostLaw(machine, precision), record_closed_loop(machine, CYCLES)


def step_figures(name: str, target: str, precision: str) -> list[int]:
    """Return size of the code and stack of a step of the control law, bytes, and what it takes where it is measured.

    That are the most instructions of a call on a board, or the mean time of a call on this computer, ns.

    Args:
        name: name of the machine.
        target: a key of `EXPORT_TARGETS`.
        precision: "double" or "single".
    """
    law, recording = _law(name, precision)
    (entry,) = (one for one in law.entries if one.name == "control_step")
    compiled = compiled_entry(entry, law.texts[entry.name], "law", EXPORT_TARGETS[target])
    figures = [code_size(compiled.code), compiled.stack]
    if target in BOARDS:
        with TemporaryDirectory() as folder:
            done = replay(law, recording, target, BOARDS[target]._replace(flash=FLASH), Path(folder))
        figures.append(int(done.instructions.max()))
    elif target == TIMED_TARGET:
        figures.append(call_time(law, recording))
    return figures


def call_time(law: HostLaw, recording: Recording) -> int:
    """Return the mean time of a step of the control law on this computer, from C, ns."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        objects = write_law(law, TIMED_TARGET, folder)
        files = [TIMING_PROGRAM, folder / "law.c", *objects]
        subprocess.run(["cc", "-O2", f"-I{folder}", *files, "-lm", "-o", folder / "time"], check=True)
        done = subprocess.run([folder / "time"], input=input_bytes(law, recording), capture_output=True, check=True)
        return int(done.stdout)


def file_size(name: str, kind: str) -> int:
    """Return the size of a machine's FMU by FMI 2.0 for all systems, or of its module of WebAssembly, bytes."""
    machine = load(name)
    if kind == "wasm":
        return len(web_module(WebMachine(machine), "wasm"))
    with TemporaryDirectory() as folder:
        files = write_fmus(machine, Path(folder), target="fmu", precision="double")
        return next(iter(files)).stat().st_size


def table_lines(figures: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of the table, from the cells of each row after its title."""
    yield "| target | " + " | ".join(MACHINES) + " |"
    yield "|---" + "|--:" * len(MACHINES) + "|"
    for title, cells in zip(row_titles(), figures, strict=True):
        yield f"| {title} | {' | '.join(cells)} |"


def table_of(page: str) -> list[str]:
    """Return the lines of the table in a page's text."""
    found = re.search(r"^\| target \| paper-arm \|.*\n(?:\|.*\n?)+", page, re.MULTILINE)
    assert found is not None
    return found[0].splitlines()


def main(words: Sequence[str] | None = None) -> None:
    """Measure, and print the table or write it to the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write the table to docs/export.md")
    options = parser.parse_args(words)
    figures = []
    for title, step in zip(row_titles(), [*STEPS, *((name, "") for name in FILES)], strict=True):
        target, precision = step
        numbers = [
            step_figures(name, target, precision) if precision else [file_size(name, target)] for name in MACHINES
        ]
        figures.append([", ".join(_grouped(number) for number in cell) for cell in numbers])
        sys.stderr.write(f"{title} {figures[-1]}\n")
    text, lines = PAGE.read_text(encoding="utf-8"), "\n".join(table_lines(figures))
    if options.write:
        PAGE.write_text(text.replace("\n".join(table_of(text)), lines), encoding="utf-8")
    else:
        sys.stdout.write(lines + "\n")


def _grouped(number: int) -> str:
    """Return a number with spaces between thousands, from five digits on, as the pages write them."""
    return f"{number:,}".replace(",", " ") if number >= 10_000 else str(number)


if __name__ == "__main__":
    main()
