"""The controller's model of the plant: the plant's own laws in long steps, with valves averaged over the dither.

| symbol | meaning | unit |
|---|---|---|
| q, v | joint angle and velocity | rad, rad/s |
| dp | differential pressure, hose A less hose B | Pa |
| T | time since the last cycle | s |

Its steps are short enough for the natural oscillations of light joints on their air: with more than two radians of an
oscillation in a step, or a damping that takes away more than twice the velocity, the motion would diverge (see
docs/derivations.md).
"""

from math import ceil, log2, sqrt
from typing import Any, NamedTuple

from layflat.jit import composition, law
from layflat.lanes import each, gather, slots, total
from layflat.physics.chamber import energy
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.hysteresis import torques
from layflat.physics.joint import (
    REST_PRESSURE_RATIO,
    AirLedger,
    HoseState,
    JointMotion,
    JointParameters,
    JointState,
    Surroundings,
    has_second,
    joint_at_rest,
)
from layflat.physics.natural_rates import natural_rates
from layflat.physics.plant import advance_arm, pack_joints
from layflat.physics.stops_and_springs import stop_damping, stop_torque
from layflat.physics.valves import start_wave, weaken_wave

MAX_MODEL_STEP = 2.5e-3  # s
MAX_PHASE, MAX_DECAY = 1.0, 1.0  # of an oscillation (rad) and of a velocity in a step: half the stability limit
MAX_DOUBLINGS = 5  # of the number of steps: with more, the model would take longer than a control cycle


def step_count(arm: Any, joints: tuple[JointParameters, ...], around: Surroundings, cycle: float) -> int:
    """Return the number of the model's steps in a control cycle, doubled as often as light joints need for stability.

    It is doubled `MAX_DOUBLINGS` times at most.

    Args:
        arm: parameters of its kind; here and below with arrays where runs differ: the fastest oscillation counts.
        joints: parameters, an item per joint.
        around: supply and surroundings.
        cycle: control cycle, s.
    """
    usual = ceil(cycle / MAX_MODEL_STEP - 1e-9)
    frequency, decay = natural_rates(arm, joints, around)
    over = max(frequency / MAX_PHASE, decay / MAX_DECAY) * cycle / usual
    doublings = min(max(ceil(log2(max(over, 1e-9)) - 1e-9), 0), MAX_DOUBLINGS)
    return usual << doublings


class PlantModel(NamedTuple):
    """Parameters of the model of an arm, its joints with averaged valves, and its surroundings."""

    arm: Any
    joints: tuple[Any, ...]
    around: Surroundings
    steps: tuple[float, ...]  # an item for every step of the model in a cycle
    late: tuple[float, ...]  # an item for every whole cycle of the longest delay between command and valve


class ObserverTuning(NamedTuple):
    """Errors of a joint's model and sensors, from which the observer's gains follow."""

    torque: float  # standard deviation of the model's torque, N m
    angle: float  # standard deviation of the sensor's angle, rad
    pressure: float  # gain of the differential pressure's innovation, 0..1
    notch: float  # weight of the last innovation in the notch filter of `correct_pressure`


class ObserverGains(NamedTuple):
    """Gains of the observer of a joint, per innovation of its angle."""

    angle: float  # 1
    velocity: float  # 1/s


class PressureInnovations(NamedTuple):
    """Innovations of the differential pressure in the last two cycles, after their corrections, Pa."""

    last: float  # Pa
    before: float  # Pa


@law
def _place_hose(hose, state, travel, change, p_a):
    """Return a hose's state at another travel (rad), its pressure changed by `change` (Pa) to p_a or more.

    The air's temperature stays.
    """
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    p = max(state.pressure + change, p_a)
    stored, mass = energy(hose.chamber, p, volume, p_a), state.mass * p / state.pressure
    return HoseState(stored, mass, volume, p, state.pressure_change, state.mass_change, state.loss, state.line)


@law
def place_joint(joint, state, q, v, change, around):
    """Return the state of a joint at another angle q and velocity v, its differential pressure changed (Pa).

    Half of the change is added in hose A and taken off in hose B; without hose B, all of it is in hose A. No pressure
    falls below ambient, so that the change may be smaller. The air's temperature stays.
    """
    p_a, of_second = around.ambient_pressure, 0.5 * has_second(joint.second)
    a = _place_hose(joint.hose_a, state.hose_a, joint.hose_a.neutral + q, (1.0 - of_second) * change, p_a)
    b = _place_hose(joint.hose_b, state.hose_b, joint.hose_b.neutral - q, -of_second * change, p_a)
    return JointState(JointMotion(q, v, state.motion.velocity_change), state.valve, a, b, state.ledger)


