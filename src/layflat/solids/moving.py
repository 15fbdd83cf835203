"""Triangles of an arm's joints for scenes, by what moves together; hoses and straps, which change, are left out."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from layflat import extras
from layflat.bridge.pieces import rigid_arm
from layflat.lazy import numpy as np
from layflat.physics.arms.bodies import rotation_about_axis
from layflat.solids import cad
from layflat.solids.assembly import assemble
from layflat.solids.coarse import coarse_triangles
from layflat.solids.colours import MATERIAL_COLOURS
from layflat.solids.gltf import frame_of, moving_frames
from layflat.solids.kernel import ROOM_NAME
from layflat.solids.meshes import solid_mesh
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.arrays import Array
    from layflat.machine import Machine
    from layflat.solids.gltf import Frame
    from layflat.solids.shapes import Shape

SCENE_CHORD_ERROR, SCENE_CHORD_ANGLE = 0.4, 0.4  # of triangles for scenes: mm, rad
MAX_SHAPES = 2000  # of which triangles are kept
SMALL_PARTS = ("screw", "washer", "nut", "set screw", "lower screw", "upper screw")  # beginnings of names: left out
_triangles: OrderedDict[Shape, Array] = OrderedDict()


@dataclass(frozen=True)
class Hinge:
    """Hinge of a shell in the frame that carries it: the shell turns as its joint does."""

    joint: int  # number of the joint, from the base
    origin: Array  # m, (3,)
    axis: Array  # of length 1, (3,)
    angles: Array  # of the joint from mid-stroke, rad, ascending, (n,)
    turns: Array  # of the shell from where it is in mid-stroke, rad, (n,)

    def pose(self, angle: float) -> tuple[Array, Array]:
        """Return axes (3, 3) and origin (m, (3,)) in the carrying frame at an angle of the joint, rad."""
        axes = rotation_about_axis(self.axis, float(np.interp(angle, self.angles, self.turns)))
        return axes, self.origin - axes @ self.origin


@dataclass(frozen=True)
class MovingSolids:
    """Solids that move together, by the colours of their materials."""

    frame: int  # number of the carrying frame: 0 is the base, k + 1 the link that joint k turns
    hinge: Hinge | None  # of shells
    triangles: dict[str, Array]  # corners in the carrying frame, m, (n, 3, 3), float32; by colour, such as "#29333f"

    def pose(self, frames: Sequence[tuple[Array, Array]], angles: Sequence[float] | Array) -> tuple[Array, Array]:
        """Return axes (3, 3) and origin (m, (3,)) of the solids.

        Args:
            frames: axes and origins of base and links.
            angles: of the joints from mid-stroke, rad.
        """
        axes, origin = frames[self.frame]
        if self.hinge is None:
            return axes, origin
        own, shift = self.hinge.pose(float(angles[self.hinge.joint]))
        return axes @ own, origin + axes @ shift


def moving_solids(machine: Machine, budget: int | None = None) -> list[MovingSolids]:
    """Return the solids of an arm; none where a joint has no solids, or a link has a mesh of its own.

    Args:
        machine: machine of the arm.
        budget: most triangles of all solids, which then have no holes; default: no bound, and triangles of shapes are
            kept for later calls.

    Raises:
        MissingExtraError: the extra `cad` is not installed.
        LayflatError: the arm or one of its joints can't be made.
    """
    extras.require("cad", where=ROOM_NAME)
    arm = rigid_arm(machine)
    if any(shape.kind == "mesh" for link in arm.links for shape in link.shapes):
        return []
    assembly = assemble(machine)
    if assembly.omitted:
        return []
    frames = moving_frames(assembly.components, assembly.sizes)
    names = list(machine.joints)
    carriers = [(np.eye(3), np.zeros(3)), *arm.poses([0.0] * len(names))]
    found: dict[tuple[int, str], dict[str, list[Array]]] = {}
    drawn = [one for one in assembly.components if not one.group.startswith("hose")]
    drawn = [one for one in drawn if not one.name.startswith(SMALL_PARTS)]
    coarse = None if budget is None else coarse_triangles(drawn, budget)
    for one in drawn:
        if coarse is not None and one.shape not in coarse:
            continue
        home = frame_of(one, frames)
        number = names.index(one.joint) + (one.group == "output")
        axes, origin = carriers[number]
        parts = found.setdefault((number, home if "shell" in home else ""), {})
        own = _shape_triangles(one.shape) if coarse is None else coarse[one.shape]
        for at in one.places:
            corners = ((own @ at.axes.T + at.origin) / MM - origin) @ axes
            parts.setdefault(MATERIAL_COLOURS[one.material], []).append(corners.astype("<f4"))
    return [
        MovingSolids(
            number,
            _hinge(number, frames[home], *carriers[number]) if home else None,
            {colour: np.concatenate(corners) for colour, corners in parts.items()},
        )
        for (number, home), parts in found.items()
    ]


def _hinge(joint: int, frame: Frame, axes: Array, origin: Array) -> Hinge:
    """Return the hinge of a shell's frame, in the carrying frame of these axes and this origin (m)."""
    angles, openings = np.array(frame.extras["angles"]), np.array(frame.extras["openings"])
    turns = openings - np.interp(0.0, angles, openings)
    return Hinge(joint, axes.T @ (frame.place.origin / MM - origin), axes.T @ frame.place.axes[:, 2], angles, turns)


def _shape_triangles(shape: Shape) -> Array:
    """Return the corners of a shape's triangles in its own frame, mm, (n, 3, 3); kept ones where there are."""
    if shape not in _triangles:
        mesh = solid_mesh(cad.solid(shape), SCENE_CHORD_ERROR, SCENE_CHORD_ANGLE)
        _triangles[shape] = mesh.points[mesh.triangles]
        while len(_triangles) > MAX_SHAPES:
            _triangles.popitem(last=False)
    _triangles.move_to_end(shape)
    return _triangles[shape]
