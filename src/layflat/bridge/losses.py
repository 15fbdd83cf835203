"""Properties of an arm that a format of robots can't carry, or carries where few look."""

from collections.abc import Mapping

import numpy as np

from layflat.arrays import Array
from layflat.bridge.formats import nearest_inertia
from layflat.bridge.pieces import link_pieces, rigid
from layflat.bridge.urdf import unread_meshes
from layflat.machine import Machine

URDF, MJCF = ".urdf", ".xml"
NEGLIGIBLE = 1e-9  # change of an inertia that nobody is told of, as a share
USUAL_GRAVITY = (9.7, 9.9)  # m/s2 against z, which tools take where a file has none


def losses(machine: Machine, suffix: str) -> list[str]:
    """Return one line on each thing that a file of a format lacks of a machine's arm.

    Args:
        machine: whose arm is written.
        suffix: of the file: ".urdf" or ".xml" (MJCF).

    Raises:
        InputError: the arm is of a kind without bodies.
    """
    arm = rigid(machine)
    links = dict(zip(machine.joints, arm.links, strict=True))
    lines = []
    armature = {name: link.armature for name, link in links.items() if link.armature > 0.0}
    if armature and suffix == URDF:
        lines.append(
            f"URDF has no armature, so other tools miss it in the mass matrix: {_listed(armature, 'kg m2')}; "
            "layflat reads it back from <dynamics>, and MJCF (.xml) carries it"
        )
    springs = {name: joint.spring for name, joint in machine.joints.items() if joint.spring is not None}
    if springs and suffix == URDF:
        lines.append(f"URDF has no springs of joints: {', '.join(springs)}; MJCF (.xml) carries them")
    constant = {name: spring.torque for name, spring in springs.items() if spring.stiffness == 0.0 and spring.torque}
    if constant and suffix == MJCF:
        lines.append(f"MJCF has no spring of constant torque: {_listed(constant, 'N m')}; apply it as a force")
    if suffix == URDF and not _is_usual(arm.gravity):
        values = " ".join(f"{float(value):.6g}" for value in arm.gravity)
        lines.append(f"URDF has no gravity: MuJoCo reads {values} m/s2 from <mujoco>, other tools have to be told")
    unread = unread_meshes(link_pieces(machine)) if suffix == URDF else []
    if unread:
        lines.append(
            f"MuJoCo draws nothing of this URDF, as it reads no DAE and no flat mesh there: {', '.join(unread)}"
        )
    rounded = {name: _change(link.inertia) for name, link in links.items()}
    rounded = {name: change for name, change in rounded.items() if change > NEGLIGIBLE}
    if rounded:
        lines.append(
            f"inertia that rounding has made impossible is written as that of the nearest body, as MuJoCo allows no "
            f"other: links of {', '.join(f'{name} ({change:.1g} of it less)' for name, change in rounded.items())}"
        )
    return lines


def _listed(values: Mapping[str, float], unit: str) -> str:
    return ", ".join(f"{name} {value:.6g} {unit}" for name, value in values.items())


def _is_usual(gravity: Array) -> bool:
    x, y, z = gravity
    return bool(max(abs(x), abs(y)) < 1e-9 and USUAL_GRAVITY[0] < -z < USUAL_GRAVITY[1])


def _change(inertia: Array) -> float:
    return float(np.abs(nearest_inertia(inertia) - inertia).max() / np.abs(inertia).max())
