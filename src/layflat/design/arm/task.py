"""What an arm is asked to do, as a file says it or as options do."""

from collections.abc import Iterator
from math import degrees, radians
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self

from pydantic import AfterValidator, Field, ValidationError, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.explain import explained
from layflat.description.library import Library
from layflat.description.names import Key
from layflat.description.part import Described
from layflat.description.places import Steps
from layflat.description.wrong import INPUT, wrong
from layflat.design.request import RANGES
from layflat.errors import DesignError
from layflat.physics.arms.chain.description import NO_WAY, Place, Way
from layflat.physics.arms.kind import MOST

TASKS = Library(
    Path(__file__).parent / "builtin", "arm task", "see `layflat arm-tasks`", 'reach = "0.9 m"', DesignError
)
INSTEAD = ({"time", "acceleration"}, {"poses", "points", "volume", "turn"})
"""Ways to say one thing: who gives one of them leaves out what a file says of the others."""
WHOLE = "docs/sizing-arms.md shows a complete task"

FALL = 9.81  # m/s2
LEAST_SUPPLY, MOST_SUPPLY = RANGES["supply"][1:]  # gauge, Pa


def _in_range(supply: float) -> float:
    if not LEAST_SUPPLY <= supply <= MOST_SUPPLY:
        right = f"give {LEAST_SUPPLY / 1e5:g} bar to {MOST_SUPPLY / 1e5:g} bar"
        raise wrong("is no pressure of such joints", right, INPUT)
    return supply


Posture = Annotated[tuple[u.Angle, ...], Field(min_length=1, max_length=MOST)]


class JointTask(Part):
    """A joint, and the link that it turns."""

    name: Key
    axis: Way = Field(description="about which it turns its link, in the link's frame")
    middle: u.Angle = Field(default=0.0, description="by which the link is turned about it in mid-stroke")
    stroke: u.PositiveAngle = Field(default=radians(120.0), description="working stroke")
    link: Place = Field(description="from this joint to the next one, or to the payload, in its frame; may be nothing")

    @model_validator(mode="after")
    def _turns(self) -> Self:
        if sum(one * one for one in self.axis) < NO_WAY:
            raise ValueError("axis has no direction; a joint that turns about z has [0, 0, 1]")
        return self


class Volume(Part):
    """A box, in the frame of the base, between whose points the tip is to move."""

    low: Place
    high: Place

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if any(low > high for low, high in zip(self.low, self.high, strict=True)):
            raise ValueError("low must not be above high, in any of x, y and z")
        return self


class _Standard(NamedTuple):
    # A joint of an arm that is known by its reach alone.
    name: str
    upright: bool
    middle: float  # deg
    share: float  # of the reach that its link has; a column's is its height


UP, SIDE = (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)  # the latter: positive angles lift
COLUMN = 0.2  # height of a column over the reach

STANDARD = {
    1: (_Standard("lift", False, 0.0, 1.0),),
    2: (_Standard("shoulder", False, 45.0, 0.5), _Standard("elbow", False, -75.0, 0.5)),
    3: (
        _Standard("base", True, 0.0, COLUMN),
        _Standard("shoulder", False, 45.0, 0.5),
        _Standard("elbow", False, -75.0, 0.5),
    ),
    4: (
        _Standard("base", True, 0.0, COLUMN),
        _Standard("shoulder", False, 45.0, 0.42),
        _Standard("elbow", False, -75.0, 0.38),
        _Standard("wrist", False, 0.0, 0.2),
    ),
}


