"""What an arm is asked to do, as a file says it or as options do."""

from collections.abc import Iterator
from math import radians
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self

from pydantic import Field, ValidationError, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.explain import explained
from layflat.description.library import Library
from layflat.description.part import Described
from layflat.errors import DesignError
from layflat.physics.arms.chain.description import NO_WAY, Place, Way
from layflat.physics.arms.kind import MOST

TASKS = Library(
    Path(__file__).parent / "builtin", "task", "give a TOML file, or --reach and others", 'reach = "0.9 m"', DesignError
)

FALL = 9.81  # m/s2
Posture = Annotated[tuple[u.Angle, ...], Field(min_length=1, max_length=MOST)]


class JointTask(Part):
    """A joint, and the link that it turns."""

    name: str
    axis: Way = Field(description="about which it turns its link, in the link's frame")
    middle: u.Angle = Field(default=0.0, description="by which the link is turned about it in mid-stroke")
    stroke: u.PositiveAngle = Field(default=radians(120.0), description="working stroke")
    link: Place = Field(description="from this joint to the next one, or to the payload, in the link's frame")

    @model_validator(mode="after")
    def _leads_on(self) -> Self:
        for what, way in (("axis", self.axis), ("link", self.link)):
            if sum(one * one for one in way) < NO_WAY:
                raise ValueError(f"{what} has no length")
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
    supply: u.PositivePressure = Field(description="gauge pressure")
    reach: u.Length | None = Field(default=None, description="of a standard arm, from its shoulder to the payload")
    joints: Annotated[int, Field(ge=min(STANDARD), le=max(STANDARD))] | None = Field(
        default=None, description="of a standard arm: lift; shoulder, elbow; with a turning base; with a wrist"
    )
    joint: Annotated[tuple[JointTask, ...], Field(max_length=MOST)] = Field(
        default=(), description="of any other arm, from base to tip"
    )
    time: u.Time | None = Field(default=None, description="that a move may take, from rest to rest")
    acceleration: u.PositiveAcceleration | None = Field(default=None, description="in place of time: of the tip")
    turn: u.PositiveAngle = Field(
        default=radians(60.0), description="of the joint that turns most in a move where no poses or volume are given"
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
            raise ValueError("joints is of a standard arm; [[joint]] tables are as many as they are")
        if (self.time is None) == (self.acceleration is None):
            raise ValueError("needs time, that a move may take, or acceleration; give one of them")
        if sum(map(bool, (self.poses, self.points, self.volume))) > 1:
            raise ValueError("poses, points and volume are ways to say which moves; give one of them")
        named = [joint.name for joint in self.chain]
        if len(set(named)) < len(named):
            raise ValueError("two joints have the same name")
        for posture in self.poses:
            _check_posture(posture, self.chain)
        for given in (self.poses, self.points):
            if len(given) == 1:
                raise ValueError("a single pose is no move; give at least two")
        return self

    @property
    def chain(self) -> tuple[JointTask, ...]:
        """Joints and their links, from base to tip."""
        return self.joint or tuple(_standard(self.joints or max(STANDARD), self.reach or 0.0))


def _check_posture(posture: tuple[float, ...], chain: tuple[JointTask, ...]) -> None:
    if len(posture) != len(chain):
        raise ValueError(f"a pose has {len(posture)} angles; give one a joint, {len(chain)}")
    for joint, angle in zip(chain, posture, strict=True):
        if abs(angle) > 0.5 * joint.stroke * (1.0 + 1e-9):
            raise ValueError(f"a pose is outside the stroke of joint {joint.name!r}; angles are from mid-stroke")


def _standard(count: int, reach: float) -> Iterator[JointTask]:
    for name, upright, middle, share in STANDARD[count]:
        along = f"{share * reach!r} m"
        link = ("0 m", "0 m", along) if upright else (along, "0 m", "0 m")
        axis = UP if upright else SIDE
        yield JointTask.model_validate({"name": name, "axis": axis, "middle": f"{middle!r} deg", "link": link})


def read_task(where: str | Path) -> ArmTask:
    """Return a task from a built-in name or a TOML file; raise DesignError, in one line, for what is wrong in it."""
    plain, sources = TASKS.tables(where)
    return _built(plain, str(where), sources)


def task_of(name: str, **given: Any) -> ArmTask:
    """Return a task of texts with units, such as reach="0.9 m"; what is None keeps its default.

    Raises:
        DesignError: in one line, what is wrong.
    """
    told = {key: value for key, value in given.items() if value is not None}
    return _built({"name": name, "title": "", **told}, "size-arm", {})


def _built(plain: dict[str, Any], where: str, sources: Any) -> ArmTask:
    try:
        task = ArmTask.model_validate(plain)
    except ValidationError as error:
        raise explained(error, where, ArmTask, DesignError, "docs/arms.md shows a complete task") from None
    task._provenance.update(sources)
    task._origin = where
    return task
