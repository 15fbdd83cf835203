"""Replays of recorded cycles by a control law on a simulated board."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.export.compiled import object_file
from layflat.export.entries import number_of
from layflat.export.header import Api, Constant, Table
from layflat.export.targets import EXPORT_TARGETS
from tests.export.firmware.boards import SOURCES, Board, execute, link
from tests.export.firmware.recordings import HostLaw, Recording


class Replay(NamedTuple):
    """Results of a control law on a board, and what they cost."""

    results: Array  # memory, command and report of each cycle
    instructions: Array  # of each cycle
    stack: int  # bytes
    flash: int  # bytes, as the next; both with the program around the law
    ram: int  # with the stack


def write_law(law: HostLaw, target: str, folder: Path) -> list[Path]:
    """Write header, source and object files of a law for a target; return the object files.

    Args:
        law: the law, whose portable code is used.
        target: name of the target.
        folder: their folder.
    """
    precision = "double" if law.real.itemsize == 8 else "single"
    api, table = Api("law", precision, law.entries), Table("settings", law.entries.settings, "Settings of the machine")
    cycle = Constant("CYCLE", law.machine.cycle, "control cycle, s")
    (folder / "law.h").write_text(api.header(law.machine.name, [cycle], [table]))
    (folder / "law.c").write_text(api.source("law.h", [table]))
    objects = []
    for entry in law.entries:
        objects.append(folder / f"{entry.name}.o")
        objects[-1].write_bytes(object_file(entry, law.texts[entry.name], "law", EXPORT_TARGETS[target]))
    return objects


def input_bytes(law: HostLaw, recording: Recording) -> bytes:
    """Return recorded inputs as programs in C read them."""
    return recording.first.astype(law.real).tobytes() + recording.rows.astype(law.real).tobytes()


def replay(law: HostLaw, recording: Recording, target: str, board: Board, folder: Path) -> Replay:
    """Return the results of a law on a board.

    Args:
        law: the law, whose portable code is used.
        recording: inputs.
        target: name of the target.
        board: the board.
        folder: folder for the program.
    """
    objects = write_law(law, target, folder)
    image = link(board, [folder / "law.c", SOURCES / "law.c"], objects, folder)
    (folder / "in.bin").write_bytes(input_bytes(law, recording))
    execute(image)
    sizes = [number_of(value) for value in (law.entries.memory, law.entries.command, law.entries.report)]
    kind = np.dtype([("results", law.real, (sum(sizes),)), ("ticks", np.uint32), ("stack", np.uint32)])
    rows = np.frombuffer((folder / "out.bin").read_bytes()[sizes[0] * law.real.itemsize :], kind)
    stack = int(rows["stack"][-1])
    return Replay(rows["results"], rows["ticks"] * board.tick, stack, image.flash, image.ram + stack)
