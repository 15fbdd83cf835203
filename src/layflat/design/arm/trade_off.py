"""Mass and cost against speed and pressure: an arm sized for a task at other supply pressures and other paces."""

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from math import inf, isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.design.arm.moves import TaskMoves
from layflat.design.arm.sizing import SizedArm, size_for_moves
from layflat.design.arm.task import ArmTask
from layflat.errors import DesignError
from layflat.files import write_text
from layflat.machine import Machine
from layflat.parallel import process_pool, processors

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PRESSURES = tuple(1e5 * bar for bar in (2.0, 4.0, 6.0, 8.0))  # gauge, Pa
PACE_RATIOS = tuple(float(pace) for pace in np.geomspace(0.7, 2.4, 7))  # durations of the moves over the task's

Totals = Callable[[Machine], tuple[float, float]]
"""Function that returns mass (kg) and cost of a machine as it would be built; the cost is not a number without prices.

It raises DesignError if the machine can't be built.
"""


@dataclass(frozen=True)
class SizingTrial:
    """Result of the task at one supply pressure and one pace."""

    supply: float  # gauge, Pa
    time: float  # mean duration of its moves, s
    mass: float  # of the arm by the laws of sizing, kg; infinite if no arm can do the task
    flow: float  # sum of the valves' nominal flows, l/min
    refused: str = ""  # reason, if no arm can do the task, or it can't be built
    built_mass: float = nan  # of the arm as built, kg; infinite if it can't be built, not a number if not asked for
    cost: float = nan  # of the arm as built; the same

    @property
    def criteria(self) -> tuple[float, ...]:
        """Time, mass and, if there are prices, cost; the mass is that of the arm as built where it is asked for."""
        mass = self.mass if isnan(self.built_mass) else self.built_mass
        return (self.time, mass) if isnan(self.cost) else (self.time, mass, self.cost)


def trade_off(
    arm: SizedArm,
    pressures: Sequence[float] = PRESSURES,
    paces: Sequence[float] = PACE_RATIOS,
    *,
    totals: Totals | None = None,
    advance: Callable[[int, int], None] = lambda *_: None,
) -> list[SizingTrial]:
    """Size an arm's task again at all supply pressures and paces, on all cores.

    Args:
        arm: sized for the task; its moves keep their configurations.
        pressures: pressures of the supply, gauge, Pa.
        paces: durations of the moves over the task's.
        totals: to compare arms as they would be built; default: by the masses of sizing. It is called in processes.
        advance: called with the numbers of trials done and of all trials.

    Returns:
        Trials in the order of pressures, and of paces within each.
    """
    jobs = [(pressure, pace) for pressure in pressures for pace in paces]
    work = partial(_try_sizing, arm.task, arm.moves, totals)
    with process_pool(min(processors(), len(jobs))) as submit:
        running = [submit(work, *job) for job in jobs]
        for done, _ in enumerate(as_completed(running), 1):
            advance(done, len(jobs))
        return [job.result() for job in running]


def _try_sizing(task: ArmTask, moves: TaskMoves, totals: Totals | None, supply: float, pace: float) -> SizingTrial:
    """Return the trial of an arm sized for moves `pace` times as long at a supply (Pa gauge)."""
    slower = moves._replace(times=pace * moves.times)
    time = float(slower.times.mean())
    try:
        arm = size_for_moves(task.model_copy(update={"supply": supply}), slower)
    except DesignError as error:
        none = (inf, inf) if totals else (nan, nan)
        return SizingTrial(supply, time, inf, inf, f"{error.where}: {error.what}", *none)
    trial = SizingTrial(supply, time, arm.mass, sum(part.valve.nominal_flow for part in arm.parts if part.valve))
    return trial if totals is None else replace(trial, **_built_values(arm, totals))


def _built_values(arm: SizedArm, totals: Totals) -> dict[str, Any]:
    """Return mass and cost of an arm as built by the fields of its trial, or why it can't be built."""
    try:
        built_mass, cost = totals(arm.machine)
    except DesignError as error:
        return {"built_mass": inf, "cost": inf, "refused": f"can't be built: {error}"}
    return {"built_mass": built_mass, "cost": cost}


def undominated(trials: Sequence[SizingTrial]) -> list[bool]:
    """Return for each trial whether it is Pareto-optimal in its criteria, at any pressure; False without an arm."""

    def better(a: SizingTrial, b: SizingTrial) -> bool:
        pairs = list(zip(a.criteria, b.criteria, strict=False))
        return all(one <= other for one, other in pairs) and any(one < other for one, other in pairs)

    return [max(trial.criteria) < inf and not any(better(other, trial) for other in trials) for trial in trials]


def write_trials(trials: Sequence[SizingTrial], path: Path) -> Path:
    """Write trials to a CSV file, a row each, and return its path; raise OutputError if it can't be written there.

    Values are empty, and `refused` has the reason, where no arm can do the task or be built. Mass and cost as built
    have columns if any trial has them.
    """
    extra = [key for key in ("built_mass", "cost") if any(getattr(trial, key) < inf for trial in trials)]
    heads = {"built_mass": "built_mass_kg"}
    columns = ["mass_kg", "valves_l_per_min", *(heads.get(key, key) for key in extra)]
    rows = [",".join(["supply_bar_gauge", "time_s", *columns, "undominated", "refused"])]
    for trial, best in zip(trials, undominated(trials), strict=True):
        values = (trial.mass, trial.flow, *(getattr(trial, key) for key in extra))
        sizes = ",".join(f"{value:.6g}" if value < inf else "" for value in values)
        reason = '"' + trial.refused.replace('"', '""') + '"' if trial.refused else ""
        rows.append(f"{trial.supply / 1e5:.6g},{trial.time:.6g},{sizes},{int(best)},{reason}")
    return write_text(path, "\n".join(rows) + "\n")


def sizes_picture(arm: SizedArm, trials: Sequence[SizingTrial], built: tuple[float, float] | None = None) -> "Figure":
    """Draw masses of trials, and costs if they have them, over the duration of a move, a curve per pressure.

    Args:
        arm: from which they start.
        trials: those of one pressure follow each other, as `trade_off` returns them.
        built: mass (kg) and cost of the arm as built; None where trials are compared by the masses of sizing.
    """
    from layflat.plot.arms import SizedArms, sizes_figure  # noqa: PLC0415  # matplotlib takes long to import

    marked = zip(trials, undominated(trials), strict=True)
    sizes = []
    for pressure, group in groupby(marked, lambda pair: pair[0].supply):
        members, best = zip(*group, strict=True)
        rows = [(*trial.criteria, nan)[:3] for trial in members]
        times, masses, costs = (np.array(column) for column in zip(*rows, strict=True))
        sizes.append(SizedArms(pressure / 1e5, times, masses, np.array(best, dtype=float), costs))
    mass, cost = (arm.mass, nan) if built is None else built
    return sizes_figure(sizes, (float(arm.moves.times.mean()), mass, cost), built=built is not None)
