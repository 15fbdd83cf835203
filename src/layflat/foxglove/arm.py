"""An arm in space as Foxglove shows it: transforms between its frames, and the solids that it is drawn by.

Frames have the names of the links of the arm's URDF, so that one of `save_arm` moves as well, below the frame "world",
in which gravity is along -z.
"""

from collections.abc import Sequence
from math import cos, sin
from typing import Any

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.bridge.meshes import read_mesh
from layflat.bridge.mjcf import quaternion
from layflat.bridge.pieces import COLOURS, Piece
from layflat.bridge.urdf import link_names
from layflat.bridge.view.scenery import scenery
from layflat.machine import Machine

ROOM_FRAME = "world"


class ArmMessages:
    """Messages that show a machine's arm.

    Raises:
        InputError: a mesh of the arm is missing or can't be read.
        MissingExtraError: Foxglove's SDK is not installed, or a mesh needs a package to be converted.
    """

    def __init__(self, machine: Machine) -> None:
        self._messages = messages = extras.import_extra("foxglove", "foxglove.messages")
        self._shown = shown = scenery(machine, [0.0] * len(machine.joints))
        self.frames = (ROOM_FRAME, *link_names(machine))
        pieces: list[list[Piece]] = [[] for _ in self.frames[1:]]
        for frame, piece in shown.pieces:
            pieces[frame].append(piece)
        self._primitives = [_Primitives(messages, drawn) for drawn in pieces]
        arm = shown.arm
        fixed = [shown.level, *(link.axes for link in arm.links), arm.tool_axes]  # where no joint has rotated
        self._rotations = [quaternion(axes).tolist() for axes in fixed]
        self._places = [_vector(messages, at) for at in (np.zeros(3), *(link.place for link in arm.links), arm.tool)]

    def transforms(self, stamp: int, angles: Sequence[float] | Array) -> Any:
        """Return all frames at joint angles (rad), each in its parent, as foxglove.FrameTransforms at a stamp, ns."""
        m, time = self._messages, _timestamp(self._messages, stamp)
        turns = [
            _turn(fixed, link.axis, float(angle))
            for fixed, link, angle in zip(self._rotations[1:], self._shown.arm.links, angles, strict=False)
        ]
        rotations = [self._rotations[0], *turns, self._rotations[-1]]
        return m.FrameTransforms(
            transforms=[
                m.FrameTransform(
                    timestamp=time,
                    parent_frame_id=parent,
                    child_frame_id=child,
                    translation=place,
                    rotation=m.Quaternion(w=w, x=x, y=y, z=z),
                )
                for parent, child, place, (w, x, y, z) in zip(
                    self.frames, self.frames[1:], self._places, rotations, strict=False
                )
            ]
        )

    def scene(self, stamp: int) -> Any:
        """Return the solids of all links as foxglove.SceneUpdate at a stamp, ns; each moves with its frame."""
        m = self._messages
        return m.SceneUpdate(
            entities=[
                m.SceneEntity(
                    timestamp=_timestamp(m, stamp), frame_id=frame, id=frame, frame_locked=True, **drawn.by_kind
                )
                for frame, drawn in zip(self.frames[1:], self._primitives, strict=True)
                if drawn.by_kind
            ]
        )


class _Primitives:
    """Primitives of the pieces of one frame, in lists by the names of the fields of foxglove.SceneEntity."""

    def __init__(self, messages: Any, pieces: Sequence[Piece]) -> None:
        self._messages, self.by_kind = messages, dict[str, list[Any]]()
        for piece in pieces:
            self._add(piece)

    def _add(self, piece: Piece) -> None:
        """Add a piece; a capsule, which Foxglove lacks, becomes a cylinder and two spheres."""
        m, size = self._messages, piece.size
        if piece.file is not None:
            kind = "model/obj" if piece.file.suffix.lower() == ".obj" else "model/stl"  # as `read_mesh` converts it
            mesh = {"media_type": kind, "data": read_mesh(piece.file, engine=True), "scale": _vector(m, piece.scale)}
            self._append("models", m.ModelPrimitive, piece, 0.0, override_color=True, **mesh)
        elif piece.kind == "box":
            self._append("cubes", m.CubePrimitive, piece, 0.0, size=_vector(m, size))
        elif piece.kind == "sphere":
            self._append("spheres", m.SpherePrimitive, piece, 0.0, size=_vector(m, 3 * size))
        else:
            diameter, length = size
            # The faces of a cylinder have no size by default.
            whole = {"size": m.Vector3(x=diameter, y=diameter, z=length), "bottom_scale": 1.0, "top_scale": 1.0}
            self._append("cylinders", m.CylinderPrimitive, piece, 0.0, **whole)
            for end in (-0.5, 0.5) if piece.kind == "capsule" else ():
                self._append("spheres", m.SpherePrimitive, piece, end * length, size=_vector(m, (diameter,) * 3))

    def _append(self, kind: str, primitive: Any, piece: Piece, along: float, **more: Any) -> None:
        """Append a primitive at the pose of a piece, moved along its z axis (m), in its colour."""
        m = self._messages
        place = piece.position + along * piece.axes[:, 2]
        pose = m.Pose(position=_vector(m, place), orientation=_rotation(m, piece.axes))
        red, green, blue, opacity = COLOURS[piece.of]
        colour = m.Color(r=red, g=green, b=blue, a=opacity)
        self.by_kind.setdefault(kind, []).append(primitive(pose=pose, color=colour, **more))


def _timestamp(messages: Any, stamp: int) -> Any:
    """Return a stamp (ns) as Foxglove's Timestamp."""
    return messages.Timestamp(*divmod(int(stamp), 1_000_000_000))


def _vector(messages: Any, values: Sequence[float] | Array) -> Any:
    x, y, z = map(float, values)
    return messages.Vector3(x=x, y=y, z=z)


def _turn(fixed: Sequence[float], axis: Array, angle: float) -> list[float]:
    """Return a rotation about an axis of length 1 by an angle (rad) in axes that are fixed, as quaternions w, x, y, z.

    It is the product of both quaternions: as matrices, SciPy takes ten times as long.
    """
    w, x, y, z = fixed
    d = cos(0.5 * angle)
    a, b, c = (sin(0.5 * angle) * axis).tolist()
    return [
        w * d - x * a - y * b - z * c,
        w * a + x * d + y * c - z * b,
        w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d,
    ]


def _rotation(messages: Any, axes: Array) -> Any:
    """Return axes (3, 3) as Foxglove's Quaternion."""
    w, x, y, z = map(float, quaternion(axes))
    return messages.Quaternion(x=x, y=y, z=z, w=w)
