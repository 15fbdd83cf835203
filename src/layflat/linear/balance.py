"""Balance of torques at an operating point: which joint lacks what, in one line."""

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.linear.rates import MovingJoint, PlantLaws
from layflat.machine import parameters
from layflat.physics.friction import slip_torques
from layflat.physics.hose import torque_per_pressure
from layflat.physics.joint import JointParameters, has_second
from layflat.physics.stops_and_springs import spring_torque

PRESSURE_TOLERANCE = 0.01  # error of the differential pressure of a sliding joint, fraction of the supply's gauge one


def hose_slopes(joint: JointParameters, angle: float) -> Array:
    """Return the torques by gauge pressure in hoses A and B (N m/Pa, (2,)) at an angle (rad), that of B below zero."""
    a, b = joint.hose_a, joint.hose_b
    slope_b = torque_per_pressure(b.stroke, b.neutral - angle) * has_second(joint.second)
    return np.array([torque_per_pressure(a.stroke, a.neutral + angle), -slope_b])


def static_torque(joint: JointParameters, state: MovingJoint, pull: float, ambient: float) -> float:
    """Return the torque of hoses, spring and gravity on a joint, which its friction holds, N m.

    Args:
        joint: parameters.
        state: its state.
        pull: torque of gravity, N m.
        ambient: absolute ambient pressure, Pa.
    """
    gauge = np.array([state.air_a.pressure, state.air_b.pressure]) - ambient
    return float(pull + spring_torque(joint.spring, state.angle) + hose_slopes(joint, state.angle) @ gauge)


def check_strength(names: list[str], plant: PlantLaws, angles: Array, velocities: Array) -> None:
    """Check that hoses at supply pressure carry gravity and springs, and friction where joints slide.

    Args:
        names: of the joints.
        plant: the plant.
        angles: of the joints, rad, (joints,).
        velocities: of the joints, rad/s, (joints,).

    Raises:
        InputError: naming the joint and the torque that it lacks.
    """
    around = plant.around
    _, pulls = parameters.mass_and_pull(plant.arm, around.payload, angles)
    for j, (name, joint) in enumerate(zip(names, plant.joints, strict=True)):
        q, v = float(angles[j]), float(velocities[j])
        gauge = around.supply_pressure - around.ambient_pressure
        K_a, K_b = hose_slopes(joint, q).tolist()
        need = -(float(pulls[j]) + spring_torque(joint.spring, q))
        if v:
            need += np.sign(v) * slip_torques(joint.friction, joint.brake_torque, v, v, (K_a - K_b) * 0.5 * gauge)[0]
        lacking = max(need - K_a * gauge, K_b * gauge - need)
        if lacking > 0.0:
            action = "slide" if v else "hold"
            raise InputError(
                f"joint {name!r} lacks {lacking:.3g} N m to {action}: the load takes {abs(need):.3g} N m",
                where="configuration",
                right="choose another, a smaller payload, or a higher supply pressure",
            )


def missing_torques(plant: PlantLaws, states: tuple[MovingJoint, ...], accelerations: Array) -> Array:
    """Return the torques that joints lack: to slide steadily, or to be held without friction, N m, (joints,).

    Args:
        plant: the plant.
        states: the joints' states.
        accelerations: of the joints, rad/s2, (joints,).
    """
    angles = np.array([state.angle for state in states])
    mass, pulls = parameters.mass_and_pull(plant.arm, plant.around.payload, angles)
    missing: Array = -mass @ np.where(plant.held, 0.0, accelerations)
    for j, (joint, state) in enumerate(zip(plant.joints, states, strict=True)):
        if plant.held[j]:
            missing[j] = -static_torque(joint, state, pulls[j], plant.around.ambient_pressure)
    return missing


def check_balance(names: list[str], plant: PlantLaws, states: tuple[MovingJoint, ...], missing: Array) -> None:
    """Check that given pressures carry the load of joints that slide, and with friction that of held ones.

    Args:
        names: of the joints.
        plant: the plant.
        states: the joints' states.
        missing: torques that they lack (see `missing_torques`), N m, (joints,).

    Raises:
        InputError: naming the joint, the torque that is missing, and the difference of pressures that carries the load.
    """
    around = plant.around
    for j, (name, joint, state) in enumerate(zip(names, plant.joints, states, strict=True)):
        slopes = hose_slopes(joint, state.angle)
        p = np.array([state.air_a.pressure, state.air_b.pressure])
        gauge = p - around.ambient_pressure
        tolerance = PRESSURE_TOLERANCE * (around.supply_pressure - around.ambient_pressure) * slopes[0]
        if plant.held[j]:
            pull = float(np.abs(slopes) @ gauge)
            tolerance += float(slip_torques(joint.friction, joint.brake_torque, 0.0, 0.0, pull)[1])
        if abs(missing[j]) > tolerance:
            difference = p[0] - p[1] + missing[j] / float(np.abs(slopes).mean() if slopes[1] else slopes[0])
            what = f"{abs(missing[j]):.3g} N m are missing at joint {name!r}"
            state_word = "be held" if plant.held[j] else "slide"
            right = f"to {state_word} it needs about {difference / 1e5 + 0.0:.3f} bar more in hose A than in hose B"
            raise InputError(what, where="pressures", right=right)
