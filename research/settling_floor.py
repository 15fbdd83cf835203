"""Lower bound of a step's settling time: rigid links with limited torques and rates of torque.

A linear program decides whether so many control cycles are enough. It is optimistic where the plant is not linear: the
mass matrix is that of the elbow angle, anywhere in the stroke, at which the step is over soonest; hoses have all of the
supply's pressure; air flows choked into the smaller volume and out of it; friction helps the arm to stop and never
hinders it. What velocities do to each other (Coriolis terms) is left out.

| symbol | meaning | unit |
|---|---|---|
| T | control cycle | s |
| q, v | angles of the joints less those at the goal, and velocities, at the end of each cycle | rad, rad/s |
| tau, f | torques of the air at the end of each cycle, and of friction during it | N m |
| M | mass matrix | kg m2 |
"""

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array

from layflat.arrays import Array
from layflat.experiments.beyond.search import Shooting
from layflat.machine import Joint as JointPart
from layflat.machine import Machine, parameters
from layflat.motion.kinematics import tip_position
from layflat.physics.air import GAMMA, GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.joint import REST_PRESSURE_RATIO, HoseParameters, JointParameters, Surroundings

ELBOW_ANGLES = 5  # number of angles of the last joint over its stroke
FIRST_CYCLES = 40  # number that is tried first
POLYGON_SIDES = 16  # of the polygon around the band
HOLD_CYCLES = 20  # for which the tip stays in its band
MAX_DAMPED_SPEED = 5.0  # up to which damping counts, rad/s


@dataclass(frozen=True)
class Actuator:
    """Limits that air and friction set to a joint.

    Args:
        torque: greatest, N m.
        rate: greatest change of the torque by the valve, N m/s.
        stiffness: with shut hoses, N m/rad.
        friction: dry, that of the hoses included, N m.
        damping: N m s/rad.
    """

    torque: float
    rate: float
    stiffness: float
    friction: float
    damping: float


@dataclass(frozen=True)
class Motion:
    """Step of joints with such limits.

    Args:
        mass: M, (joints, joints), kg m2.
        actuators: an item a joint.
        way: q at the start, (joints,), rad.
        sides: of a polygon about the goal: distances of the tip by q, (sides, joints), m/rad.
        band: greatest distance to which the tip is to come, m.
        cycle: T, s.
    """

    mass: Array
    actuators: Sequence[Actuator]
    way: Array
    sides: Array
    band: float
    cycle: float


def is_enough(motion: Motion, cycles: int) -> bool:
    """Return whether the tip can stay in its band after so many cycles: whether a linear program is feasible.

    Its unknowns are q, v, tau and f of all cycles. Friction may only help against the way.
    """
    n, K, T = len(motion.actuators), cycles + HOLD_CYCLES, motion.cycle
    one, none = np.identity(n * K), np.zeros((n * K, n * K))
    before = np.eye(n * K, k=-n)
    push = np.kron(np.identity(K), T * np.linalg.inv(motion.mass))
    torque, rate, stiffness, friction, damping = (np.tile(each, K) for each in _columns(motion.actuators))
    onward = np.tile(-np.sign(motion.way), K)
    late = np.eye(HOLD_CYCLES + 1, K, k=cycles - 1)
    near = np.kron(late, motion.sides)
    moved = np.hstack([one - before, -0.5 * T * (one + before), none, none])
    pushed = np.hstack([none, one - before, -push, -push])
    changed = np.hstack([none, np.diag(T * stiffness), one - before, none])
    rubbed = np.hstack([none, np.diag(-onward * damping), none, np.diag(-onward)])
    stays = np.hstack([near, np.zeros((len(near), 3 * n * K))])
    most = friction + MAX_DAMPED_SPEED * damping
    limits = np.concatenate([T * rate, T * rate, friction, np.full(len(near), motion.band)])
    start = np.concatenate([motion.way, np.zeros(2 * n * K - n)])
    bounds = np.concatenate([np.full(2 * n * K, np.inf), torque, most])
    found = milp(
        np.zeros(4 * n * K),
        constraints=[
            LinearConstraint(csr_array(np.vstack([changed, -changed, rubbed, stays])), -np.inf, limits),
            LinearConstraint(csr_array(np.vstack([moved, pushed])), start, start),
        ],
        bounds=Bounds(-bounds, bounds),
    )
    return bool(found.status == 0)


