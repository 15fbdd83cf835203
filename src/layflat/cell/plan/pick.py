"""Data of a pick: phases, task, rules, sensor readings, commands, state and outcomes."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from math import radians
from typing import NamedTuple, Self

from layflat.motion.planar import Angles


class PickPhase(Enum):
    """Phase of a pick; its value completes a sentence that begins with "the arm"."""

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


class PickOutcome(Enum):
    """Outcome of a pick; its value says it in words."""

    PLACED = "the fruit lies in its place"
    MISSED = "the fruit was not picked in all tries"
    GONE = "a new image shows no fruit there"
    LOST = "the fruit was lost on its way"
    STUCK = "something did not happen in its time: the arm stays where it is, the lift goes up"


@dataclass(frozen=True)
class PickTask:
    """Task of a pick: one fruit and its place; heights are those of the cup's lip over the table, m."""

    over_fruit: Angles  # joint angles over the fruit, rad
    over_place: Angles  # joint angles over the place, rad
    fruit_height: float  # at which the cup sits on the fruit, estimated from its diameter
    lowest: float  # lower limit of that height: on the flattest fruit of that diameter
    place_height: float  # at which the fruit is released
    passing: float  # at which an empty cup clears everything
    carrying: float  # at which a cup with the fruit clears everything

    def seated(self, height: float) -> Self:
        """Return the task with the measured height (m) of the cup on the fruit; `place_height` changes by as much."""
        higher = height - self.fruit_height
        return replace(self, fruit_height=height, place_height=self.place_height + higher)


@dataclass(frozen=True)
class PickRules:
    """Thresholds and time limits of a pick's events; vacuums are in Pa below ambient pressure."""

    tip: Callable[[Angles], tuple[float, float]]  # position of the arm's tip, m, by joint angles
    clear: Angles  # joint angles out of the camera's view, rad
    near_distance: float = 2e-3  # distance of the tip to its target within which the lift may begin to lower, m
    still: float = radians(6.0)  # speed of every joint up to which the lift may begin to lower, rad/s
    dwell: float = 0.02  # how long both have to hold, s
    off: float = 4e-3  # distance of the tip to its target beyond which a lowered lift is raised at once, m
    shaken: float = radians(20.0)  # speed of any joint beyond which a lowered lift is raised at once, rad/s
    sound: float = 30e3  # vacuum from which a fruit is held
    lost_vacuum: float = 10e3  # vacuum below which the cup holds nothing with suction on: an open cup has some
    empty: float = 1e3  # vacuum below which the cup holds nothing with suction off
    tries: int = 3  # of one fruit, each after a new image
    settle_time: float = 3.0  # upper limit from the start of a move until the arm has settled, s
    height: float = 2e-3  # tolerance of the lift's height, m
    halted: float = 5e-3  # speed of the lift up to which it is stopped by contact, m/s,
    starts: float = 0.06  # after this time since its start, s
    lower_time: float = 1.0  # upper limit of lowering, s
    seal_time: float = 0.4  # upper limit until the vacuum holds a fruit, s
    heavy_time: float = 0.6  # upper limit of lifting, beyond which the load is too heavy, s
    raise_time: float = 1.5  # upper limit of raising the empty cup, s
    release_time: float = 0.5  # upper limit until the vacuum has decayed, s
    image_time: float = 2.0  # upper limit until an image arrives, s


class Relocation(NamedTuple):
    """Result of a new image after a miss: the task with the fruit's present position; None if it is not detected."""

    task: PickTask | None


class MovingFruit(NamedTuple):
    """Estimate of a moving fruit in one cycle."""

    over: Angles  # joint angles over it, or at which the arm waits if it can't be followed, rad
    velocities: Angles  # of the joints over it, rad/s
    trouble: str = ""  # reason why it can't be followed any longer, as one clause


@dataclass(frozen=True)
class CellReadings:
    """Sensor readings of one cycle."""

    time: float  # s
    angles: Angles  # rad, by joint
    velocities: Angles  # rad/s, by joint
    vacuum: float  # in the cup's line, Pa below ambient pressure
    height: float  # of the cup's lip over the table, m, by the lift's stroke
    lift_speed: float = 0.0  # upwards, m/s
    relocation: Relocation | None = None  # result of a commanded image
    moving: MovingFruit | None = None  # the fruit, where it moves


class PickCommand(NamedTuple):
    """Command of a pick to arm, lift and ejector until the next cycle."""

    target: Angles  # joint angles, rad
    height: float  # of the cup's lip, m
    suction: bool
    image: bool  # whether to take an image
    follow: bool = False  # whether the target moves on, with the fruit


@dataclass(frozen=True)
class PickState:
    """State of a pick; `pick_machine.begin_pick` returns the first."""

    task: PickTask  # as it is known by now
    phase: PickPhase
    since: float  # start of the phase, s
    target: Angles  # commanded joint angles, rad
    suction: bool = False  # whether it is on
    near_since: float | None = None  # time since which the tip has been near its target and stationary, s; None: not
    tried: int = 0  # number of attempts to lower the cup on the fruit
    shaken: int = 0  # number of disturbances of the arm with the cup down
    outcome: PickOutcome | None = None  # known before the end, while the cup is raised
    trouble: str = ""  # last failure, as one clause

    @property
    def passing(self) -> float:
        """Least height of the cup's lip at which the arm may move, m: more while the cup may hold fruit."""
        return self.task.carrying if self.suction else self.task.passing

    @property
    def phase_angles(self) -> Angles:
        """Joint angles at which this phase takes place, rad: over the place with the fruit, else over the fruit."""
        carried = self.phase in {PickPhase.CARRY, PickPhase.PLACE, PickPhase.RELEASE}
        return self.task.over_place if carried else self.task.over_fruit
