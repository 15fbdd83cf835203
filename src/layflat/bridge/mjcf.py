"""A machine's arm as MJCF, with full precision, and values that MJCF and URDF share."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from layflat.arrays import Array
from layflat.bridge.meshes import Meshes
from layflat.bridge.pieces import COLOURS, JOINT_BODY_NAME, Piece, joint_pieces, link_pieces, rigid_arm
from layflat.machine import Machine, load, parameters
from layflat.physics.air_balance import REFERENCE_PRESSURE
from layflat.physics.arms.bodies import RigidLink
from layflat.physics.arms.chain.description import TRIANGLE_INEQUALITY_TOLERANCE
from layflat.physics.step import STEP

INERTIA_MARGIN = 1e-12  # fraction by which the maximum moment is below the sum of the others: MuJoCo's rounding
JOINT_BODY_SCALE = 1.01  # of drawn bodies of joints, so that they are visible inside links


def max_supply_torque(machine: Machine, name: str) -> float:
    """Return a joint's maximum torque at supply pressure, N m."""
    return float(parameters.torque_constant(machine.joints[name]) * machine.supply.pressure_gauge)


def max_filling_velocity(machine: Machine, name: str) -> float:
    """Return the maximum velocity (rad/s) at which a fully open valve keeps a hose at supply pressure.

    It is sonic conductance x reference pressure / (torque per pressure).
    """
    joint, (valve, *_) = machine.joints[name], parameters.valve_and_sensors(machine)
    conductance = joint.valve_size * valve.conductance
    return float(conductance * REFERENCE_PRESSURE / parameters.torque_constant(joint))


def realizable_inertia(inertia: Array) -> Array | None:
    """Return the nearest possible inertia (3, 3) of a body to one that violates the triangle inequality by rounding.

    A thin plate's maximum moment is the sum of both others; rounded, it is as often above as below. A possible inertia
    is returned unchanged, and None for one that is off by more than `TRIANGLE_INEQUALITY_TOLERANCE` or negative.
    """
    moments, axes = np.linalg.eigh(inertia)
    excess = moments[2] - (moments[0] + moments[1]) * (1.0 - INERTIA_MARGIN)
    if excess <= 0.0:
        return inertia
    if excess > TRIANGLE_INEQUALITY_TOLERANCE * moments[2] or moments[0] < 0.0:
        return None
    moments[2] -= excess
    if np.count_nonzero(inertia - np.diag(inertia.diagonal())):
        nearest: Array = axes @ np.diag(moments) @ axes.T
        return 0.5 * (nearest + nearest.T)
    greatest = int(np.argmax(inertia.diagonal()))
    diagonal = inertia.diagonal().copy()
    diagonal[greatest] -= excess
    return np.diag(diagonal)


def nearest_inertia(inertia: Array) -> Array:
    """Return `realizable_inertia`, or the inertia itself where that is None."""
    nearest = realizable_inertia(inertia)
    return inertia if nearest is None else nearest


def to_mjcf(machine: str | Path | Machine, folder: str = "") -> str:
    """Return the arm as MJCF for use without `PneumaticJoints`: with stops, bearings, brakes and torque limits.

    Args:
        machine: the machine.
        folder: folder of its meshes, relative to the text's file (see `save_arm`); default: NAME-meshes.

    Raises:
        InputError: the arm is of a kind without bodies, or a mesh is not there.
    """
    machine = load(machine)
    return tree_text(arm_tree(machine, passive=True, folder=folder or f"{machine.name}-meshes")[0])


def tree_text(root: Element) -> str:
    """Return an XML tree as text, after indenting it in place."""
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def arm_tree(machine: Machine, *, passive: bool, folder: str = "") -> tuple[Element, Meshes]:
    """Return the arm as an XML tree of MJCF, and its meshes.

    Args:
        machine: the machine.
        passive: see `arm_spec`.
        folder: folder of the meshes, as in `to_mjcf`.
    """
    arm, pieces = rigid_arm(machine), link_pieces(machine)
    meshes = Meshes((piece for of_link in pieces for piece in of_link), folder, engine=True)
    root = Element("mujoco", model=machine.name)
    SubElement(root, "compiler", angle="radian", autolimits="true")
    SubElement(root, "option", timestep=repr(STEP), gravity=format_numbers(arm.gravity))
    if passive:
        custom = SubElement(root, "custom")
        for name, joint in machine.joints.items():
            SubElement(custom, "numeric", name=f"{name}.working_stroke", data=repr(joint.stops.working_stroke))
    assets = SubElement(root, "asset") if meshes else root
    parent = SubElement(root, "worldbody")
    bodies = joint_pieces(machine)
    for name, link, drawn, body in zip(machine.joints, arm.links, pieces, bodies, strict=True):
        parent = _add_link(parent, name, link)
        hinge = SubElement(parent, "joint", name=name, type="hinge", axis=format_numbers(link.axis))
        if link.armature:
            hinge.set("armature", repr(link.armature))
        if passive:
            _make_passive(hinge, machine, name)
        for at, piece in enumerate(drawn):
            add_geom(parent, piece, assets, meshes, f"{name}-{at}", painted=passive)
        if passive:
            add_geom(parent, body, assets, meshes, f"{name}-{JOINT_BODY_NAME}", painted=True)
    payload = SubElement(parent, "body", name="payload", pos=format_numbers(arm.tool))
    SubElement(payload, "inertial", pos="0 0 0", mass=repr(float(machine.arm.payload)), diaginertia="0 0 0")
    SubElement(parent, "site", name="tip", pos=format_numbers(arm.tool), quat=format_numbers(quaternion(arm.tool_axes)))
    return root, meshes


