"""Description of an arm in space: a chain of joints and links, from the base to the tool."""

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.names import Key
from layflat.lazy import numpy as np
from layflat.physics.arms.kind import MAX_JOINTS, ArmPart

TRIANGLE_INEQUALITY_TOLERANCE = (
    1e-5  # fraction by which moments of inertia of six digits may miss the triangle inequality
)
MIN_DIRECTION_LENGTH = 1e-12  # a shorter vector counts as one without direction

PositionVector = tuple[u.Coordinate, u.Coordinate, u.Coordinate]
AngleTriple = tuple[u.Angle, u.Angle, u.Angle]
NumberTriple = tuple[float, float, float]
ZERO_TRIPLE = (0.0, 0.0, 0.0)


def six_moments(inertia: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return xx, yy, zz, xy, xz, yz of an inertia of which a file may omit the last three, which are then 0."""
    return (*inertia, 0.0, 0.0, 0.0)[:6]


def describe_inertia_defect(inertia: tuple[Any, ...]) -> str:
    """Return the reason why no body has such an inertia, kg m2; empty where a body may have it.

    Args: `inertia`: see `six_moments`; numbers, or arrays with an item a run.
    """
    xx, yy, zz, xy, xz, yz = np.broadcast_arrays(*six_moments(inertia))
    matrices = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)
    for lower, middle, upper in np.linalg.eigvalsh(matrices):
        if lower <= 0.0:
            return f"has the principal moment {lower:.4g} kg m2; those of a body are positive"
        if upper > (lower + middle) * (1.0 + TRIANGLE_INEQUALITY_TOLERANCE):
            moments = f"{lower:.4g}, {middle:.4g} and {upper:.4g} kg m2"
            return f"has principal moments {moments}; none can be greater than the other two together"
    return ""


class LinkShape(Part):
    """Shape that a link is drawn by, in its frame; without effect on the motion."""

    kind: Literal["capsule", "cylinder", "box", "sphere", "mesh"]
    position: PositionVector = Field(default=ZERO_TRIPLE, description="its middle")
    rotation: AngleTriple = Field(
        default=ZERO_TRIPLE, description="of its frame: about x, then about the link's y, then its z"
    )
    size: Annotated[tuple[u.Length, ...], Field(min_length=1, max_length=3)] | None = Field(
        default=None,
        description="box: along x, y and z; cylinder and capsule: diameter, length along z; sphere: diameter",
    )
    file: str = Field(default="", description="of a mesh, beside the description")
    scale: NumberTriple = (1.0, 1.0, 1.0)

    @model_validator(mode="after")
    def _check_size_and_file(self) -> Self:
        """Raise ValueError if the number of lengths or the presence of a file does not fit the kind of shape."""
        count = {"capsule": 2, "cylinder": 2, "box": 3, "sphere": 1, "mesh": 0}[self.kind]
        if len(self.size or ()) != count:
            raise ValueError(f"size of a {self.kind} has {count} lengths, not {len(self.size or ())}")
        if (self.kind == "mesh") != bool(self.file):
            raise ValueError(f"a {self.kind} {'needs a' if self.kind == 'mesh' else 'has no'} file")
        return self


class LinkPart(Part):
    """A link in space, with the joint that turns it: in a frame that lies in the one of the link before."""

    axis: NumberTriple = Field(description="about which the joint rotates this link, in its frame; of any length")
    position: PositionVector = Field(
        description="of the joint, and of the frame's origin, in the frame of the link before"
    )
    rotation: AngleTriple = Field(
        default=ZERO_TRIPLE,
        description="of the frame in mid-stroke, in that of the link before: about x, then about its y, then its z",
    )
    mass: u.PositiveMass = Field(description="without the body of the joint at its other end")
    centre: PositionVector = Field(description="of mass")
    inertia: Annotated[tuple[u.AnyInertia, ...], Field(min_length=3, max_length=6)] = Field(
        description="about the centre of mass, along the frame's axes: xx, yy, zz; and xy, xz, yz, where not 0"
    )
    rotor_inertia: u.InertiaOrZero = Field(
        default=0.0, description="of cams, shaft and brake disk, taken for a disk about the joint"
    )
    armature: u.InertiaOrZero = Field(
        default=0.0, description="inertia that follows the joint's rotation alone, through a gear, as MuJoCo's armature"
    )
    shapes: tuple[LinkShape, ...] = ()

    @model_validator(mode="after")
    def _check_axis_and_inertia(self) -> Self:
        """Raise ValueError if an axis has no direction, or the inertia (kg m2) is none of a real body."""
        if np.any(np.sum(np.square(self.axis), axis=0) < MIN_DIRECTION_LENGTH):
            raise ValueError("axis has no direction; a joint that turns about z has [0, 0, 1]")
        if len(self.inertia) not in (3, 6):
            raise ValueError(f"inertia has {len(self.inertia)} values; give xx, yy, zz, or these and xy, xz, yz")
        wrong = describe_inertia_defect(self.inertia)
        if wrong:
            raise ValueError(f"inertia {wrong}")
        return self


class ChainPart(ArmPart):
    """An arm in space: links after each other, each turned by a joint."""

    own_links = True

    kind: Literal["chain"]
    joints: Annotated[tuple[str, ...], Field(min_length=1, max_length=MAX_JOINTS)]
    link: dict[Key, LinkPart] = Field(description="by the joint that rotates it")
    tool: PositionVector = Field(description="of the payload and of the tip, in the frame of the last link")
    tool_rotation: AngleTriple = Field(default=ZERO_TRIPLE, description="of the tool's frame, likewise")
    gravity: tuple[u.AnyGravity, u.AnyGravity, u.AnyGravity] = Field(description="in the frame of the base")
    bodies: Literal["carried", "in links"] = Field(
        default="carried",
        description="whether each link carries the body of the next joint on top of its mass, or has it in its mass",
    )

    @model_validator(mode="after")
    def _check_links_of_joints(self) -> Self:
        """Raise ValueError unless each joint has a link, and each link belongs to a joint."""
        for name in self.joints:
            if name not in self.link:
                raise ValueError(f"link has none of joint {name!r}; describe it as [arm.link.{name}]")
        for name in self.link:
            if name not in self.joints:
                raise ValueError(f"link names {name!r}, which is not in joints")
        return self
