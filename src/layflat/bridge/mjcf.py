"""A machine's arm as MJCF, with every digit that its bodies have."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from layflat.arrays import Array
from layflat.bridge.formats import effort, nearest_inertia
from layflat.bridge.meshes import Meshes
from layflat.bridge.pieces import BODY, COLOURS, Piece, joint_pieces, link_pieces, rigid
from layflat.machine import Machine, load
from layflat.physics.arms.bodies import RigidLink
from layflat.physics.step import STEP

IN_FRONT = 1.01  # bodies of joints are drawn so much larger, so that they are seen where links are described with them


def to_mjcf(machine: str | Path | Machine, folder: str = "") -> str:
    """Return the arm as MJCF, for use without our joints: with stops, bearings, brakes and torques, drawn whole.

    Args:
        machine: whose arm it is.
        folder: where its meshes are, relative to the text's file (see `save_arm`); default: NAME-meshes.

    Raises:
        InputError: the arm is of a kind without bodies, or a mesh is not there.
    """
    machine = load(machine)
    return text_of(arm_tree(machine, passive=True, folder=folder or f"{machine.name}-meshes")[0])


def text_of(root: Element) -> str:
    """Return a tree as text."""
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def arm_tree(machine: Machine, *, passive: bool, folder: str = "") -> tuple[Element, Meshes]:
    """Return the arm as MJCF's elements, and the meshes that it is drawn by (see `arm_spec`, `to_mjcf`)."""
    arm, pieces = rigid(machine), link_pieces(machine)
    meshes = Meshes((piece for own in pieces for piece in own), folder, engine=True)
    root = Element("mujoco", model=machine.name)
    SubElement(root, "compiler", angle="radian", autolimits="true")
    SubElement(root, "option", timestep=repr(STEP), gravity=numbers(arm.gravity))
    if passive:
        custom = SubElement(root, "custom")
        for name, joint in machine.joints.items():
            SubElement(custom, "numeric", name=f"{name}.working_stroke", data=repr(joint.stops.working_stroke))
    assets = SubElement(root, "asset") if meshes else root
    parent = SubElement(root, "worldbody")
    bodies = joint_pieces(machine)
    for name, link, drawn, body in zip(machine.joints, arm.links, pieces, bodies, strict=True):
        parent = _link(parent, name, link)
        hinge = SubElement(parent, "joint", name=name, type="hinge", axis=numbers(link.axis))
        if link.armature:
            hinge.set("armature", repr(link.armature))
        if passive:
            _make_passive(hinge, machine, name)
        for at, piece in enumerate(drawn):
            add_geom(parent, piece, assets, meshes, f"{name}-{at}", painted=passive)
        if passive:
            add_geom(parent, body, assets, meshes, f"{name}-{BODY}", painted=True)
    payload = SubElement(parent, "body", name="payload", pos=numbers(arm.tool))
    SubElement(payload, "inertial", pos="0 0 0", mass=repr(float(machine.arm.payload)), diaginertia="0 0 0")
    SubElement(parent, "site", name="tip", pos=numbers(arm.tool), quat=numbers(quaternion(arm.tool_axes)))
    return root, meshes


def add_geom(parent: Element, piece: Piece, assets: Element, meshes: Meshes, name: str, *, painted: bool) -> None:
    """Add a piece that is drawn and touches nothing."""
    larger = IN_FRONT if piece.of == "joint" else 1.0
    sizes: dict[str, Any] = {
        "capsule": lambda d, length: (0.5 * d, 0.5 * length),
        "cylinder": lambda d, length: (0.5 * larger * d, 0.5 * larger * length),
        "sphere": lambda d: (0.5 * d,),
        "box": lambda *edges: [0.5 * edge for edge in edges],
    }
    geom = {"name": name, "type": piece.kind, "contype": "0", "conaffinity": "0", "mass": "0"}
    if piece.file is None:
        geom["size"] = numbers(sizes[piece.kind](*piece.size))
    else:
        # Of a mesh's own only where it lies counts: MuJoCo puts it where its file has it.
        # A shell may be flat or open; MuJoCo refuses such a solid, even where its mass is 0.
        scale = numbers(meshes.scale(piece))
        SubElement(assets, "mesh", name=name, file=meshes.name(piece.file), scale=scale, inertia="shell")
        geom["mesh"] = name
    geom |= {"pos": numbers(piece.place), "quat": numbers(quaternion(piece.axes))}
    SubElement(parent, "geom", geom | ({"rgba": numbers(COLOURS[piece.of])} if painted else {}))


def numbers(values: Iterable[float]) -> str:
    """Return numbers as text, with all their digits."""
    return " ".join(repr(float(value)) for value in values)


def quaternion(axes: Array) -> Array:
    """Return the unit quaternion (w, x, y, z) of axes (3, 3)."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415  # SciPy takes long to import

    found: Array = np.roll(Rotation.from_matrix(axes).as_quat(), 1)
    return found if found[0] >= 0.0 else -found


def _link(parent: Element, name: str, link: RigidLink) -> Element:
    body = SubElement(parent, "body", name=f"{name}-link", pos=numbers(link.place), quat=numbers(quaternion(link.axes)))
    own = SubElement(body, "inertial", pos=numbers(link.centre), mass=repr(link.mass))
    inertia = nearest_inertia(link.inertia)
    across = inertia[(0, 0, 1), (1, 2, 2)]
    if across.any():
        own.set("fullinertia", numbers([*inertia.diagonal(), *across]))
    else:
        own.set("diaginertia", numbers(inertia.diagonal()))
    return body


def _make_passive(hinge: Element, machine: Machine, name: str) -> None:
    joint = machine.joints[name]
    half, torque = joint.stops.mechanical_stroke / 2, effort(machine, name)
    hinge.set("range", numbers([-half, half]))
    hinge.set("actuatorfrcrange", numbers([-torque, torque]))
    hinge.set("frictionloss", repr(joint.brake.torque))
    hinge.set("damping", repr(joint.brake.viscous))
    if joint.spring is not None and joint.spring.stiffness > 0.0:
        hinge.set("stiffness", repr(joint.spring.stiffness))
        hinge.set("springref", repr(joint.spring.torque / joint.spring.stiffness))
