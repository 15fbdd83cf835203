"""Control cycles of a rig's loop in which things fail, recorded on this computer and replayed on a board."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.export.compiled import object_file
from layflat.export.header import Api
from layflat.export.targets import EXPORT_TARGETS
from layflat.machine import Machine
from layflat.rig.safety.core import CycleCore
from tests.export.firmware.boards import SOURCES, TICK, Board, execute, link
from tests.export.firmware.host_cycles import HostCycle
from tests.rig.fake_rig import Rig

FAILURES: tuple[Callable[[Rig], None], ...] = (
    lambda rig: setattr(rig.driver, "spoil", lambda angles, _: angles.__setitem__(1, np.nan)),
    lambda rig: setattr(rig.driver, "spoil", lambda _, pressures: pressures.__setitem__(1, 5e5)),
    lambda rig: setattr(rig.driver, "spoil", lambda angles, _: angles.__setitem__(0, 0.1)),
    lambda rig: setattr(rig.driver, "supply", 1.5e5),
    lambda rig: rig.bench.held.__setitem__(1, 0.4),
    lambda rig: setattr(rig.driver, "link", "lost"),
)
"""Ways in which a rig fails: sensors, supply, a valve, the link."""


class Cycles(NamedTuple):
    """Calls of the cycle: stages and outcome of each, and all numbers before and after it."""

    stages: NDArray[np.int64]
    outcomes: NDArray[np.int64]
    before: Array
    after: Array
    faults: NDArray[np.int64]  # worst fault of each


def numbers_of(core: CycleCore) -> Array:
    """Return all numbers that a cycle changes, in the order of the board's program."""
    law = core.law
    assert law is not None
    parts = core.inputs.array[0], core._joint_inputs, core.memory.array, law.memory.array[0], law.report.array
    return np.concatenate([part.ravel() for part in parts])


def record_cycles(machine: Machine, seed: int = 0, cycle: HostCycle | None = None) -> tuple[Cycles, list[str]]:
    """Return the calls and events of a rig's loop that moves, fails and starts again, once for each failure.

    Args:
        machine: the machine.
        seed: seed of demands and noise.
        cycle: cycle that takes the place of the loop's own.
    """
    rows: list[tuple[int, int, Array, Array, int]] = []
    events: list[str] = []
    rng = np.random.default_rng(seed)
    for failure in FAILURES:
        rig = Rig(machine, seed=seed)
        core = rig.supervisor.core
        core._perform = recorded(core, core._perform if cycle is None else cycle.perform(core), rows)
        working = core.settings["moving.working"]
        for _ in range(2):
            rig.host.demands = (rng.uniform(-0.7, 0.7, len(working)) * working).tolist()
            rig.seconds(0.5)
        failure(rig)
        rig.seconds(0.4)
        rig.driver.spoil, rig.driver.link, rig.driver.supply = lambda *_: None, None, None
        rig.bench.held[:] = 9.0
        rig.host.reset = True
        rig.cycles(2)
        rig.host.start = True
        rig.seconds(0.2)
        events += rig.host.lines
    return Cycles(*map(np.array, zip(*rows, strict=True))), events


def recorded(
    core: CycleCore, perform: Callable[..., int], rows: list[tuple[int, int, Array, Array, int]]
) -> Callable[..., int]:
    """Return the function that performs stages and adds a row."""

    def performed(stages: int) -> int:
        before = numbers_of(core)
        outcome = perform(stages)
        rig, joints = core.detected_faults
        rows.append((stages, outcome, before, numbers_of(core), max(rig, *joints)))
        return outcome

    return performed


class ReplayedCycles(NamedTuple):
    """Results of a board, and what they cost."""

    outcomes: Array
    after: Array
    instructions: Array
    stack: int  # bytes
    flash: int  # bytes
    ram: int  # bytes, with the stack


def program_parts(cycle: HostCycle, target: str, folder: Path) -> Iterator[Path]:
    """Yield the object files of a cycle; its header and settings are written beside them."""
    entries = cycle.entries
    api = Api("rig", cycle.precision, entries)
    (folder / "rig.h").write_text(api.header("rig", [], entries.tables()))
    (folder / "rig.c").write_text(api.source("rig.h", entries.tables()))
    for entry in entries:
        path = folder / f"{entry.name}.o"
        path.write_bytes(object_file(entry, cycle.texts[entry.name], "rig", EXPORT_TARGETS[target]))
        yield path


def replay_cycles(cycle: HostCycle, cycles: Cycles, target: str, board: Board, folder: Path) -> ReplayedCycles:
    """Return the results of recorded cycles on a board.

    Args:
        cycle: the cycle, whose portable code is used.
        cycles: what is replayed.
        target: name of the target.
        board: the board.
        folder: folder for the program.
    """
    image = link(board, [folder / "rig.c", SOURCES / "cycle.c"], list(program_parts(cycle, target, folder)), folder)
    count = cycles.before.shape[1]
    given = np.zeros(len(cycles.stages), np.dtype([("stages", np.int32, 2), ("numbers", cycle.real, count)]))
    given["stages"][:, 0], given["numbers"] = cycles.stages, cycles.before
    given.tofile(folder / "in.bin")
    execute(image)
    kind = np.dtype([("measured", np.uint32, 4), ("numbers", cycle.real, count)])
    rows = np.fromfile(folder / "out.bin", kind)
    outcomes, ticks, stack, _ = rows["measured"].T
    return ReplayedCycles(
        outcomes, rows["numbers"], ticks * TICK, int(stack[-1]), image.flash, image.ram + int(stack[-1])
    )
