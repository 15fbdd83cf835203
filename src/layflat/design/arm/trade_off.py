"""Mass against speed and pressure: an arm that is sized for a task at other supply pressures and other paces."""

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from layflat.design.arm.moves import TaskMoves
from layflat.design.arm.sizing import SizedArm, size_for_moves
from layflat.design.arm.task import ArmTask
from layflat.errors import DesignError
from layflat.files import write_text
from layflat.parallel import process_pool, processors

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PRESSURES = tuple(1e5 * bar for bar in (2.0, 4.0, 6.0, 8.0))  # gauge, Pa
PACE_RATIOS = tuple(float(pace) for pace in np.geomspace(0.7, 2.4, 7))  # durations of the moves over the task's


@dataclass(frozen=True)
class SizingTrial:
    """Result of the task at one supply pressure and one pace."""

    supply: float  # gauge, Pa
    time: float  # mean duration of its moves, s
    mass: float  # of the arm, kg; infinite if no arm can do the task
    flow: float  # sum of the valves' nominal flows, l/min
    refused: str = ""  # reason, if no arm can do the task


def trade_off(
    arm: SizedArm,
    pressures: Sequence[float] = PRESSURES,
    paces: Sequence[float] = PACE_RATIOS,
    *,
    advance: Callable[[int, int], None] = lambda *_: None,
) -> list[SizingTrial]:
    """Size an arm's task again at all supply pressures and paces, on all cores.

    Args:
        arm: sized for the task; its moves keep their configurations.
        pressures: pressures of the supply, gauge, Pa.
        paces: durations of the moves over the task's.
        advance: called with the numbers of trials done and of all trials.

    Returns:
        Trials in the order of pressures, and of paces within each.
    """
    jobs = [(pressure, pace) for pressure in pressures for pace in paces]
    work = partial(_try_sizing, arm.task, arm.moves)
    with process_pool(min(processors(), len(jobs))) as submit:
        running = [submit(work, *job) for job in jobs]
        for done, _ in enumerate(as_completed(running), 1):
            advance(done, len(jobs))
        return [job.result() for job in running]


def _try_sizing(task: ArmTask, moves: TaskMoves, supply: float, pace: float) -> SizingTrial:
    """Return mass and flow of the arm sized for moves `pace` times as long at a supply (Pa gauge); infinite if none."""
    slower = moves._replace(times=pace * moves.times)
    time = float(slower.times.mean())
    try:
        arm = size_for_moves(task.model_copy(update={"supply": supply}), slower)
    except DesignError as error:
        return SizingTrial(supply, time, inf, inf, f"{error.where}: {error.what}")
    return SizingTrial(supply, time, arm.mass, sum(part.valve.nominal_flow for part in arm.parts if part.valve))


def undominated(trials: Sequence[SizingTrial]) -> list[bool]:
    """Return for each trial whether it is Pareto-optimal in mass and time, at any pressure; False without an arm."""

    def better(a: SizingTrial, b: SizingTrial) -> bool:
        return a.mass <= b.mass and a.time <= b.time and (a.mass < b.mass or a.time < b.time)

    return [trial.mass < inf and not any(better(other, trial) for other in trials) for trial in trials]


def write_trials(trials: Sequence[SizingTrial], path: Path) -> Path:
    """Write trials to a CSV file, a row each, and return its path; raise OutputError if it can't be written there.

    Mass and flow are empty, and `refused` has the reason, where no arm can do the task.
    """
    rows = ["supply_bar_gauge,time_s,mass_kg,valves_l_per_min,undominated,refused"]
    for trial, best in zip(trials, undominated(trials), strict=True):
        sizes = f"{trial.mass:.6g},{trial.flow:.6g}" if trial.mass < inf else ","
        reason = '"' + trial.refused.replace('"', '""') + '"' if trial.refused else ""
        rows.append(f"{trial.supply / 1e5:.6g},{trial.time:.6g},{sizes},{int(best)},{reason}")
    return write_text(path, "\n".join(rows) + "\n")


def sizes_picture(arm: SizedArm, trials: Sequence[SizingTrial]) -> "Figure":
    """Draw masses of trials over the duration of a move, a curve per pressure, with the arm that they start from.

    Trials of one pressure follow each other, as `trade_off` returns them.
    """
    from layflat.plot.arms import SizedArms, sizes_figure  # noqa: PLC0415  # matplotlib takes long to import

    marked = zip(trials, undominated(trials), strict=True)
    sizes = []
    for pressure, group in groupby(marked, lambda pair: pair[0].supply):
        members, best = zip(*group, strict=True)
        columns = zip(*((trial.time, trial.mass) for trial in members), strict=True)
        times, masses = (np.array(column) for column in columns)
        sizes.append(SizedArms(pressure / 1e5, times, masses, np.array(best, dtype=float)))
    return sizes_figure(sizes, (float(arm.moves.times.mean()), arm.mass))
