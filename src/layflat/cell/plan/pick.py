"""One pick: its phases, what it is to do, what is measured of it, what it commands, and how it may end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from math import radians

from layflat.cell.reach import Angles


class Phase(Enum):
    """What a pick is doing; the value goes behind "the arm" in a sentence."""

    APPROACH = "moves over the fruit and settles there"
    LOWER = "lowers the cup on the fruit"
    SEAL = "waits for the vacuum"
    LIFT = "lifts the fruit"
    CARRY = "carries the fruit over its place and settles there"
    PLACE = "lowers the fruit into its place"
    RELEASE = "releases the fruit"
    PUT_BACK = "puts back what it lifted"
    RELEASE_BACK = "releases the fruit where it was"
    RAISE = "raises the empty cup"
    CLEAR = "moves out of the camera's view"
    AWAIT_IMAGE = "waits for a new image"
    DONE = "has ended"


class Outcome(Enum):
    """How a pick ended."""

    PLACED = "the fruit lies in its place"
    MISSED = "the fruit was not picked in all tries"
    GONE = "a new image shows no fruit there"
    LOST = "the fruit was lost on its way"
    STUCK = "something did not happen in its time: the arm stays where it is, the lift goes up"


@dataclass(frozen=True)
class Task:
    """One fruit and its place; heights are those of the cup's lip over the table, m.

    Args:
        over_fruit: posture, rad.
        over_place: likewise.
        fruit_height: at which the cup sits on the fruit, as far as is known from above.
        lowest: at which it sits on the flattest fruit of that size, and a bit.
        place_height: at which the fruit is released.
        passing: over everything, the cup being empty.
        carrying: over everything, with the fruit.
    """

    over_fruit: Angles
    over_place: Angles
    fruit_height: float
    lowest: float
    place_height: float
    passing: float
    carrying: float

    def seated(self, height: float) -> Task:
        """Return the same once the cup sits on the fruit at a height, which shows how high the fruit is."""
        higher = height - self.fruit_height
        return replace(self, fruit_height=height, place_height=self.place_height + higher)


@dataclass(frozen=True)
class Rules:
    """When something has happened, and how long it may take.

    Args:
        tip: where the arm's tip is, m, from its angles.
        clear: posture out of the camera's view, rad.
        near: of the tip to its target, within which the lift may begin to lower, m.
        still: speed of every joint below which it may, rad/s.
        dwell: how long both have to hold, s.
        off: of the tip from its target, beyond which a lowered lift is raised at once, m.
        shaken: speed of any joint beyond which it is, rad/s.
        sound: vacuum with which one fruit is held, Pa below the surroundings.
        gone: vacuum below which nothing hangs on the cup though suction is on, Pa: an open cup has some.
        empty: vacuum below which nothing does once suction is off, Pa.
        tries: of one fruit, each after a new image.
        settle_time: longest time of a move until it is settled, s.
        height: within which the lift is where it was asked to be, m.
        halted: speed of the lift below which something is in its way, m/s, once it has had the time `starts` (s).
        starts: see `halted`.
        lower_time: longest time of the lift's way down, s.
        seal_time: longest time until the vacuum is sound, s.
        heavy_time: of the lift's way up, beyond which too much hangs on the cup, s.
        raise_time: longest time of its way up, s.
        release_time: longest time until the vacuum is gone, s.
        image_time: longest time until an image comes, s.
    """

    tip: Callable[[Angles], tuple[float, float]]
    clear: Angles
    near: float = 2e-3
    still: float = radians(6.0)
    dwell: float = 0.02
    off: float = 4e-3
    shaken: float = radians(20.0)
    sound: float = 30e3
    gone: float = 10e3
    empty: float = 1e3
    tries: int = 3
    settle_time: float = 3.0
    height: float = 2e-3
    halted: float = 5e-3
    starts: float = 0.06
    lower_time: float = 1.0
    seal_time: float = 0.4
    heavy_time: float = 0.6
    raise_time: float = 1.5
    release_time: float = 0.5
    image_time: float = 2.0

    @property
    def longest(self) -> float:
        """No pick takes longer, s."""
        down = self.lower_time + self.seal_time + self.heavy_time + self.lower_time + self.release_time
        one = self.settle_time + down + self.raise_time + self.settle_time + self.image_time
        carried = self.settle_time + self.lower_time + self.raise_time
        return self.tries * (one + carried) + self.release_time + self.raise_time


@dataclass(frozen=True)
class Relocation:
    """What a new image showed of a fruit that was missed: the task where it lies now; None if it is gone."""

    task: Task | None


@dataclass(frozen=True)
class Readings:
    """What sensors give in one cycle.

    Args:
        time: s.
        angles: rad, by joint.
        velocities: rad/s, by joint.
        vacuum: in the cup's line, Pa below the surroundings.
        height: of the cup's lip over the table, m, by the lift's stroke.
        lift_speed: upwards, m/s.
        relocation: the answer to an image that was asked for.
    """

    time: float
    angles: Angles
    velocities: Angles
    vacuum: float
    height: float
    lift_speed: float = 0.0
    relocation: Relocation | None = None


@dataclass(frozen=True)
class Command:
    """What a pick commands: a posture (rad), a height of the cup's lip (m), suction, and whether to take an image."""

    target: Angles
    height: float
    suction: bool
    image: bool


@dataclass(frozen=True)
class State:
    """State of a pick; begin with `begun`.

    Args:
        task: as it is known by now.
        phase: what it does.
        since: when the phase began, s.
        target: posture asked for, rad.
        suction: whether it is on.
        near_since: since when the tip has been near and still, s; None while it is not.
        tried: how often the cup went down for the fruit.
        shaken: how often the arm moved while the cup was down.
        outcome: how it ended, or will, once the cup is raised.
        trouble: what went wrong last, as one clause.
    """

    task: Task
    phase: Phase
    since: float
    target: Angles
    suction: bool = False
    near_since: float | None = None
    tried: int = 0
    shaken: int = 0
    outcome: Outcome | None = None
    trouble: str = ""

    @property
    def passing(self) -> float:
        """Height of the cup's lip from which on the arm may move: more while something may hang on it, m."""
        return self.task.carrying if self.suction else self.task.passing

    @property
    def over(self) -> Angles:
        """The posture that this phase belongs to, rad: over the place with the fruit, else over the fruit."""
        carried = self.phase in {Phase.CARRY, Phase.PLACE, Phase.RELEASE}
        return self.task.over_place if carried else self.task.over_fruit
