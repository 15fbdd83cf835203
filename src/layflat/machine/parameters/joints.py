"""Joints as a whole, and the angles that they reach."""

from __future__ import annotations

from math import degrees, radians

import numpy as np

from layflat.errors import MachineError
from layflat.machine import parts
from layflat.machine.model import Machine
from layflat.machine.parameters.drives import drive_parts, sensor
from layflat.machine.parameters.hoses import full_travel, hose, long_stroke, no_hose
from layflat.physics.joint import Joint
from layflat.physics.stop import Stops
from layflat.physics.valves import VALVES


def joints(machine: Machine) -> tuple[Joint, ...]:
    """All laws of every joint, from base to tip; all with strokes of one kind, so that they can go side by side."""
    even = all(described.output.kind == "cam" for described in machine.joints.values())
    return tuple(_joint(machine, described, even=even) for described in machine.joints.values())


def _joint(machine: Machine, described: parts.Joint, *, even: bool) -> Joint:
    valve_part, angle_sensor, pressure_sensor = drive_parts(machine)
    pulling = hose(described)
    pushing = pulling if described.acting == "double" else no_hose(pulling)
    if not even:
        pulling, pushing = (h._replace(stroke=long_stroke(h.stroke)) for h in (pulling, pushing))
    return Joint(
        pulling,
        pushing,
        VALVES.parameters(valve_part),
        stops(described),
        described.brake.viscous,
        described.brake.torque,
        sensor(angle_sensor),
        sensor(pressure_sensor),
    )


def stops(joint: parts.Joint) -> Stops:
    """End stops on both sides; squeezing begins where the opposite hose is collapsed."""
    limit = joint.stops.mechanical_stroke / 2
    squeeze = np.minimum(full_travel(joint) / 2, limit)
    return Stops(squeeze, joint.stops.squeeze_stiffness, limit, joint.stops.stop_stiffness, joint.stops.stop_damping)


def check_inside_stroke(machine: Machine, name: str, angle: float, where: str) -> float:
    """An angle (rad) that the joint can reach.

    Raises:
        MachineError: it lies outside the working stroke.
    """
    half = machine.joint[name].stops.working_stroke / 2
    if not abs(angle) <= half + radians(1e-9):
        raise MachineError(
            f"{degrees(angle):.6g} deg is outside the working stroke of joint {name!r}",
            where=where,
            right=f"stay within +-{degrees(half):.6g} deg",
        )
    return angle
