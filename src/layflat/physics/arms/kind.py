"""Kind of arm: laws that turn torques into motion, and its forward kinematics."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import nan
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from layflat.description import units as u
from layflat.errors import KindError
from layflat.jit import law
from layflat.kind_checks import MisfitError, check_items, check_numbers, naming_law, tolerating_arithmetic
from layflat.kinds import REQUIRED_ENTRY, Kind, KindPart
from layflat.lanes import select
from layflat.physics.arms.bodies import RigidArm

Law = Callable[..., Any]

MAX_JOINTS = 7  # joints of an arm

NO_TORQUE = -0.0
"""No torque: added to any number it leaves every bit as it was, which +0.0 does not do to -0.0."""


class ArmPart(KindPart):
    """Description of an arm: fields that all kinds share, its joints from base to tip and its load."""

    joints: Annotated[tuple[str, ...], Field(min_length=1)]
    payload: u.Payload
    own_links: ClassVar[bool] = False  # whether it describes its links itself: its joints then need none

    @model_validator(mode="after")
    def _check_distinct_joints(self) -> Self:
        """Raise ValueError if a joint is named twice."""
        for place, name in enumerate(self.joints):
            if name in self.joints[:place]:
                raise ValueError(f"joints names {name!r} twice; name each joint once")
        return self


@dataclass(frozen=True, kw_only=True)
class ArmLaws:
    """Laws of the arms whose parameters are of one class. Angles and torques are tuples with an item per joint."""

    joints: int | None  # number of joints of such an arm; None: the parameters say it
    dynamics: Law
    """`dynamics(arm, payload, q, v)` yields three tuples at angles q (rad) and velocities v (rad/s): the upper triangle
    of the mass matrix, row by row (kg m2); the velocity-dependent torques (N m, `NO_TORQUE` where there are none); and
    the angle-dependent ones (gravity, springs)."""
    points: Law
    """`points(arm, q)` yields positions of all joints from the base on, and of the tip, m: (x, y), x along link 1 at
    mid-stroke; or (x, y, z) in the frame of the base."""
    axes: int = 2  # of these positions
    axis_directions: Law | None = None
    """`axis_directions(arm, q)` yields each joint's axis, unit vector (x, y, z) in the base frame; None: all are z."""


@dataclass(frozen=True, kw_only=True)
class ArmKind(Kind):
    """A kind of arm.

    `parameters(described, joints)` has the described arm and joints (a list, from base to tip).
    """

    bodies: Callable[..., RigidArm] | None = None
    """`bodies(described, joints)` yields the arm as rigid bodies, for other engines and pictures; None: it has none."""

    laws: Mapping[type, ArmLaws] = REQUIRED_ENTRY  # by class of the parameters

    def __post_init__(self) -> None:
        """Raise KindError if a class of parameters has no laws, or laws of more than `MAX_JOINTS` joints."""
        super().__post_init__()
        for cls in self.parameter_types:
            if cls not in self.laws or self.laws[cls].joints not in (None, *range(1, MAX_JOINTS + 1)):
                raise KindError(
                    f"{cls.__name__} has no laws for one to {MAX_JOINTS} joints", where=f"kind {self.name!r} of arm"
                )

    def guarded(self) -> "ArmKind":
        """Return the kind with a mass matrix whose first item becomes NaN where it is not positive."""
        laws = {
            cls: replace(of_class, dynamics=_with_positive_mass(of_class.dynamics))
            for cls, of_class in self.laws.items()
        }
        return replace(self, laws=laws)

    def try_laws(self, parameters: Any, *described: Any) -> None:
        """Call the laws of an arm in two configurations; raise KindError if a result has a wrong shape or value."""
        laws, count, thing = self.laws[type(parameters)], len(described[0].joints), f"arm {self.name!r}"
        for angle in (0.0, 0.2):
            q, v = (angle,) * count, (0.1,) * count
            with tolerating_arithmetic(laws.dynamics), naming_law(thing, "dynamics", laws.dynamics):
                result = laws.dynamics(parameters, 1.0, q, v)
                check_items(result, 3, "the tuple of masses and two torques")
                check_numbers(result[0], count * (count + 1) // 2, "the mass matrix")
                check_numbers(result[1], count, "the torques of velocities")
                check_numbers(result[2], count, "the torques of angles")
                first = result[0][0]
                if first <= 0.0:
                    raise MisfitError(f"item 1 of the mass matrix is {first:g} kg m2; it has to be positive")
            with tolerating_arithmetic(laws.points), naming_law(thing, "points", laws.points):
                points = laws.points(parameters, q)
                check_items(points, count + 1, "the tuple of joints and tip")
                for point in points:
                    check_numbers(point, laws.axes, "a position")

    def laws_by_parameter_type(self) -> Mapping[type, Any]:
        """Return the objects with the compiled laws, by type of the laws' parameters."""
        return self.laws


def _with_positive_mass(dynamics_of: Law) -> Law:
    """Return the dynamics, with NaN in place of a first mass (kg m2) that is not positive."""

    @law
    def dynamics(arm, payload, q, v):
        masses, of_velocities, of_angles = dynamics_of(arm, payload, q, v)
        return (select(masses[0] > 0.0, masses[0], nan), *masses[1:]), of_velocities, of_angles

    return dynamics
