"""A machine's arm as URDF."""

from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from layflat.arrays import Array
from layflat.bridge.meshes import Meshes, is_refused_by_mujoco
from layflat.bridge.mjcf import format_numbers, max_filling_velocity, max_supply_torque, nearest_inertia
from layflat.bridge.pieces import COLOURS, JOINT_BODY_NAME, Piece, joint_pieces, link_pieces, rigid_arm
from layflat.bridge.ros2_control import add_ros2_control
from layflat.machine import Machine, load
from layflat.physics.arms.bodies import angles_from_rotation, inertia_matrix

POINT_INERTIA = 1e-14  # inertia of a point mass, kg m2: some readers refuse 0
MASSLESS_BODY = (
    0.0,
    np.zeros(3),
    np.zeros((3, 3)),
)  # body of a mere frame: PyBullet assumes 1 kg for a link without inertial

BASE_AXES = np.eye(3)


def to_urdf(machine: str | Path | Machine, folder: str = "", *, ros2_control: bool = False) -> str:
    """Return the arm as URDF: bodies as in `arm_spec`, drawn whole, with limits, friction and damping of the joints.

    Limits are the stops; the working stroke is in `safety_controller`. `effort` is the maximum torque at supply
    pressure, `velocity` that of `max_filling_velocity`. At the tip are the link "tool" and, if it has mass,
    "payload". Gravity, which URDF lacks, is in an element that MuJoCo reads.

    Args:
        machine: the machine.
        folder: folder of its meshes, relative to the text's file (see `save_arm`); default: NAME-meshes.
        ros2_control: whether to add the block by which controllers of ROS 2 drive the joints.

    Raises:
        InputError: the arm is of a kind without bodies, or a mesh is not there.
    """
    machine = load(machine)
    arm, pieces, bodies = rigid_arm(machine), link_pieces(machine), joint_pieces(machine)
    meshes = Meshes(
        (piece for of_link in pieces for piece in of_link), folder or f"{machine.name}-meshes", engine=False
    )
    robot = Element("robot", name=machine.name)
    _add_mujoco_options(robot, arm.gravity, pieces)
    for of in ("link", "joint"):
        SubElement(SubElement(robot, "material", name=of), "color", rgba=format_numbers(COLOURS[of]))
    base, *children, tool = link_names(machine)
    parent = _add_link(robot, base, None)
    for name, child, link, drawn, body in zip(machine.joints, children, arm.links, pieces, bodies, strict=True):
        _add_link(robot, child, (link.mass, link.centre, link.inertia))
        for at, piece in enumerate(drawn):
            _add_visuals(robot[-1], piece, f"{name}-{at}", meshes)
        _add_visuals(robot[-1], body, f"{name}-{JOINT_BODY_NAME}", meshes)
        joint = _add_joint(robot, name, "revolute", parent, child, link.place, link.axes)
        SubElement(joint, "axis", xyz=format_numbers(link.axis))
        _add_limits(joint, machine, name, link.armature)
        parent = child
    ends = [tool, "payload"] if machine.arm.payload > 0.0 else [tool]
    weights = {
        tool: MASSLESS_BODY,
        "payload": (
            machine.arm.payload,
            np.zeros(3),
            inertia_matrix((POINT_INERTIA, POINT_INERTIA, POINT_INERTIA, 0.0, 0.0, 0.0)),
        ),
    }
    for end in ends:
        _add_joint(robot, f"{end}-fixed", "fixed", parent, _add_link(robot, end, weights[end]), arm.tool, arm.tool_axes)
    if ros2_control:
        add_ros2_control(robot, machine)
    indent(robot)
    return '<?xml version="1.0"?>\n' + tostring(robot, encoding="unicode") + "\n"


def link_names(machine: Machine) -> list[str]:
    """Return the names of an arm's links: base, that which each joint moves, and tool."""
    return ["base", *(f"{name}-link" for name in machine.joints), "tool"]


def unread_meshes(pieces: Iterable[Iterable[Piece]]) -> list[str]:
    """Return the sorted names of the files of meshes that MuJoCo can't read from a URDF."""
    unread = {
        piece.file.name
        for own in pieces
        for piece in own
        if piece.file and is_refused_by_mujoco(piece.file, piece.scale)
    }
    return sorted(unread)


