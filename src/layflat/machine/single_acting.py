"""Joints with a single hose, and the springs that bring them back or bear what an arm weighs."""

from layflat.arrays import Array
from layflat.machine.model import Machine
from layflat.physics.joint import SecondHose, TwoHoses
from layflat.physics.stops_and_springs import NoSpring, Spring, spring_torque


def springs(machine: Machine) -> list[NoSpring | Spring]:
    """Return the parameters of each joint's spring, all of one kind, so that joints can go side by side."""
    found = [joint.spring for joint in machine.joints.values()]
    if not any(found):
        return [NoSpring() for _ in found]
    return [Spring(of.torque, of.stiffness) if of else Spring(0.0, 0.0) for of in found]


def second_hoses(machine: Machine) -> list[TwoHoses | SecondHose]:
    """Return for each joint whether it has hose B, all of one kind, likewise."""
    double = [joint.acting == "double" for joint in machine.joints.values()]
    return [TwoHoses() if all(double) else SecondHose(float(one)) for one in double]


def needed_at_rest(machine: Machine, pulls: Array, angles: Array) -> Array:
    """Return the torques that hoses and friction have to give to an arm at rest, (points, joints), N m.

    Args:
        machine: whose springs help.
        pulls: torques that come of the angles, as gravity's (points, joints), N m.
        angles: of the joints, likewise, rad.
    """
    needed = -pulls
    for j, spring in enumerate(springs(machine)):
        needed[:, j] -= spring_torque(spring, angles[:, j])
    return needed