@law
def at_rest(joint, q, dp, around):
    """Return the state of a joint at rest at its sensors' readings q and dp.

    The mean of both pressures is that of equal leaks; without hose B, hose A has ambient pressure and dp.
    """
    second = has_second(joint.second)
    p = second * (REST_PRESSURE_RATIO * around.supply_pressure) + (1.0 - second) * around.ambient_pressure
    state = joint_at_rest(joint, q, p + (1.0 - 0.5 * second) * dp, p - 0.5 * second * dp, around)
    return JointState(state.motion, state.valve, state.hose_a, state.hose_b, AirLedger(0.0))


@law
def observer_gains(observer, inertia, T):
    """Return the steady-state gains of an alpha-beta observer of angle and velocity.

    Source: kalata1984, the tracking index of alpha-beta filters.

    Args: `ObserverTuning`; inertia of the joint, kg m2; T.
    """
    index = observer.torque * T * T / (inertia * observer.angle)
    root = 0.25 * (4.0 + index - sqrt(8.0 * index + index * index))
    alpha = 1.0 - root * root
    return ObserverGains(alpha, (2.0 * (2.0 - alpha) - 4.0 * root) / T)


@law
def correct_pressure(observer, innovation, e):
    """Return the correction of the differential pressure, Pa, by an innovation e, and the next `innovation`.

    The latter is `PressureInnovations`: e and the last one, each less the correction. A notch filter over three
    innovations, with zero gain at the dither frequency, removes the dither from them.
    """
    change = observer.pressure * (e + observer.notch * innovation.last + innovation.before) / (2.0 + observer.notch)
    return change, PressureInnovations(e - change, innovation.last - change)


@law
def joint_angle(state):
    """Return the angle of a joint, rad."""
    return state.motion.angle


@law
def gas_torque(joint, state, around):
    """Return the torque of the air on the joint, N m: forward by hose A, less that by hose B."""
    a, b, q, p_a = state.hose_a, state.hose_b, state.motion.angle, around.ambient_pressure
    forward = torque_per_pressure(joint.hose_a.stroke, joint.hose_a.neutral + q) * (a.pressure - p_a)
    return forward - torque_per_pressure(joint.hose_b.stroke, joint.hose_b.neutral - q) * (b.pressure - p_a)


@law
def loss_torque(joint, state):
    """Return the torque of the losses in both hoses, against the motion, N m."""
    return total(torques(joint.hose_a.loss, state.hose_a.loss) + torques(joint.hose_b.loss, state.hose_b.loss))


@law
def opposing_torque(joint, state, around):
    """Return the torque against the motion of losses, damping and stops, without dry friction, N m."""
    q, v, p_a = state.motion.angle, state.motion.velocity, around.ambient_pressure
    a, b = joint.hose_a.damping, joint.hose_b.damping
    damping = a.base + b.base + a.slope * max(state.hose_a.pressure - p_a, 0.0)
    damping = damping + b.slope * max(state.hose_b.pressure - p_a, 0.0)
    damping = damping + joint.viscous_friction + stop_damping(joint.stops, q)
    return loss_torque(joint, state) + damping * v - stop_torque(joint.stops, q)


@law
def _wave(joint, shares, T):
    return weaken_wave(joint.valve, start_wave(joint.valve, 0.0, T), shares.dither)


@composition
def simulate_model_cycle(plant, states, drives, shares, payload, T):
    """Return the states of the joints after a control cycle, simulated by the model.

    Args: `PlantModel`; states, `Drive`s and mean `DriveFractions` of the joints, tuples; payload, kg; T.
    """
    around, joined = plant.around, pack_joints(plant.arm, slots(plant.joints))
    carrying = Surroundings(
        around.supply_pressure, around.supply_temperature, around.ambient_pressure, around.ambient_temperature, payload
    )
    after, waves = slots(states), slots(each(_wave, plant.joints, shares, T))
    n = len(plant.steps)
    advance_arm(plant.arm, joined, after, slots(drives), waves, carrying, T / n, n)
    return gather(states, after)
