"""One pick: its phases, what it is to do, what is measured of it, what it commands, and how it may end."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from math import radians
from typing import NamedTuple, Self

from layflat.motion.reach import Angles


class Phase(Enum):
    """What a pick is doing; the value goes behind "the arm" in a sentence."""

    APPROACH = "moves over the fruit and settles there"
    FOLLOW = "meets the moving fruit and follows it"
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
    """One fruit and its place; heights are those of the cup's lip over the table, m."""

    over_fruit: Angles  # posture, rad
    over_place: Angles  # likewise
    fruit_height: float  # at which the cup sits on the fruit, as far as is known from above
    lowest: float  # at which it sits on the flattest fruit of that size, and a bit
    place_height: float  # at which the fruit is released
    passing: float  # over everything, the cup being empty
    carrying: float  # over everything, with the fruit

    def seated(self, height: float) -> Self:
        """Return the same once the cup sits on the fruit at a height, which shows how high the fruit is."""
        higher = height - self.fruit_height
        return replace(self, fruit_height=height, place_height=self.place_height + higher)


@dataclass(frozen=True)
class Rules:
    """When something has happened, and how long it may take; vacuums are in Pa below the surroundings."""

    tip: Callable[[Angles], tuple[float, float]]  # where the arm's tip is, m, from its angles
    clear: Angles  # posture out of the camera's view, rad
    near: float = 2e-3  # of the tip to its target, within which the lift may begin to lower, m
    still: float = radians(6.0)  # speed of every joint below which it may, rad/s
    dwell: float = 0.02  # how long both have to hold, s
    off: float = 4e-3  # of the tip from its target, beyond which a lowered lift is raised at once, m
    shaken: float = radians(20.0)  # speed of any joint beyond which it is, rad/s
    sound: float = 30e3  # vacuum with which one fruit is held
    gone: float = 10e3  # vacuum below which nothing hangs on the cup though suction is on: an open cup has some
    empty: float = 1e3  # vacuum below which nothing does once suction is off
    tries: int = 3  # of one fruit, each after a new image
    settle_time: float = 3.0  # longest time of a move until it is settled, s
    height: float = 2e-3  # within which the lift is where it was asked to be, m
    halted: float = 5e-3  # speed of the lift below which something is in its way, m/s,
    starts: float = 0.06  # once it has had this time, s
    lower_time: float = 1.0  # longest time of the lift's way down, s
    seal_time: float = 0.4  # longest time until the vacuum is sound, s
    heavy_time: float = 0.6  # of the lift's way up, beyond which too much hangs on the cup, s
    raise_time: float = 1.5  # longest time of its way up, s
    release_time: float = 0.5  # longest time until the vacuum is gone, s
    image_time: float = 2.0  # longest time until an image comes, s


class Relocation(NamedTuple):
    """What a new image showed of a fruit that was missed: the task where it lies now; None if it is gone."""

    task: Task | None


class Moving(NamedTuple):
    """A fruit that moves, as it is known in one cycle."""

    over: Angles  # posture over it, or where the arm waits if it can't be followed, rad
    velocities: Angles  # of the joints over it, rad/s
    trouble: str = ""  # why it can't be followed any longer, as one clause


@dataclass(frozen=True)
class Readings:
    """What sensors give in one cycle."""

    time: float  # s
    angles: Angles  # rad, by joint
    velocities: Angles  # rad/s, by joint
    vacuum: float  # in the cup's line, Pa below the surroundings
    height: float  # of the cup's lip over the table, m, by the lift's stroke
    lift_speed: float = 0.0  # upwards, m/s
    relocation: Relocation | None = None  # the answer to an image that was asked for
    moving: Moving | None = None  # the fruit, where it moves


class Command(NamedTuple):
    """What a pick commands until the next cycle."""

    target: Angles  # posture, rad
    height: float  # of the cup's lip, m
    suction: bool
    image: bool  # whether to take one
    follow: bool = False  # whether the target moves on, with the fruit


@dataclass(frozen=True)
class State:
    """State of a pick; begin with `begun`."""

    task: Task  # as it is known by now
    phase: Phase
    since: float  # when the phase began, s
    target: Angles  # posture asked for, rad
    suction: bool = False  # whether it is on
    near_since: float | None = None  # since when the tip has been near and still, s; None while it is not
    tried: int = 0  # how often the cup went down for the fruit
    shaken: int = 0  # how often the arm moved while the cup was down
    outcome: Outcome | None = None  # how it ended, or will, once the cup is raised
    trouble: str = ""  # what went wrong last, as one clause

    @property
    def passing(self) -> float:
        """Height of the cup's lip from which on the arm may move: more while something may hang on it, m."""
        return self.task.carrying if self.suction else self.task.passing

    @property
    def over(self) -> Angles:
        """The posture that this phase belongs to, rad: over the place with the fruit, else over the fruit."""
        carried = self.phase in {Phase.CARRY, Phase.PLACE, Phase.RELEASE}
        return self.task.over_place if carried else self.task.over_fruit
