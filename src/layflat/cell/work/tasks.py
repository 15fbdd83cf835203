"""From a choice to a task: heights of the lift that follow from the cell's description and the fruit's diameter."""

from dataclasses import replace
from math import cos, dist, sin

from layflat.cell.file.model import Cell
from layflat.cell.plan.containers import Fruit, Place
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import Rules, Task
from layflat.motion.reach import Angles, Reach

GAP = 10e-3  # between what passes and what it passes over, m
PRESSED = 3e-3  # by how much the cup is led lower than a fruit's top is thought to be, m; the lift gives way
SEALING = 0.25  # for settling, and until the vacuum is sound, s
DROP = 2e-3  # over the floor of its place, at which a fruit is released, m


def passing_height(cell: Cell) -> float:
    """Return the height of the cup's lip at which an empty cup passes over everything, m."""
    return min(cell.obstacle_height + GAP, cell.lift.clearance)


def task_of(cell: Cell, choice: Choice) -> Task:
    """Return what has to be done for a choice."""
    flattening, passing = cell.produce[choice.fruit.kind].flattening, passing_height(cell)
    tall = flattening.mean * choice.fruit.diameter
    least, most = flattening.least * choice.fruit.diameter, flattening.most * choice.fruit.diameter
    floor = cell.floor_at(choice.fruit.x, choice.fruit.y)
    return Task(
        choice.over_fruit.angles,
        choice.over_place.angles,
        fruit_height=floor + tall - PRESSED,
        lowest=floor + least - PRESSED,
        place_height=choice.place.z + tall - PRESSED + DROP,
        passing=passing,
        carrying=min(passing + most, cell.lift.clearance),
    )


def handling_time(cell: Cell, fruit: Fruit) -> float:
    """Return how long the arm has to stay over a fruit: from when it is there until the fruit hangs on the cup, s."""
    lift, top = cell.lift, cell.floor_at(fruit.x, fruit.y) + cell.produce[fruit.kind].flattening.mean * fruit.diameter
    return (passing_height(cell) - top) / lift.speed + lift.speed / lift.acceleration + SEALING


def centred(task: Task, fruit: Fruit, place: Place, at: Angles, reach: Reach) -> Task:
    """Return the task with the fruit's middle, not the cup's, over the middle of its place.

    The cup sits on the fruit, with the arm at angles `at` (rad), beside the fruit's middle by what the arm is off; that
    turns with the last link.
    """
    (x, y), turned = reach.tip(at), sum(task.over_place) - sum(at)
    right, ahead = fruit.x - x, fruit.y - y
    c, s = cos(turned), sin(turned)
    tip = place.x - (c * right - s * ahead), place.y - (s * right + c * ahead)
    nearest = min(reach.postures(*tip), key=lambda found: dist(found.angles, task.over_place), default=None)
    return replace(task, over_place=nearest.angles) if nearest is not None else task


def rules_of(cell: Cell, reach: Reach) -> Rules:
    """Return the rules of picks in a cell; the cup's vacuums follow from its time constants."""
    # At which the ejector and the leak are even, Pa: of a cup on a fruit, and of an open one.
    cup = cell.cup
    closed, opened = (cup.vacuum / (1.0 + cup.build_up / leak) for leak in (cup.leak, cup.open_leak))
    return Rules(
        tip=reach.tip,
        clear=tuple(cell.mount.home[name] for name in cell.machine.joints),
        sound=opened + 0.6 * (closed - opened),
        gone=opened + 0.3 * (closed - opened),
        empty=0.02 * closed,
    )
