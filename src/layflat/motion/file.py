"""The motion file as it is written: a posture to begin with, and segments, each from rest to rest."""

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, ValidationError, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.explain import explained
from layflat.description.library import Library
from layflat.description.part import Described
from layflat.description.places import Steps
from layflat.errors import InputError
from layflat.motion.limits import RESERVE, TipLimits
from layflat.physics.arms.kind import MOST

MOTIONS = Library(
    Path(__file__).parent / "builtin", "motion", "`layflat motions` lists them", 'speed = "0.5 m/s"', InputError
)

Point = Annotated[tuple[u.Coordinate, ...], Field(min_length=2, max_length=3)]
Posture = Annotated[tuple[u.Angle, ...], Field(min_length=1, max_length=MOST)]


class Timed(Part):
    """How a way is gone through: with limited jerk, or as quickly as hoses and valves can."""

    speed: u.LinearSpeed | None = Field(default=None, description="of the tip at most")
    acceleration: u.PositiveAcceleration | None = Field(default=None, description="of the tip at most")
    jerk: u.Jerk | None = Field(default=None, description="of the tip along its way at most")
    time_optimal: bool = False

    @model_validator(mode="after")
    def _no_jerk_in_least_time(self) -> Self:
        if self.time_optimal and self.jerk is not None:
            raise ValueError("has a jerk, and is time_optimal, which limits torques' rates instead; leave out one")
        return self

    @property
    def tip(self) -> TipLimits:
        """Limits of the tip's motion."""
        usual = TipLimits()
        given = (self.speed, self.acceleration, self.jerk)
        return TipLimits(*(limit if of is None else of for of, limit in zip(given, usual, strict=True)))


class LinePart(Timed):
    """The tip goes straight to a point."""

    kind: Literal["line"]
    to: Point


class ArcPart(Timed):
    """The tip goes on a circle, through a point, to another."""

    kind: Literal["arc"]
    through: Point
    to: Point


class ViaPart(Timed):
    """A smooth way through points of the tip, or through postures, the last of which it ends in."""

    kind: Literal["via"]
    points: Annotated[tuple[Point, ...], Field(min_length=1)] | None = None
    angles: Annotated[tuple[Posture, ...], Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _either(self) -> Self:
        if (self.points is None) == (self.angles is None):
            raise ValueError("needs points or angles; give one of them")
        return self


class JointPart(Timed):
    """The joints go straight to angles."""

    kind: Literal["joint"]
    to: Posture


class BeltPart(Part):
    """The tip follows a point on a belt."""

    kind: Literal["belt"]
    direction: u.Angle = Field(description="of the belt, from the x axis")
    speeds: Annotated[tuple[tuple[u.TimeOrZero, u.AnySpeed], ...], Field(min_length=1)] = Field(
        description="when the speed begins to change, from the segment's beginning on, and what to"
    )
    acceleration: u.PositiveAcceleration = Field(description="of the belt at most")


class WaitPart(Part):
    """The arm stays where it is."""

    kind: Literal["wait"]
    duration: u.Time


SegmentPart = Annotated[LinePart | ArcPart | ViaPart | JointPart | BeltPart | WaitPart, Field(discriminator="kind")]


class Motion(Described):
    """A motion that an arm is asked for; postures have one angle a joint, from base to tip."""

    start: Posture
    payload: u.Mass | None = Field(default=None, description="default: that of the machine")
    reserve: Annotated[float, Field(ge=0.0, le=0.9)] = RESERVE
    segment: Annotated[tuple[SegmentPart, ...], Field(min_length=1)]


def _place(steps: Steps, value: object) -> str:  # noqa: ARG001  (as of all who name places)
    """Return how a place in a file is called: its segments count from one."""
    named = [str(step + 1) if isinstance(step, int) else step for step in steps]
    if named[:1] != ["segment"] or len(named) == 1:
        return ".".join(named)
    return ": ".join([f"segment {named[1]}", *([".".join(named[2:])] if named[2:] else [])])


def read_motion(where: str | Path) -> Motion:
    """Return a motion from a built-in name or a TOML file; raise InputError, in one line, for what is wrong in it."""
    plain, sources = MOTIONS.tables(where)
    try:
        motion = Motion.model_validate(plain)
    except ValidationError as error:
        complete = "`layflat motions tour` shows a complete motion"
        raise explained(error, str(where), Motion, complete=complete, written=_place) from None
    motion._provenance.update(sources)
    motion._origin = str(where)
    return motion