def _columns(actuators: Sequence[Actuator]) -> Array:
    """Return parameters of the actuators, a row each, (5, joints)."""
    return np.array([[a.torque, a.rate, a.stiffness, a.friction, a.damping] for a in actuators]).T


def settling_floor(shooting: Shooting, band: float) -> float:
    """Return a lower bound of the time after which the tip can stay within its band, s.

    Args:
        shooting: the step.
        band: of the tip, m.
    """
    machine = shooting.machine
    actuators = _actuators(shooting)
    stroke = list(machine.joints.values())[-1].stops.working_stroke
    elbows = np.linspace(-0.5, 0.5, ELBOW_ANGLES) * stroke if len(actuators) > 1 else np.zeros(1)
    way = np.subtract(shooting.start, shooting.end)
    sides = _sides(machine, np.array(shooting.end))
    motions = [Motion(mass_matrix(machine, q), actuators, way, sides, band, machine.cycle) for q in elbows.tolist()]
    few, cycles = 0, FIRST_CYCLES
    while not any(is_enough(motion, cycles) for motion in motions):
        few, cycles = cycles, 2 * cycles
    for motion in motions:
        if cycles > few + 1 and is_enough(motion, cycles - 1):
            cycles = bisect_left(range(cycles), True, lo=few + 1, key=partial(is_enough, motion))
    return cycles * machine.cycle


def _sides(machine: Machine, q: Array) -> Array:
    """Return derivatives of the tip's distances from a goal in all directions by the angles, (sides, joints), m/rad."""
    small = 1e-5 * np.identity(len(q))
    jacobian = (tip_position(machine, q + small) - tip_position(machine, q - small)).T / 2e-5
    angles = 2.0 * np.pi * np.arange(POLYGON_SIDES) / POLYGON_SIDES
    return np.stack([np.cos(angles), np.sin(angles)], axis=1) @ jacobian


def _actuators(shooting: Shooting) -> list[Actuator]:
    machine = shooting.machine
    joints, around = parameters.joints(machine), parameters.surroundings(machine)
    parts, ends = machine.joints.values(), zip(shooting.start, shooting.end, strict=True)
    return [actuator(*each, around) for each in zip(parts, joints, ends, strict=True)]


def actuator(
    described: JointPart, joint: JointParameters, angles: tuple[float, float], around: Surroundings
) -> Actuator:
    """Return the widest limits of a joint between two angles, rad."""
    p_s, p_a = around.supply_pressure, around.ambient_pressure
    hoses = [(hose, hose.neutral + sign * q) for hose, sign in ((joint.hose_a, 1), (joint.hose_b, -1)) for q in angles]
    K = max(torque_per_pressure(hose.stroke, travel) for hose, travel in hoses)
    volumes = [_volume(hose, travel, REST_PRESSURE_RATIO * p_s) for hose, travel in hoses]
    fed = joint.valve.conductance * (REFERENCE_DENSITY * GAS_CONSTANT * REFERENCE_TEMPERATURE)
    a, b = joint.hose_a.damping, joint.hose_b.damping
    return Actuator(
        torque=K * (p_s - p_a),
        rate=2.0 * GAMMA * K * fed * p_s / min(volumes),
        stiffness=2.0 * GAMMA * K * K * REST_PRESSURE_RATIO * p_s / float(np.mean(volumes)),
        friction=joint.brake_torque + parameters.loss_fraction(described) * K * (p_s - p_a),
        damping=joint.viscous_friction + a.base + b.base + (a.slope + b.slope) * (p_s - p_a),
    )


def _volume(hose: HoseParameters, travel: float, p: float) -> float:
    """Return the effective volume of air in a hose, with the compliance of its wall, m3."""
    return float(hose.chamber.dead_volume + swept_volume(hose.stroke, travel) + GAMMA * hose.chamber.compliance * p)


def mass_matrix(machine: Machine, elbow: float) -> Array:
    """Return the mass matrix with the last joint at an angle (rad), (joints, joints), kg m2."""
    q = (*[0.0] * (len(machine.joints) - 1), elbow)
    return parameters.mass_and_pull(parameters.arm(machine), machine.arm.payload, q)[0]
