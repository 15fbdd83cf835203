"""Tasks of arms: payload, reach or joints, and moves, from files or from Python."""

from collections.abc import Iterator, Mapping, Sequence
from math import degrees, radians
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self, TypedDict, Unpack

from pydantic import AfterValidator, Field, ValidationError, model_validator

from layflat.description import DescribedFile, Part
from layflat.description import units as u
from layflat.description.explain import explain_error
from layflat.description.library import Library
from layflat.description.names import Key
from layflat.description.wrong import INPUT_VALUE, value_error
from layflat.design.request import FIELD_RANGES
from layflat.errors import DesignError
from layflat.physics.arms.chain.description import MIN_DIRECTION_LENGTH, NumberTriple, PositionVector
from layflat.physics.arms.kind import MAX_JOINTS

TASK_LIBRARY = Library(
    Path(__file__).parent / "builtin", "arm task", "see `layflat task list`", 'reach = "0.9 m"', DesignError
)
ALTERNATIVE_KEYS = ({"time", "acceleration"}, {"configurations", "points", "volume", "rotation"})
"""Keys that exclude each other: a value of one of them replaces all of them in a file."""
TASK_ADVICE = "docs/sizing-arms.md shows a complete task"

FALL_ACCELERATION = 9.81  # m/s2
LEAST_SUPPLY, MOST_SUPPLY = FIELD_RANGES["supply"][1:]  # gauge, Pa


def _check_supply(supply: float) -> float:
    """Return a supply pressure (gauge, Pa) that suits such joints; refuse any other."""
    if not LEAST_SUPPLY <= supply <= MOST_SUPPLY:
        right = f"give {LEAST_SUPPLY / 1e5:g} bar to {MOST_SUPPLY / 1e5:g} bar"
        raise value_error("is no pressure of such joints", right, INPUT_VALUE)
    return supply


Posture = Annotated[tuple[u.Angle, ...], Field(min_length=1, max_length=MAX_JOINTS)]


class JointTask(Part):
    """Joint of a task, with the link that it rotates."""

    name: Key
    axis: NumberTriple = Field(description="about which it rotates its link, in the link's frame")
    middle: u.Angle = Field(default=0.0, description="rotation of the link about it in mid-stroke")
    stroke: u.PositiveAngle = Field(default=radians(120.0), description="working stroke")
    link: PositionVector = Field(
        description="from this joint to the next one, or to the payload, in its frame; may be nothing"
    )

    @model_validator(mode="after")
    def _check_axis(self) -> Self:
        """Raise ValueError if the axis has no direction."""
        if sum(component * component for component in self.axis) < MIN_DIRECTION_LENGTH:
            raise ValueError("axis has no direction; a joint that turns about z has [0, 0, 1]")
        return self


class Volume(Part):
    """Box in the frame of the base, between whose points the tip is to move."""

    low: PositionVector
    high: PositionVector

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        """Raise ValueError if a lower corner is above the upper one."""
        if any(low > high for low, high in zip(self.low, self.high, strict=True)):
            raise ValueError("low must not be above high, in any of x, y and z")
        return self


class _Standard(NamedTuple):
    # Joint of an arm that is defined by its reach alone.
    name: str
    upright: bool
    middle: float  # deg
    length_ratio: float  # of the reach that its link has; a column's is its height


VERTICAL_AXIS, SIDE_AXIS = (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)  # about the side axis positive angles lift
COLUMN_RATIO = 0.2  # height of a column over the reach

STANDARD_CHAINS = {
    1: (_Standard("lift", False, 0.0, 1.0),),
    2: (_Standard("shoulder", False, 45.0, 0.5), _Standard("elbow", False, -75.0, 0.5)),
    3: (
        _Standard("base", True, 0.0, COLUMN_RATIO),
        _Standard("shoulder", False, 45.0, 0.5),
        _Standard("elbow", False, -75.0, 0.5),
    ),
    4: (
        _Standard("base", True, 0.0, COLUMN_RATIO),
        _Standard("shoulder", False, 45.0, 0.42),
        _Standard("elbow", False, -75.0, 0.38),
        _Standard("wrist", False, 0.0, 0.2),
    ),
}