class ArmTask(Described):
    """What an arm is asked to do. Its base stands upright, with z up; angles are from mid-stroke."""

    payload: u.Mass = Field(description="the greatest, at the end of the last link")
    supply: Annotated[u.PositivePressure, AfterValidator(_in_range)] = Field(description="gauge pressure")
    reach: u.Length | None = Field(default=None, description="of a standard arm, from its shoulder to the payload")
    joints: Annotated[int, Field(ge=min(STANDARD), le=max(STANDARD))] | None = Field(
        default=None, description="of a standard arm: lift; shoulder, elbow; with a turning base; with a wrist"
    )
    joint: Annotated[tuple[JointTask, ...], Field(max_length=MOST)] = Field(
        default=(), description="of any other arm, from base to tip"
    )
    time: u.Time | None = Field(default=None, description="that a move takes, from rest to rest")
    acceleration: u.PositiveAcceleration | None = Field(default=None, description="in place of time: of the tip")
    turn: u.PositiveAngle = Field(
        default=radians(60.0), description="of the joint that turns most in a move where nothing else says which moves"
    )
    poses: tuple[Posture, ...] = Field(default=(), description="that are gone through, in turn")
    points: tuple[Place, ...] = Field(default=(), description="that the tip goes through, in turn")
    volume: Volume | None = None
    margin: Annotated[float, Field(ge=1.0, le=5.0)] = Field(
        default=1.3, description="of torques, their rates and speeds over those of the moves"
    )

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if bool(self.joint) == (self.reach is not None):
            raise ValueError("needs reach, of a standard arm, or [[joint]] tables; give one of them")
        if self.joints is not None and self.joint:
            raise ValueError("joints counts those of a standard arm, but [[joint]] tables are given; leave it out")
        if (self.time is None) == (self.acceleration is None):
            raise ValueError("needs time, that a move takes, or acceleration, of the tip; give one of them")
        if sum(map(bool, (self.poses, self.points, self.volume))) > 1:
            raise ValueError("poses, points and volume are ways to say which moves; give one of them")
        widest = max(joint.stroke for joint in self.chain)
        if "turn" in self.model_fields_set and self.turn > widest * (1.0 + 1e-9):
            what = f"turn is {degrees(self.turn):.4g} deg, and no joint turns by more than {degrees(widest):.4g} deg"
            raise ValueError(f"{what}; give less, or wider strokes")
        named = [joint.name for joint in self.chain]
        twice = [name for place, name in enumerate(named) if name in named[:place]]
        if twice:
            raise ValueError(f"two joints are called {twice[0]!r}; give each a name of its own")
        for number, posture in enumerate(self.poses, 1):
            _check_posture(number, posture, self.chain)
        for what, given in (("poses", self.poses), ("points", self.points)):
            if len(given) == 1:
                raise ValueError(f"{what} has a single one, which is no move; give at least two")
        return self

    @property
    def chain(self) -> tuple[JointTask, ...]:
        """Joints and their links, from base to tip."""
        return self.joint or tuple(_standard(self.joints or max(STANDARD), self.reach or 0.0))


def _check_posture(number: int, posture: tuple[float, ...], chain: tuple[JointTask, ...]) -> None:
    if len(posture) != len(chain):
        raise ValueError(f"pose {number} has {len(posture)} angles; give one a joint, {len(chain)}")
    for joint, angle in zip(chain, posture, strict=True):
        half = 0.5 * joint.stroke
        if abs(angle) > half * (1.0 + 1e-9):
            what = f"pose {number} turns joint {joint.name!r} to {degrees(angle):.4g} deg"
            raise ValueError(f"{what}; its stroke is {degrees(half):.4g} deg either way, from the middle")


def _standard(count: int, reach: float) -> Iterator[JointTask]:
    for name, upright, middle, share in STANDARD[count]:
        along = f"{share * reach!r} m"
        link = ("0 m", "0 m", along) if upright else (along, "0 m", "0 m")
        axis = UP if upright else SIDE
        yield JointTask.model_validate({"name": name, "axis": axis, "middle": f"{middle!r} deg", "link": link})


def read_task(where: str | Path | None = None, **given: Any) -> ArmTask:
    """Return a task from a built-in name or a TOML file, with what is given laid over it.

    Args:
        where: built-in name or file; None: what is given is all.
        **given: texts with units by key, such as reach="0.9 m"; what is None keeps what the file says, or its default.

    Raises:
        DesignError: in one line, what is wrong; a key that was given is named as an option.
    """
    told = {key: value for key, value in given.items() if value is not None}
    plain, sources = TASKS.tables(where) if where is not None else ({"name": "sized-arm", "title": ""}, {})
    for ways in INSTEAD:
        if ways & told.keys():
            plain = {key: value for key, value in plain.items() if key not in ways}
    place = "size-arm" if where is None else str(where)

    def written(steps: Steps, _: object) -> str:
        first, *rest = map(str, steps) if steps else [""]
        return ".".join([f"--{first.replace('_', '-')}" if first in told else first, *rest])

    try:
        task = ArmTask.model_validate(plain | told)
    except ValidationError as error:
        raise explained(error, place, ArmTask, DesignError, WHOLE, written) from None
    task._provenance.update(sources)
    task._origin = place
    return task
