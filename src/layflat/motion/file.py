"""Data model of motion files: a start configuration, and segments, each from rest to rest."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from layflat.description import DescribedFile, Part
from layflat.description import units as u
from layflat.description.explain import explain_error
from layflat.description.library import Library
from layflat.description.places import Steps
from layflat.description.quantity import SI
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.limits import FEEDBACK_RESERVE, TipLimits
from layflat.motion.signal_values import Angles, SignalKind, Value, read_number, read_row
from layflat.physics.arms.kind import MAX_JOINTS

MOTION_LIBRARY = Library(
    Path(__file__).parent / "builtin", "motion", "`layflat motion list` lists them", 'speed = "0.5 m/s"', InputError
)

Point = Annotated[tuple[u.Coordinate, ...], Field(min_length=2, max_length=3)]
JointAngles = Annotated[tuple[u.Angle, ...], Field(min_length=1, max_length=MAX_JOINTS)]


class TimedPart(Part):
    """Timing along a path: with limited jerk, or time-optimal within the capabilities of hoses and valves."""

    speed: u.LinearSpeed | None = Field(default=None, description="greatest of the tip")
    acceleration: u.PositiveAcceleration | None = Field(default=None, description="greatest of the tip")
    jerk: u.Jerk | None = Field(default=None, description="greatest of the tip along its path")
    time_optimal: bool = False

    @model_validator(mode="after")
    def _check_jerk(self) -> Self:
        """Raise ValueError if a time-optimal segment has a limit of jerk."""
        if self.time_optimal and self.jerk is not None:
            raise ValueError("has a jerk, and is time_optimal, which limits torques' rates instead; leave out one")
        return self

    @property
    def tip(self) -> TipLimits:
        """Limits of the tip's motion; infinite where the segment has none."""
        limits = (self.speed, self.acceleration, self.jerk)
        return TipLimits(
            *(default if limit is None else limit for limit, default in zip(limits, TipLimits(), strict=True))
        )


class LinePart(TimedPart):
    """Straight line of the tip to a point."""

    kind: Literal["line"]
    to: Point


class ArcPart(TimedPart):
    """Circular arc of the tip through a point to another."""

    kind: Literal["arc"]
    through: Point
    to: Point


class ViaPart(TimedPart):
    """Spline through points of the tip, or through configurations; it ends in the last."""

    kind: Literal["via"]
    points: Annotated[tuple[Point, ...], Field(min_length=1)] | None = None
    angles: Annotated[tuple[JointAngles, ...], Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _check_points_or_angles(self) -> Self:
        """Raise ValueError unless points or angles are given, and not both."""
        if (self.points is None) == (self.angles is None):
            raise ValueError("needs points or angles; give one of them")
        return self


class JointPart(TimedPart):
    """Straight line in joint space to angles."""

    kind: Literal["joint"]
    to: JointAngles


class BeltPart(Part):
    """Motion in which the tip follows a point on a belt."""

    kind: Literal["belt"]
    direction: u.Angle = Field(description="of the belt, from the x axis")
    speeds: Annotated[tuple[tuple[u.TimeOrZero, u.AnySpeed], ...], Field(min_length=1)] = Field(
        description="when the speed begins to change, from the segment's beginning on, and what to"
    )
    acceleration: u.PositiveAcceleration = Field(description="greatest of the belt")


class WaitPart(Part):
    """Pause at constant angles."""

    kind: Literal["wait"]
    duration: u.Time


SegmentPart = Annotated[LinePart | ArcPart | ViaPart | JointPart | BeltPart | WaitPart, Field(discriminator="kind")]


class MotionDescription(DescribedFile):
    """Motion of an arm; configurations have one angle per joint, from base to tip."""

    start: JointAngles
    payload: u.Mass | None = Field(default=None, description="default: that of the machine")
    reserve: Annotated[float, Field(ge=0.0, le=0.9)] = FEEDBACK_RESERVE
    segment: Annotated[tuple[SegmentPart, ...], Field(min_length=1)]


def _place_name(steps: Steps, value: object) -> str:  # noqa: ARG001  (signature of `explained`)
    """Return the name of a location in a file for messages: its segments count from one."""
    parts = [str(step + 1) if isinstance(step, int) else step for step in steps]
    if parts[:1] != ["segment"] or len(parts) == 1:
        return ".".join(parts)
    return ": ".join([f"segment {parts[1]}", *([".".join(parts[2:])] if parts[2:] else [])])


def read_motion(where: str | Path) -> MotionDescription:
    """Return a motion by its built-in name or from a TOML file; raise InputError with one line for a wrong file."""
    plain, sources = MOTION_LIBRARY.tables(where)
    motion = _build_motion(plain, str(where))
    motion._provenance.update(sources)
    return motion


def _build_motion(plain: Mapping[str, Any], where: str, context: Mapping[str, bool] | None = None) -> MotionDescription:
    """Return the motion of plain tables from `where`; raise InputError if they are invalid.

    In the context `SI`, plain numbers are accepted, in SI units.
    """
    try:
        motion = MotionDescription.model_validate(plain, context=context)
    except ValidationError as error:
        complete = "`layflat motion show tour` shows a complete motion"
        raise explain_error(error, where, MotionDescription, complete=complete, written=_place_name) from None
    motion._origin = where
    return motion


def make_motion(
    machine: Machine,
    motion: str | Path | MotionDescription | Sequence[Mapping[str, Any]],
    start: Angles | None = None,
    payload: Value | None = None,
) -> MotionDescription:
    """Return a motion of a machine's arm.

    Args:
        machine: machine with the arm.
        motion: a built-in name, a file, a description, or segments with the keys of a file's.
        start: angles at which segments in a list begin, rad or texts; default: mid-stroke. Other motions have their
            own, and refuse it.
        payload: kg or a text; default: that of the motion.

    Raises:
        InputError: the motion or an argument is wrong.
    """
    if isinstance(motion, (str, Path, MotionDescription)):
        if start is not None:
            right = "leave it out: the motion has its own"
            raise InputError("is only for segments given as a list", where="start", right=right)
        described = motion if isinstance(motion, MotionDescription) else read_motion(motion)
    else:
        kind = SignalKind("start", u.ANGLE, list(machine.joints))
        rest = np.zeros(len(machine.joints))
        angles = rest if start is None else read_row(start, kind, rest)
        plain = {"name": "motion", "title": "", "start": angles.tolist(), "segment": motion}
        described = _build_motion(plain, "motion", SI)
    given = None if payload is None else read_number(payload, u.MASS, "payload")
    return described if given is None else described.model_copy(update={"payload": given})