def add_geom(parent: Element, piece: Piece, assets: Element, meshes: Meshes, name: str, *, painted: bool) -> None:
    """Add a piece as a geom that does not collide and has no mass, and its mesh to the assets.

    Bodies of joints are drawn larger by `JOINT_BODY_SCALE`.

    Args:
        parent: body of the geom.
        piece: the piece, in the frame of the body.
        assets: element of the meshes.
        meshes: names of the meshes.
        name: name of the geom, and of its mesh.
        painted: whether it has a colour.
    """
    larger = JOINT_BODY_SCALE if piece.of == "joint" else 1.0
    sizes: dict[str, Any] = {
        "capsule": lambda d, length: (0.5 * d, 0.5 * length),
        "cylinder": lambda d, length: (0.5 * larger * d, 0.5 * larger * length),
        "sphere": lambda d: (0.5 * d,),
        "box": lambda *edges: [0.5 * edge for edge in edges],
    }
    geom = {"name": name, "type": piece.kind, "contype": "0", "conaffinity": "0", "mass": "0"}
    if piece.file is None:
        geom["size"] = format_numbers(sizes[piece.kind](*piece.size))
    else:
        # MuJoCo places a mesh where its file has it. As a shell it may be flat or open, which MuJoCo refuses of a
        # solid, even where its mass is 0.
        scale = format_numbers(meshes.scale(piece))
        SubElement(assets, "mesh", name=name, file=meshes.name(piece.file), scale=scale, inertia="shell")
        geom["mesh"] = name
    geom |= {"pos": format_numbers(piece.position), "quat": format_numbers(quaternion(piece.axes))}
    SubElement(parent, "geom", geom | ({"rgba": format_numbers(COLOURS[piece.of])} if painted else {}))


def format_numbers(values: Iterable[float]) -> str:
    """Return numbers as text in full precision, separated by spaces."""
    return " ".join(repr(float(value)) for value in values)


def quaternion(axes: Array) -> Array:
    """Return the unit quaternion (w, x, y, z) of axes (3, 3), with w >= 0."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415  # SciPy takes long to import

    wxyz: Array = np.roll(Rotation.from_matrix(axes).as_quat(), 1)
    return wxyz if wxyz[0] >= 0.0 else -wxyz


def _add_link(parent: Element, name: str, link: RigidLink) -> Element:
    """Add the body of a rigid link to its parent, with its inertial; return the body."""
    body = SubElement(
        parent, "body", name=f"{name}-link", pos=format_numbers(link.place), quat=format_numbers(quaternion(link.axes))
    )
    inertial = SubElement(body, "inertial", pos=format_numbers(link.centre), mass=repr(link.mass))
    inertia = nearest_inertia(link.inertia)
    across = inertia[(0, 0, 1), (1, 2, 2)]
    if across.any():
        inertial.set("fullinertia", format_numbers([*inertia.diagonal(), *across]))
    else:
        inertial.set("diaginertia", format_numbers(inertia.diagonal()))
    return body


def _make_passive(hinge: Element, machine: Machine, name: str) -> None:
    """Give a hinge the joint's stroke, torque limit and friction, and its spring unless of constant torque."""
    joint = machine.joints[name]
    half, torque = joint.stops.mechanical_stroke / 2, max_supply_torque(machine, name)
    hinge.set("range", format_numbers([-half, half]))
    hinge.set("actuatorfrcrange", format_numbers([-torque, torque]))
    hinge.set("frictionloss", repr(joint.brake.torque))
    hinge.set("damping", repr(joint.brake.viscous))
    if joint.spring is not None and joint.spring.stiffness > 0.0:
        hinge.set("stiffness", repr(joint.spring.stiffness))
        hinge.set("springref", repr(joint.spring.torque / joint.spring.stiffness))