def _add_mujoco_options(robot: Element, gravity: Array, pieces: list[list[Piece]]) -> None:
    """Add MuJoCo's own element: gravity, and no visuals at all if it would refuse one of the meshes."""
    unread = bool(unread_meshes(pieces))
    mujoco = SubElement(robot, "mujoco")
    SubElement(mujoco, "compiler", strippath="false", discardvisual="true" if unread else "false")
    SubElement(mujoco, "option", gravity=format_numbers(gravity))


def _add_link(robot: Element, name: str, body: tuple[float, Array, Array] | None) -> str:
    """Add a link, with an inertial if it has a body (mass, centre, inertia; kg, m, kg m2); return its name."""
    link = SubElement(robot, "link", name=name)
    if body is not None:
        mass, centre, inertia = body
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "origin", xyz=format_numbers(centre), rpy="0 0 0")
        SubElement(inertial, "mass", value=repr(float(mass)))
        rows, columns = np.triu_indices(3)
        keys = [f"i{'xyz'[i]}{'xyz'[j]}" for i, j in zip(rows, columns, strict=True)]
        values = map(repr, nearest_inertia(inertia)[rows, columns].tolist())
        SubElement(inertial, "inertia", dict(zip(keys, values, strict=True)))
    return name


def _origin(parent: Element, place: Array, axes: Array) -> None:
    SubElement(parent, "origin", xyz=format_numbers(place), rpy=format_numbers(angles_from_rotation(axes)))


def _add_joint(robot: Element, name: str, kind: str, parent: str, child: str, place: Array, axes: Array) -> Element:
    """Add a joint of a type between two links, at a pose in the parent; return it."""
    joint = SubElement(robot, "joint", name=name, type=kind)
    _origin(joint, place, axes)
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    return joint


def _add_visuals(link: Element, piece: Piece, name: str, meshes: Meshes) -> None:
    """Add a piece as visuals; a capsule, which URDF lacks, becomes a cylinder and two spheres."""
    if piece.kind == "capsule":
        diameter, length = piece.size
        ends = [(f"{name}-end-{i}", (i - 0.5) * length, "sphere", (diameter,)) for i in (0, 1)]
        parts = [(name, 0.0, "cylinder", piece.size), *ends]
    else:
        parts = [(name, 0.0, piece.kind, piece.size)]
    for called, along, kind, size in parts:
        visual = SubElement(link, "visual", name=called)
        _origin(visual, piece.position + piece.axes @ np.array([0.0, 0.0, along]), piece.axes)
        shape = SubElement(SubElement(visual, "geometry"), kind)
        if piece.file is not None:
            shape.set("filename", meshes.name(piece.file))
            shape.set("scale", format_numbers(meshes.scale(piece)))
        elif kind == "box":
            shape.set("size", format_numbers(size))
        else:
            shape.set("radius", repr(0.5 * size[0]))
            if kind == "cylinder":
                shape.set("length", repr(float(size[1])))
        SubElement(visual, "material", name=piece.of)


def _add_limits(joint: Element, machine: Machine, name: str, armature: float) -> None:
    """Add limits, friction and armature of a machine's joint: stops as limits, the working stroke as soft limits."""
    described, torque, speed = (
        machine.joints[name],
        max_supply_torque(machine, name),
        max_filling_velocity(machine, name),
    )
    stops, works = described.stops.mechanical_stroke / 2, described.stops.working_stroke / 2
    SubElement(joint, "limit", lower=repr(-stops), upper=repr(stops), effort=f"{torque:.6g}", velocity=f"{speed:.6g}")
    friction = {"damping": repr(described.brake.viscous), "friction": repr(described.brake.torque)}
    # URDF has no armature. Readers skip what they do not know; our own import knows it.
    SubElement(joint, "dynamics", friction | ({"armature": repr(armature)} if armature else {}))
    # The gain is by which a joint that is too fast has no torque left.
    soft = {"soft_lower_limit": repr(-works), "soft_upper_limit": repr(works)}
    SubElement(joint, "safety_controller", soft | {"k_position": "0", "k_velocity": f"{torque / speed:.6g}"})
