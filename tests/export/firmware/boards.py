"""Simulated boards: programs for a microcontroller, linked within its flash and RAM, and run in qemu."""

import os
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import pytest

from layflat.export.boards import COMPILER_PACKAGES, EXAMPLE_BOARDS, ExampleBoard

SOURCES = Path(__file__).parent / "board"
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
TOOLS = {**COMPILER_PACKAGES, "qemu-system-arm": "qemu-system-arm", "qemu-system-riscv32": "qemu-system-misc"}
ARM_TOOLS = "arm-none-eabi-gcc", "qemu-system-arm"


WHOLE_CHECK = pytest.mark.skipif("LAYFLAT_EXPORT_CHECK" not in os.environ, reason="takes long: in make export-check")


class Board(NamedTuple):
    """Board of qemu, with a microcontroller of limited size."""

    example: ExampleBoard
    tick: int  # instructions from tick to tick of its clock, each of which takes 1 ns
    flash: int = 512 * 1024  # bytes
    ram: int = 64 * 1024

    @property
    def emulator(self) -> str:
        """Command that begins to simulate it."""
        program, machine = self.example.tools[1], self.example.name
        return f"{program} -M {machine} -nographic -monitor none" + (" -bios none" if "riscv" in program else "")


BOARDS = {
    name: Board(EXAMPLE_BOARDS[name], tick)
    for name, tick in (("cortex-m7", 40), ("cortex-m4f", 40), ("cortex-m33", 50), ("riscv32", 1))
}


class Image(NamedTuple):
    """Linked program."""

    path: Path
    board: Board
    flash: int  # bytes that it takes of it, with the initial values of variables
    ram: int  # bytes of variables, without the stack


def require_tools(names: Iterable[str] = ARM_TOOLS) -> None:
    """Skip the test where a tool is missing."""
    for name in names:
        if shutil.which(name) is None:
            pytest.skip(f"needs {name}: install {TOOLS[name]}")


def link(board: Board, sources: Iterable[Path], objects: Iterable[Path], folder: Path) -> Image:
    """Return the program of C sources and object files, linked in a folder that also holds their headers.

    Args:
        board: the board.
        sources: files of C, besides the start of the board.
        objects: object files.
        folder: folder of the program.
    """
    example, path = board.example, folder / "program.elf"
    start = SOURCES / ("start_riscv.c" if example.template == "riscv" else "start_arm.c")
    places = {
        "FLASH_START": example.flash.start, "FLASH_BYTES": board.flash,
        "RAM_START": example.ram.start, "RAM_BYTES": board.ram,
    }  # fmt: skip
    command: list[str | Path] = [
        example.compiler, *example.options.split(), "-std=c11", "-O2", "-ffp-contract=off", *WARNINGS, "-ffreestanding",
        "-nostartfiles", f"-I{folder}", f"-I{SOURCES}", start, SOURCES / "start.c", *sources, *objects, "-lm",
        "-Wl,-z,noexecstack", *(f"-Wl,--defsym={name}={place}" for name, place in places.items()),
        "-T", SOURCES / "board.ld", "-o", path,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    size = subprocess.run([example.compiler.replace("gcc", "size"), path], capture_output=True, text=True, check=True)
    text_size, data, bss = map(int, size.stdout.splitlines()[1].split()[:3])
    return Image(path, board, text_size + data, data + bss)


def execute(image: Image, timeout: float = 300.0) -> None:
    """Run a program to its end, in its folder; every instruction takes 1 ns of the simulated time.

    Args:
        image: the program.
        timeout: time that it may take, s.
    """
    command = (
        f"{image.board.emulator} -serial none -icount shift=0 -semihosting-config enable=on,target=native "
        f"-kernel {image.path.name}"
    )
    done = subprocess.run(
        command.split(), cwd=image.path.parent, capture_output=True, text=True, timeout=timeout, check=False
    )
    assert done.returncode == 0, f"the program ended with {done.returncode}: {done.stderr}"
