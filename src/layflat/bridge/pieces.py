"""What is drawn of an arm: pieces in the frames of its links, as described or made up."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.physics.arms import ARMS
from layflat.physics.arms.bodies import RigidArm, turned_by

THICK = 0.04  # diameter of a link that is not described to look like anything, m
LEAST = 1e-3  # length of what is drawn, m

BODY = "joint-body"
"""What the bodies of joints are called where pieces have names: who reads a model back has joints of its own."""

COLOURS = {"link": (0.80, 0.82, 0.85, 1.0), "joint": (0.16, 0.20, 0.27, 1.0), "tip": (0.85, 0.42, 0.10, 1.0)}
"""Red, green, blue and opacity, 0..1: as far apart in black and white as in colour."""


@dataclass(frozen=True)
class Piece:
    """Something solid in the frame of a link."""

    kind: Literal["capsule", "cylinder", "box", "sphere", "mesh"]
    place: Array  # of its middle, m, (3,)
    axes: Array  # columns: axes of its own frame, (3, 3)
    size: tuple[float, ...]  # as a description's shapes have it, m
    of: Literal["link", "joint", "tip"] = "link"
    file: Path | None = None  # of a mesh
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


def rigid(machine: Machine) -> RigidArm:
    """Return the bodies of a machine's arm, without payload; raise InputError if its kind has none."""
    kind = ARMS.named(machine.arm.kind)
    if kind.bodies is None:
        known = " or ".join(one.name for one in ARMS if one.bodies is not None)
        raise InputError(
            f"arms of the kind {kind.name!r} have no bodies in space",
            where=f"{machine.origin}: arm.kind",
            right=f"give an arm of the kind {known}",
        )
    return kind.bodies(machine.arm, list(machine.joints.values()))


def link_pieces(machine: Machine) -> list[list[Piece]]:
    """Return what is drawn of each link: its shapes, or a rod from its joint to the next one, or to the tip."""
    arm, found = rigid(machine), []
    ends = [link.place for link in arm.links[1:]] + [arm.tool]
    for name, link, end in zip(machine.joints, arm.links, ends, strict=True):
        shapes = [_shape(machine, name, at, shape) for at, shape in enumerate(link.shapes)]
        length = float(np.linalg.norm(end))
        if not shapes and length > LEAST:
            shapes = [Piece("capsule", 0.5 * end, along(end / length), (THICK, length))]
        found.append(shapes)
    return found


def joint_pieces(machine: Machine) -> list[Piece]:
    """Return the body of each joint, hoses on a cylinder about its axis, in the frame of the link that it turns."""
    axes = [link.axis for link in rigid(machine).links]
    sizes = [(joint.cylinder.diameter, joint.body.height) for joint in machine.joints.values()]
    return [Piece("cylinder", np.zeros(3), along(axis), size, "joint") for axis, size in zip(axes, sizes, strict=True)]


def along(way: Array) -> Array:
    """Return axes (3, 3) of which z lies along a direction of length 1."""
    aside = np.eye(3)[int(np.argmin(np.abs(way)))]
    x = np.cross(aside, way)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(way, x), way])


def _shape(machine: Machine, name: str, at: int, shape: Any) -> Piece:
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
    return Piece(shape.kind, np.array(shape.place, float), turned_by(shape.turn), size, "link", file, shape.scale)
