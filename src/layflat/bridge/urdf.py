"""A machine's arm as URDF."""

from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from layflat.arrays import Array
from layflat.bridge.formats import effort, nearest_inertia, velocity
from layflat.bridge.meshes import Meshes, is_unread
from layflat.bridge.mjcf import numbers
from layflat.bridge.pieces import BODY, COLOURS, Piece, joint_pieces, link_pieces, rigid
from layflat.machine import Machine, load
from layflat.physics.arms.bodies import moments, turn_of

POINT = 1e-14  # inertia of a point mass, kg m2: some readers refuse none at all
NOTHING = (0.0, np.zeros(3), np.zeros((3, 3)))  # body of a frame: PyBullet takes a link without inertial for 1 kg

LEVEL = np.eye(3)


def to_urdf(machine: str | Path | Machine, folder: str = "") -> str:
    """Return the arm as URDF: bodies as in `arm_spec`, drawn whole, with limits, friction and damping of the joints.

    Limits are the stops; the working stroke stands in `safety_controller`. `effort` is the greatest torque at supply
    pressure, `velocity` as of `layflat.bridge.formats`. The link "tool" is at the tip, "payload" is what it carries.
    Gravity, of which URDF knows nothing, stands in an element that MuJoCo reads.

    Args:
        machine: whose arm it is.
        folder: where its meshes are, relative to the text's file (see `save_arm`); default: NAME-meshes.

    Raises:
        InputError: the arm is of a kind without bodies, or a mesh is not there.
    """
    machine = load(machine)
    arm, pieces, bodies = rigid(machine), link_pieces(machine), joint_pieces(machine)
    meshes = Meshes((piece for own in pieces for piece in own), folder or f"{machine.name}-meshes", engine=False)
    robot = Element("robot", name=machine.name)
    _for_mujoco(robot, arm.gravity, pieces)
    for of in ("link", "joint"):
        SubElement(SubElement(robot, "material", name=of), "color", rgba=numbers(COLOURS[of]))
    parent = _link(robot, "base", None)
    for name, link, drawn, body in zip(machine.joints, arm.links, pieces, bodies, strict=True):
        own = _link(robot, f"{name}-link", (link.mass, link.centre, link.inertia))
        for at, piece in enumerate(drawn):
            _visual(robot[-1], piece, f"{name}-{at}", meshes)
        _visual(robot[-1], body, f"{name}-{BODY}", meshes)
        joint = _joint(robot, name, "revolute", parent, own, link.place, link.axes)
        SubElement(joint, "axis", xyz=numbers(link.axis))
        _limit(joint, machine, name, link.armature)
        parent = own
    ends = ["tool", "payload"] if machine.arm.payload > 0.0 else ["tool"]
    weights = {
        "tool": NOTHING,
        "payload": (machine.arm.payload, np.zeros(3), moments((POINT, POINT, POINT, 0.0, 0.0, 0.0))),
    }
    for end in ends:
        _joint(robot, f"{end}-fixed", "fixed", parent, _link(robot, end, weights[end]), arm.tool, arm.tool_axes)
    indent(robot)
    return '<?xml version="1.0"?>\n' + tostring(robot, encoding="unicode") + "\n"


def unread_meshes(pieces: Iterable[Iterable[Piece]]) -> list[str]:
    """Return the names of meshes that MuJoCo reads from no URDF."""
    unread = {piece.file.name for own in pieces for piece in own if piece.file and is_unread(piece.file, piece.scale)}
    return sorted(unread)


def _for_mujoco(robot: Element, gravity: Array, pieces: list[list[Piece]]) -> None:
    # MuJoCo has to do without all that is drawn where it would refuse a mesh.
    unread = bool(unread_meshes(pieces))
    own = SubElement(robot, "mujoco")
    SubElement(own, "compiler", strippath="false", discardvisual="true" if unread else "false")
    SubElement(own, "option", gravity=numbers(gravity))


def _link(robot: Element, name: str, body: tuple[float, Array, Array] | None) -> str:
    link = SubElement(robot, "link", name=name)
    if body is not None:
        mass, centre, inertia = body
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "origin", xyz=numbers(centre), rpy="0 0 0")
        SubElement(inertial, "mass", value=repr(float(mass)))
        rows, columns = np.triu_indices(3)
        keys = [f"i{'xyz'[i]}{'xyz'[j]}" for i, j in zip(rows, columns, strict=True)]
        values = map(repr, nearest_inertia(inertia)[rows, columns].tolist())
        SubElement(inertial, "inertia", dict(zip(keys, values, strict=True)))
    return name


def _origin(parent: Element, place: Array, axes: Array) -> None:
    SubElement(parent, "origin", xyz=numbers(place), rpy=numbers(turn_of(axes)))


def _joint(robot: Element, name: str, kind: str, parent: str, child: str, place: Array, axes: Array) -> Element:
    joint = SubElement(robot, "joint", name=name, type=kind)
    _origin(joint, place, axes)
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    return joint


def _visual(link: Element, piece: Piece, name: str, meshes: Meshes) -> None:
    """Add a piece; one with round ends, which URDF lacks, is a cylinder and two balls."""
    if piece.kind == "capsule":
        diameter, length = piece.size
        ends = [(f"{name}-end-{i}", (i - 0.5) * length, "sphere", (diameter,)) for i in (0, 1)]
        parts = [(name, 0.0, "cylinder", piece.size), *ends]
    else:
        parts = [(name, 0.0, piece.kind, piece.size)]
    for called, along, kind, size in parts:
        visual = SubElement(link, "visual", name=called)
        _origin(visual, piece.place + piece.axes @ np.array([0.0, 0.0, along]), piece.axes)
        shape = SubElement(SubElement(visual, "geometry"), kind)
        if piece.file is not None:
            shape.set("filename", meshes.name(piece.file))
            shape.set("scale", numbers(meshes.scale(piece)))
        elif kind == "box":
            shape.set("size", numbers(size))
        else:
            shape.set("radius", repr(0.5 * size[0]))
            if kind == "cylinder":
                shape.set("length", repr(float(size[1])))
        SubElement(visual, "material", name=piece.of)


def _limit(joint: Element, machine: Machine, name: str, armature: float) -> None:
    described, torque, speed = machine.joints[name], effort(machine, name), velocity(machine, name)
    stops, works = described.stops.mechanical_stroke / 2, described.stops.working_stroke / 2
    SubElement(joint, "limit", lower=repr(-stops), upper=repr(stops), effort=f"{torque:.6g}", velocity=f"{speed:.6g}")
    friction = {"damping": repr(described.brake.viscous), "friction": repr(described.brake.torque)}
    # URDF has no armature. Readers skip what they do not know; our own import knows it.
    SubElement(joint, "dynamics", friction | ({"armature": repr(armature)} if armature else {}))
    # The gain is by which a joint that is too fast has no torque left.
    soft = {"soft_lower_limit": repr(-works), "soft_upper_limit": repr(works)}
    SubElement(joint, "safety_controller", soft | {"k_position": "0", "k_velocity": f"{torque / speed:.6g}"})
