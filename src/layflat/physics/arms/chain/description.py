"""Description of an arm in space: a chain of joints and links, from the base to the tool."""

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.names import Key
from layflat.physics.arms.kind import MOST, ArmPart

ROUNDING = 1e-5  # by how much, as a share, moments of inertia of six digits may miss the triangle inequality
NO_WAY = 1e-12  # length of what has no direction

Place = tuple[u.Coordinate, u.Coordinate, u.Coordinate]
Turn = tuple[u.Angle, u.Angle, u.Angle]
Way = tuple[float, float, float]
NO_TURN = (0.0, 0.0, 0.0)


def six_moments(inertia: tuple[Any, ...]) -> tuple[Any, ...]:
    """All of an inertia, xx, yy, zz, xy, xz, yz, of which a file may leave out the last three."""
    return (*inertia, 0.0, 0.0, 0.0)[:6]


def impossible(inertia: tuple[Any, ...]) -> str:
    """Why no body has such an inertia, kg m2 (see `six_moments`; numbers, or an item a run); empty where one may."""
    xx, yy, zz, xy, xz, yz = np.broadcast_arrays(*six_moments(inertia))
    matrices = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)
    for least, middle, greatest in np.linalg.eigvalsh(matrices):
        if least <= 0.0:
            return f"has the principal moment {least:.4g} kg m2; those of a body are positive"
        if greatest > (least + middle) * (1.0 + ROUNDING):
            moments = f"{least:.4g}, {middle:.4g} and {greatest:.4g} kg m2"
            return f"has principal moments {moments}; none can be greater than the other two together"
    return ""


class Shape(Part):
    """Shape of a piece of a link: drawn in its frame, without effect on the motion."""

    kind: Literal["capsule", "cylinder", "box", "sphere", "mesh"]
    place: Place = Field(default=NO_TURN, description="its middle")
    turn: Turn = Field(default=NO_TURN, description="of its frame: about x, then about the link's y, then its z")
    size: Annotated[tuple[u.Length, ...], Field(min_length=1, max_length=3)] | None = Field(
        default=None,
        description="box: along x, y and z; cylinder and capsule: diameter, length along z; sphere: diameter",
    )
    file: str = Field(default="", description="of a mesh, beside the description")
    scale: Way = (1.0, 1.0, 1.0)

    @model_validator(mode="after")
    def _whole(self) -> Self:
        wanted = {"capsule": 2, "cylinder": 2, "box": 3, "sphere": 1, "mesh": 0}[self.kind]
        if len(self.size or ()) != wanted:
            raise ValueError(f"size of a {self.kind} has {wanted} lengths, not {len(self.size or ())}")
        if (self.kind == "mesh") != bool(self.file):
            raise ValueError(f"a {self.kind} {'needs a' if self.kind == 'mesh' else 'has no'} file")
        return self


class LinkPart(Part):
    """A link in space, with the joint that turns it: in a frame that lies in the one of the link before."""

    axis: Way = Field(description="about which the joint turns this link, in its frame; of any length")
    place: Place = Field(description="of the joint, and of the frame's origin, in the frame of the link before")
    turn: Turn = Field(
        default=NO_TURN,
        description="of the frame in mid-stroke, in that of the link before: about x, then about its y, then its z",
    )
    mass: u.PositiveMass = Field(description="without the body of the joint at its other end")
    centre: Place = Field(description="of mass")
    inertia: Annotated[tuple[u.AnyInertia, ...], Field(min_length=3, max_length=6)] = Field(
        description="about the centre of mass, along the frame's axes: xx, yy, zz; and xy, xz, yz, where not 0"
    )
    rotor_inertia: u.InertiaOrZero = Field(
        default=0.0, description="of cams, shaft and brake disk, taken for a disk about the joint"
    )
    armature: u.InertiaOrZero = Field(
        default=0.0, description="of what a gear lets turn with the joint's speed alone, as MuJoCo's armature"
    )
    shapes: tuple[Shape, ...] = ()

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if np.any(np.sum(np.square(self.axis), axis=0) < NO_WAY):
            raise ValueError("axis has no direction; a joint that turns about z has [0, 0, 1]")
        if len(self.inertia) not in (3, 6):
            raise ValueError(f"inertia has {len(self.inertia)} values; give xx, yy, zz, or these and xy, xz, yz")
        wrong = impossible(self.inertia)
        if wrong:
            raise ValueError(f"inertia {wrong}")
        return self


class ChainPart(ArmPart):
    """An arm in space: links after each other, each turned by a joint."""

    own_links = True

    kind: Literal["chain"]
    joints: Annotated[tuple[str, ...], Field(min_length=1, max_length=MOST)]
    link: dict[Key, LinkPart] = Field(description="by the joint that turns it")
    tool: Place = Field(description="of the payload and of the tip, in the frame of the last link")
    tool_turn: Turn = Field(default=NO_TURN, description="of the tool's frame, likewise")
    gravity: tuple[u.AnyGravity, u.AnyGravity, u.AnyGravity] = Field(description="in the frame of the base")
    bodies: Literal["carried", "in links"] = Field(
        default="carried",
        description="whether each link carries the body of the next joint on top of its mass, or has it in its mass",
    )

    @model_validator(mode="after")
    def _a_link_each(self) -> Self:
        for name in self.joints:
            if name not in self.link:
                raise ValueError(f"link has none of joint {name!r}; describe it as [arm.link.{name}]")
        for name in self.link:
            if name not in self.joints:
                raise ValueError(f"link names {name!r}, which is not in joints")
        return self
