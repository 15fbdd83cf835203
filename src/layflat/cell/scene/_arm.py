"""A stand-in for `layflat.bridge.arm_spec`, with its contract: replace the import in scene.py by that call.

Two level hinges, named as the machine's joints, zero at mid-stroke; link n's body holds hinge n at its origin and lies
along its own x axis. Masses are those of machine/parameters/arms.py: gravity acts along z, on nothing that moves.
"""

from __future__ import annotations

from math import cos, sin
from typing import Any

from layflat.cell.extras import mujoco
from layflat.machine import Machine


def arm_spec(machine: Machine) -> Any:
    """An MjSpec of a level arm, without payload."""
    mj = mujoco()
    spec = mj.MjSpec()
    parent, place, turn = spec.worldbody, (0.0, 0.0, 0.0), 0.0
    for i, (name, joint) in enumerate(machine.joints.items()):
        link = joint.link
        body = parent.add_body(name=name, pos=place, quat=[cos(turn / 2), 0.0, 0.0, sin(turn / 2)])
        body.add_joint(name=name, type=mj.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
        body.explicitinertial = True
        body.mass = link.mass
        body.ipos = [link.centre, 0.0, 0.0]
        across = link.inertia + link.rotor_inertia
        body.inertia = [across, across, across]
        if i > 0:  # the second joint's housing is carried by the first link and does not turn with the second
            housing = parent.add_body(name=f"{name}-housing", pos=place)
            housing.explicitinertial = True
            housing.mass = joint.body.mass
            housing.ipos = [0.0, 0.0, 0.0]
            housing.inertia = [1e-9, 1e-9, 1e-9]
        parent, place, turn = body, (link.length, 0.0, 0.0), machine.arm.elbow
    return spec
