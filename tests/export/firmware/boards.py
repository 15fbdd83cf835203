"""Simulated boards: programs for a microcontroller, linked within its flash and RAM, and run in qemu."""

import os
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import pytest

SOURCES = Path(__file__).parent / "board"
TICK = 40  # instructions: each takes 1 ns, and the boards' processors have 25 MHz
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
TOOLS = {"arm-none-eabi-gcc": "gcc-arm-none-eabi and libnewlib-arm-none-eabi", "qemu-system-arm": "qemu-system-arm"}


WHOLE_CHECK = pytest.mark.skipif("LAYFLAT_EXPORT_CHECK" not in os.environ, reason="takes long: in make export-check")


class Board(NamedTuple):
    """Board of qemu, with a microcontroller of limited size."""

    machine: str
    processor: str
    fpu: str
    flash: int = 512 * 1024  # bytes
    ram: int = 64 * 1024


BOARDS = {
    "cortex-m7": Board("mps2-an500", "cortex-m7", "fpv5-d16"),
    "cortex-m4f": Board("mps2-an386", "cortex-m4", "fpv4-sp-d16"),
}


class Image(NamedTuple):
    """Linked program."""

    path: Path
    board: Board
    flash: int  # bytes that it takes of it, with the initial values of variables
    ram: int  # bytes of variables, without the stack


def require_tools(names: Iterable[str] = tuple(TOOLS)) -> None:
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
    flags = f"-mcpu={board.processor} -mthumb -mfloat-abi=hard -mfpu={board.fpu} -std=c11 -O2 -ffp-contract=off"
    path = folder / "program.elf"
    command: list[str | Path] = [
        "arm-none-eabi-gcc", *flags.split(), *WARNINGS, "-ffreestanding", "-nostartfiles", f"-I{folder}",
        f"-I{SOURCES}", SOURCES / "start.c", *sources, *objects, "-lm", "-Wl,-z,noexecstack",
        f"-Wl,--defsym=FLASH_BYTES={board.flash},--defsym=RAM_BYTES={board.ram}", "-T", SOURCES / "mps2.ld", "-o", path,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    size = subprocess.run(["arm-none-eabi-size", path], capture_output=True, text=True, check=True)
    text_size, data, bss = map(int, size.stdout.splitlines()[1].split()[:3])
    return Image(path, board, text_size + data, data + bss)


def execute(image: Image, timeout: float = 300.0) -> None:
    """Run a program to its end, in its folder; every instruction takes 1 ns of the simulated time.

    Args:
        image: the program.
        timeout: time that it may take, s.
    """
    command = (
        f"qemu-system-arm -M {image.board.machine} -cpu {image.board.processor} -nographic -monitor none -serial none "
        f"-icount shift=0 -semihosting-config enable=on,target=native -kernel {image.path.name}"
    )
    done = subprocess.run(
        command.split(), cwd=image.path.parent, capture_output=True, text=True, timeout=timeout, check=False
    )
    assert done.returncode == 0, f"the program ended with {done.returncode}: {done.stderr}"
