"""A described chain as rigid bodies."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from layflat.physics.arms.bodies import RigidArm, RigidLink, lumped, moments, point, turned_by
from layflat.physics.arms.chain.description import ChainPart, six_moments


def bodies(described: ChainPart, joints: Sequence[Any]) -> RigidArm:
    """Return the arm as rigid bodies, without payload; each link has rotor and body of the next joint in its mass."""
    parts = [described.link[name] for name in described.joints]
    carries = described.bodies == "carried"
    loads = [(joint.body.mass if carries else 0.0) for joint in joints[1:]] + [0.0]
    ends = [part.place for part in parts[1:]] + [described.tool]
    links = []
    for part, carried, end in zip(parts, loads, ends, strict=True):
        axis = np.array(part.axis, float) / np.linalg.norm(part.axis)
        own = part.mass, np.array(part.centre, float), moments(six_moments(part.inertia))
        # The rotor is a thin disk about the axis; as it has no mass of its own, it may be anywhere.
        disk = 0.5 * part.rotor_inertia * (np.eye(3) + np.outer(axis, axis))
        mass, centre, inertia = lumped([own, point(carried, end), (0.0, np.zeros(3), disk)])
        place, axes = np.array(part.place, float), turned_by(part.turn)
        links.append(RigidLink(place, axes, axis, mass, centre, inertia, part.armature, part.shapes))
    gravity = np.array(described.gravity, float)
    return RigidArm(tuple(links), np.array(described.tool, float), turned_by(described.tool_turn), gravity)
