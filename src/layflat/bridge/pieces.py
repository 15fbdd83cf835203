"""Pieces that an arm is drawn by, in the frames of its links: described shapes, or default rods."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.physics.arms import ARM_KINDS
from layflat.physics.arms.bodies import RigidArm, rotation_from_angles

ROD_DIAMETER = 0.04  # of a link without described shapes, m
MIN_ROD_LENGTH = 1e-3  # shorter rods are not drawn, m

JOINT_BODY_NAME = "joint-body"
"""Name of the bodies of joints in models, by which an import recognises and omits them."""

COLOURS = {"link": (0.80, 0.82, 0.85, 1.0), "joint": (0.16, 0.20, 0.27, 1.0), "tip": (0.85, 0.42, 0.10, 1.0)}
"""Red, green, blue and opacity, 0..1, distinguishable in grey as well."""


@dataclass(frozen=True)
class Piece:
    """Solid in the frame of a link that is drawn."""

    kind: Literal["capsule", "cylinder", "box", "sphere", "mesh"]
    position: Array  # position of its middle, m, (3,)
    axes: Array  # columns: axes of its own frame, (3, 3)
    size: tuple[float, ...]  # as a description's shapes have it, m
    of: Literal["link", "joint", "tip"] = "link"
    file: Path | None = None  # of a mesh
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


def rigid_arm(machine: Machine) -> RigidArm:
    """Return the bodies of a machine's arm, without payload; raise InputError if its kind has none."""
    kind = ARM_KINDS.named(machine.arm.kind)
    if kind.bodies is None:
        known = " or ".join(one.name for one in ARM_KINDS if one.bodies is not None)
        raise InputError(
            f"arms of the kind {kind.name!r} have no bodies in space",
            where=f"{machine.origin}: arm.kind",
            right=f"give an arm of the kind {known}",
        )
    return kind.bodies(machine.arm, list(machine.joints.values()))


def link_pieces(machine: Machine) -> list[list[Piece]]:
    """Return the pieces of each link: its shapes, or a rod to the next joint or the tip; none if that is too short."""
    arm, pieces = rigid_arm(machine), []
    ends = [link.place for link in arm.links[1:]] + [arm.tool]
    for name, link, end in zip(machine.joints, arm.links, ends, strict=True):
        shapes = [_shape_piece(machine, name, at, shape) for at, shape in enumerate(link.shapes)]
        length = float(np.linalg.norm(end))
        if not shapes and length > MIN_ROD_LENGTH:
            shapes = [Piece("capsule", 0.5 * end, axes_with_z(end / length), (ROD_DIAMETER, length))]
        pieces.append(shapes)
    return pieces


def joint_pieces(machine: Machine) -> list[Piece]:
    """Return the body of each joint, hoses on a cylinder about its axis, in the frame of the link that it turns."""
    axes = [link.axis for link in rigid_arm(machine).links]
    sizes = [(joint.cylinder.diameter, joint.body.height) for joint in machine.joints.values()]
    return [
        Piece("cylinder", np.zeros(3), axes_with_z(axis), size, "joint") for axis, size in zip(axes, sizes, strict=True)
    ]


def axes_with_z(direction: Array) -> Array:
    """Return axes (3, 3) of which z lies along a direction of length 1."""
    across = np.eye(3)[int(np.argmin(np.abs(direction)))]
    x = np.cross(across, direction)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(direction, x), direction])


def _shape_piece(machine: Machine, name: str, at: int, shape: Any) -> Piece:
    """Return a described shape as a piece; raise InputError if its mesh is missing. `at` is its index in the link."""
    file = None
    if shape.kind == "mesh":
        file = Path(machine.origin).parent / shape.file
        if not file.is_file():
            raise InputError(
                f"{shape.file} is not there",
                where=f"{machine.origin}: arm.link.{name}.shapes.{at}.file",
                right="put the mesh there, or take the shape away",
            )
    size = tuple(map(float, shape.size or ()))
    return Piece(
        shape.kind,
        np.array(shape.position, float),
        rotation_from_angles(shape.rotation),
        size,
        "link",
        file,
        shape.scale,
    )
