"""From a choice to a task: heights of the lift that follow from the cell's description and the fruit's diameter."""

from __future__ import annotations

from dataclasses import replace
from math import cos, dist, sin

from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Cup
from layflat.cell.plan.containers import Place
from layflat.cell.plan.fruit import Fruit
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import Rules, Task
from layflat.cell.reach import Angles, Reach

GAP = 10e-3
"""Between what passes and what it passes over, m."""

PRESSED = 3e-3
"""By how much the cup is led lower than a fruit's top is thought to be, m; the lift gives way."""

DROP = 2e-3
"""Over the floor of its place, at which a fruit is released, m."""


class Heights:
    """Heights of the cup's lip in a cell, m."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self.passing = min(cell.obstacle_height + GAP, cell.lift.clearance)

    def task(self, choice: Choice) -> Task:
        """Return what has to be done for a choice."""
        flattening = self._cell.produce[choice.fruit.kind].flattening
        tall = flattening.mean * choice.fruit.diameter
        least, most = flattening.least * choice.fruit.diameter, flattening.most * choice.fruit.diameter
        tray = self._cell.tray_at(choice.fruit.x, choice.fruit.y)
        floor = tray.wall if tray is not None else 0.0
        return Task(
            choice.over_fruit.angles,
            choice.over_place.angles,
            fruit_height=floor + tall - PRESSED,
            lowest=floor + least - PRESSED,
            place_height=choice.place.z + tall - PRESSED + DROP,
            passing=self.passing,
            carrying=min(self.passing + most, self._cell.lift.clearance),
        )


def centred(task: Task, fruit: Fruit, place: Place, at: Angles, reach: Reach) -> Task:
    """Return the task with the fruit's middle, not the cup's, over the middle of its place.

    The cup sits beside the fruit's middle by what the arm is off when it sucks; that turns with the last link.

    Args:
        task: as planned.
        fruit: where it was detected.
        place: where it goes.
        at: angles at which the cup sits on the fruit, rad.
        reach: of the arm.
    """
    (x, y), turned = reach.tip(at), sum(task.over_place) - sum(at)
    right, ahead = fruit.x - x, fruit.y - y
    c, s = cos(turned), sin(turned)
    tip = place.x - (c * right - s * ahead), place.y - (s * right + c * ahead)
    nearest = min(reach.postures(*tip), key=lambda found: dist(found.angles, task.over_place), default=None)
    return replace(task, over_place=nearest.angles) if nearest is not None else task


def rules_of(cell: Cell, reach: Reach) -> Rules:
    """Return the rules of picks in a cell; the cup's vacuums follow from its time constants."""
    cup = cell.cup
    closed, opened = _vacuum(cup, cup.leak), _vacuum(cup, cup.open_leak)
    return Rules(
        tip=reach.tip,
        clear=tuple(cell.mount.home[name] for name in cell.machine.joints),
        sound=opened + 0.6 * (closed - opened),
        gone=opened + 0.3 * (closed - opened),
        empty=0.02 * closed,
    )


def _vacuum(cup: Cup, leak: float) -> float:
    """Return the vacuum at which an ejector and a leak are even, Pa."""
    return cup.vacuum / (1.0 + cup.build_up / leak)
