"""Mass against speed and pressure: an arm that is sized for a task at other supply pressures and other paces."""

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path

import numpy as np

from layflat.design.arm.moves import Moves
from layflat.design.arm.sizing import SizedArm, size_arm
from layflat.design.arm.task import ArmTask
from layflat.errors import DesignError
from layflat.files import write_text
from layflat.parallel import process_pool, processors

PRESSURES = tuple(1e5 * bar for bar in (2.0, 4.0, 6.0, 8.0))  # gauge, Pa
PACES = tuple(float(pace) for pace in np.geomspace(0.7, 2.4, 7))  # times of the moves over those of the task


@dataclass(frozen=True)
class Trial:
    """The task at one pressure and one pace."""

    supply: float  # gauge, Pa
    time: float  # of its moves, their mean, s
    mass: float  # of the arm, kg; infinite where none can do it
    flow: float  # nominal, of all its valves together, l/min
    refused: str = ""  # why no arm can do it


def trade_off(
    arm: SizedArm,
    pressures: Sequence[float] = PRESSURES,
    paces: Sequence[float] = PACES,
    *,
    advance: Callable[[int, int], None] = lambda *_: None,
) -> list[Trial]:
    """Size an arm's task anew at all pressures (gauge, Pa) and paces, pressure by pressure, on all cores.

    Args:
        arm: that was sized for the task; its moves go through the same postures.
        pressures: of the supply, gauge, Pa.
        paces: times of the moves over those of the task.
        advance: is called with how many are done and how many there are.
    """
    jobs = [(pressure, pace) for pressure in pressures for pace in paces]
    work = partial(_trial, arm.task, arm.moves)
    with process_pool(min(processors(), len(jobs))) as submit:
        running = [submit(work, *job) for job in jobs]
        for done, _ in enumerate(as_completed(running), 1):
            advance(done, len(jobs))
        return [one.result() for one in running]


def _trial(task: ArmTask, moves: Moves, supply: float, pace: float) -> Trial:
    slower = moves._replace(times=pace * moves.times)
    time = float(slower.times.mean())
    try:
        arm = size_arm(task.model_copy(update={"supply": supply}), moves=slower)
    except DesignError as error:
        return Trial(supply, time, inf, inf, f"{error.where}: {error.what}")
    return Trial(supply, time, arm.mass, sum(part.valve.nominal_flow for part in arm.parts if part.valve))


def undominated(trials: Sequence[Trial]) -> list[bool]:
    """Return whether no other trial is both as quick and as light, and one of them more so; at whatever pressure."""

    def better(a: Trial, b: Trial) -> bool:
        return a.mass <= b.mass and a.time <= b.time and (a.mass < b.mass or a.time < b.time)

    return [one.mass < inf and not any(better(other, one) for other in trials) for one in trials]


def write_trials(trials: Sequence[Trial], path: Path) -> Path:
    """Write trials to a CSV file, a row each; raise OutputError if it can't be written there."""
    rows = ["supply_bar_gauge,time_s,mass_kg,valves_l_per_min,undominated,refused"]
    for one, best in zip(trials, undominated(trials), strict=True):
        known = f"{one.mass:.6g},{one.flow:.6g}" if one.mass < inf else ","
        why = '"' + one.refused.replace('"', '""') + '"' if one.refused else ""
        rows.append(f"{one.supply / 1e5:.6g},{one.time:.6g},{known},{int(best)},{why}")
    return write_text(path, "\n".join(rows) + "\n")