class ArmTask(DescribedFile):
    """Task of an arm. Its base is upright, with z up; angles are from mid-stroke."""

    payload: u.Mass = Field(description="the greatest, at the end of the last link")
    supply: Annotated[u.PositivePressure, AfterValidator(_check_supply)] = Field(description="gauge pressure")
    reach: u.Length | None = Field(default=None, description="of a standard arm, from its shoulder to the payload")
    joints: Annotated[int, Field(ge=min(STANDARD_CHAINS), le=max(STANDARD_CHAINS))] | None = Field(
        default=None, description="of a standard arm: lift; shoulder, elbow; with a rotating base; with a wrist"
    )
    joint: Annotated[tuple[JointTask, ...], Field(max_length=MAX_JOINTS)] = Field(
        default=(), description="of any other arm, from base to tip"
    )
    time: u.Time | None = Field(default=None, description="that a move takes, from rest to rest")
    acceleration: u.PositiveAcceleration | None = Field(default=None, description="of the tip, instead of a time")
    rotation: u.PositiveAngle = Field(
        default=radians(60.0),
        description="of the joint that rotates furthest in a move, without configurations, points and volume",
    )
    configurations: tuple[Posture, ...] = Field(default=(), description="that a move passes, one after another")
    points: tuple[PositionVector, ...] = Field(default=(), description="that the tip passes, one after another")
    volume: Volume | None = None
    margin: Annotated[float, Field(ge=1.0, le=5.0)] = Field(
        default=1.3, description="of torques, their rates and speeds over those of the moves"
    )

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        """Raise ValueError if the keys of the task contradict each other."""
        if bool(self.joint) == (self.reach is not None):
            raise ValueError("needs reach, of a standard arm, or [[joint]] tables; give one of them")
        if self.joints is not None and self.joint:
            raise ValueError("joints counts those of a standard arm, but [[joint]] tables are given; leave it out")
        if (self.time is None) == (self.acceleration is None):
            raise ValueError("needs time, that a move takes, or acceleration, of the tip; give one of them")
        if sum(map(bool, (self.configurations, self.points, self.volume))) > 1:
            raise ValueError("configurations, points and volume are ways to say which moves; give one of them")
        widest = max(joint.stroke for joint in self.chain)
        if "rotation" in self.model_fields_set and self.rotation > widest * (1.0 + 1e-9):
            what = (
                f"rotation is {degrees(self.rotation):.4g} deg, and no joint turns more than {degrees(widest):.4g} deg"
            )
            raise ValueError(f"{what}; give less, or wider strokes")
        named = [joint.name for joint in self.chain]
        twice = [name for place, name in enumerate(named) if name in named[:place]]
        if twice:
            raise ValueError(f"two joints are called {twice[0]!r}; give each a name of its own")
        for number, posture in enumerate(self.configurations, 1):
            _check_configuration(number, posture, self.chain)
        for what, items in (("configurations", self.configurations), ("points", self.points)):
            if len(items) == 1:
                raise ValueError(f"{what} has a single one, which is no move; give at least two")
        return self

    @property
    def chain(self) -> tuple[JointTask, ...]:
        """Joints and their links, from base to tip."""
        return self.joint or tuple(_standard_chain(self.joints or max(STANDARD_CHAINS), self.reach or 0.0))


def _check_configuration(number: int, posture: tuple[float, ...], chain: tuple[JointTask, ...]) -> None:
    """Raise ValueError unless a configuration has an angle (rad) a joint, each within its stroke."""
    if len(posture) != len(chain):
        raise ValueError(f"configuration {number} has {len(posture)} angles; give one a joint, {len(chain)}")
    for joint, angle in zip(chain, posture, strict=True):
        half = 0.5 * joint.stroke
        if abs(angle) > half * (1.0 + 1e-9):
            what = f"configuration {number} turns joint {joint.name!r} to {degrees(angle):.4g} deg"
            raise ValueError(f"{what}; its stroke is {degrees(half):.4g} deg either way, from the middle")


def _standard_chain(count: int, reach: float) -> Iterator[JointTask]:
    """Yield the joints of a standard arm with this number of joints and a reach, m."""
    for name, upright, middle, share in STANDARD_CHAINS[count]:
        along = f"{share * reach!r} m"
        link = ("0 m", "0 m", along) if upright else (along, "0 m", "0 m")
        axis = VERTICAL_AXIS if upright else SIDE_AXIS
        yield JointTask.model_validate({"name": name, "axis": axis, "middle": f"{middle!r} deg", "link": link})


class TaskFields(TypedDict, total=False):
    """Values of an `ArmTask` as keyword arguments: texts with units, as in a file."""

    name: str | None
    title: str
    payload: str | None
    supply: str | None
    reach: str | None
    joints: int | None
    joint: Sequence[Mapping[str, Any]]
    time: str | None
    acceleration: str | None
    rotation: str | None
    configurations: Sequence[Sequence[str]] | None
    points: Sequence[Sequence[str]] | None
    volume: Mapping[str, Sequence[str]] | None
    margin: float | None


def read_task(where: str | Path | None = None, **given: Unpack[TaskFields]) -> ArmTask:
    """Return a task from a built-in name or a TOML file, with some values replaced.

    Args:
        where: built-in name or file; None for a task of the given values alone.
        **given: texts with units by key, such as reach="0.9 m"; None keeps the value of the file, or its default.

    Raises:
        DesignError: the task is not valid.
    """
    values = {key: value for key, value in given.items() if value is not None}
    plain, sources = TASK_LIBRARY.tables(where) if where is not None else ({"name": "sized-arm", "title": ""}, {})
    for keys in ALTERNATIVE_KEYS:
        if keys & values.keys():
            plain = {key: value for key, value in plain.items() if key not in keys}
    place = "task" if where is None else str(where)
    try:
        task = ArmTask.model_validate(plain | values)
    except ValidationError as error:
        raise explain_error(error, place, ArmTask, DesignError, TASK_ADVICE) from None
    task._provenance.update(sources)
    task._origin = place
    return task
