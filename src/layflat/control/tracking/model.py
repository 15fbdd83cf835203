"""The model of the plant: its own laws in long steps, with valves as they are on average.

| symbol | meaning | unit |
|---|---|---|
| q, v | joint angle and velocity | rad, rad/s |
| dp | differential pressure, hose A less hose B | Pa |
| T | time since the last cycle | s |

Its steps are short enough for what is light to oscillate on its air: steps of more than two radians of an oscillation
would make it grow without limit, and so would damping that takes more than twice a velocity in a step (see
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
    FILLED,
    AirTaken,
    HoseState,
    Joint,
    JointState,
    Motion,
    Surroundings,
    has_second,
    joint_at_rest,
)
from layflat.physics.natural_rates import natural_rates
from layflat.physics.plant import advance, together
from layflat.physics.stops_and_springs import stop_damping, stop_torque
from layflat.physics.valves import start_wave, weaken_wave

STEP = 2.5e-3  # longest of the model, s
MAX_PHASE, MAX_DECAY = 1.0, 1.0  # of an oscillation, rad, and of a velocity, in a step: half of what would grow
MAX_DOUBLINGS = 5  # of the number of steps: a model that needed more would take longer than a control cycle


def step_count(arm: Any, joints: tuple[Joint, ...], around: Surroundings, cycle: float) -> int:
    """Return the number of the model's steps in a control cycle (s): as `STEP` needs, or doubled for what is light.

    Args:
        arm: parameters of its kind; as all of these, with arrays where runs differ: the lightest counts.
        joints: parameters, an item a joint.
        around: supply and surroundings.
        cycle: s.
    """
    usual = ceil(cycle / STEP - 1e-9)
    frequency, decay = natural_rates(arm, joints, around)
    over = max(frequency / MAX_PHASE, decay / MAX_DECAY) * cycle / usual
    doublings = min(max(ceil(log2(max(over, 1e-9)) - 1e-9), 0), MAX_DOUBLINGS)
    return usual << doublings


class Plant(NamedTuple):
    """Parameters of the laws of an arm, its joints with valves on average, and what is around them."""

    arm: Any
    joints: tuple[Any, ...]
    around: Surroundings
    steps: tuple[float, ...]  # an item for every step of the model in a cycle
    late: tuple[float, ...]  # an item for every whole cycle that any command takes to its valve


class ObserverTuning(NamedTuple):
    """Trust in the model of a joint and in its sensors."""

    torque: float  # error of the model's torque, standard deviation, N m
    angle: float  # error of the sensor's angle, standard deviation, rad
    pressure: float  # share of a differential pressure's innovation that the model takes over
    notch: float  # weight of the last innovation beside now's and that before it: see `pressure_correction`


class Gains(NamedTuple):
    """Shares of an angle's innovation that a joint's model takes over in a cycle."""

    angle: float  # 1
    velocity: float  # to the velocity, 1/s


class Innovation(NamedTuple):
    """Innovations of the differential pressure in the last cycles, after their corrections, Pa."""

    last: float
    before: float


@law
def _with_air(hose, state, travel, change, p_a):
    # The hose at a travel and with a change of pressure, at its temperature.
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    p = max(state.pressure + change, p_a)
    stored, mass = energy(hose.chamber, p, volume, p_a), state.mass * p / state.pressure
    return HoseState(stored, mass, volume, p, state.pressure_change, state.mass_change, state.loss, state.line)


@law
def placed(joint, state, q, v, change, around):
    """Return the state of a joint at another angle and velocity, with its differential pressure changed."""
    p_a, of_second = around.ambient_pressure, 0.5 * has_second(joint.second)
    a = _with_air(joint.hose_a, state.hose_a, joint.hose_a.neutral + q, (1.0 - of_second) * change, p_a)
    b = _with_air(joint.hose_b, state.hose_b, joint.hose_b.neutral - q, -of_second * change, p_a)
    return JointState(Motion(q, v, state.motion.velocity_change), state.valve, a, b, state.ledger)


@law
def at_rest(joint, q, dp, around):
    """Return the state of a joint at rest, at what its sensors say; its pressures as equal leaks would leave them."""
    second = has_second(joint.second)
    p = second * (FILLED * around.supply_pressure) + (1.0 - second) * around.ambient_pressure
    state = joint_at_rest(joint, q, p + (1.0 - 0.5 * second) * dp, p - 0.5 * second * dp, around)
    return JointState(state.motion, state.valve, state.hose_a, state.hose_b, AirTaken(0.0))


@law
def gains_of(observer, inertia, T):
    """Return the steady gains of an observer of angle and velocity with errors of torque and sensor.

    Source: kalata1984, the tracking index of alpha-beta filters.
    """
    index = observer.torque * T * T / (inertia * observer.angle)
    root = 0.25 * (4.0 + index - sqrt(8.0 * index + index * index))
    alpha = 1.0 - root * root
    return Gains(alpha, (2.0 * (2.0 - alpha) - 4.0 * root) / T)


@law
def pressure_correction(observer, innovation, e):
    """Return by how much to change the differential pressure after an innovation e, and innovations to keep (Pa).

    The mean of e and of what it was half a period of the dither ago has none of the dither.
    """
    change = observer.pressure * (e + observer.notch * innovation.last + innovation.before) / (2.0 + observer.notch)
    return change, Innovation(e - change, innovation.last - change)


@law
def angle_of_state(state):
    """Return the angle of a joint, rad."""
    return state.motion.angle


@law
def gas_torque(joint, state, around):
    """Return the torque of the air in both hoses, N m."""
    a, b, q, p_a = state.hose_a, state.hose_b, state.motion.angle, around.ambient_pressure
    forward = torque_per_pressure(joint.hose_a.stroke, joint.hose_a.neutral + q) * (a.pressure - p_a)
    return forward - torque_per_pressure(joint.hose_b.stroke, joint.hose_b.neutral - q) * (b.pressure - p_a)


@law
def loss_torque(joint, state):
    """Return the torque of the losses in both hoses, against the motion, N m."""
    return total(torques(joint.hose_a.loss, state.hose_a.loss) + torques(joint.hose_b.loss, state.hose_b.loss))


@law
def opposing_torque(joint, state, around):
    """Return the torque against the motion but for dry friction: of losses, damping and stops, N m."""
    q, v, p_a = state.motion.angle, state.motion.velocity, around.ambient_pressure
    a, b = joint.hose_a.damping, joint.hose_b.damping
    damped = a.base + b.base + a.slope * max(state.hose_a.pressure - p_a, 0.0)
    damped = damped + b.slope * max(state.hose_b.pressure - p_a, 0.0)
    damped = damped + joint.viscous_friction + stop_damping(joint.stops, q)
    return loss_torque(joint, state) + damped * v - stop_torque(joint.stops, q)


@law
def _wave(joint, shares, T):
    return weaken_wave(joint.valve, start_wave(joint.valve, 0.0, T), shares.dither)


@composition
def a_cycle_later(plant, states, drives, shares, payload, T):
    """Return the states of the joints after a cycle in which drives act on them, with these `Shares`, tuples."""
    around, joined = plant.around, together(plant.arm, slots(plant.joints))
    carrying = Surroundings(
        around.supply_pressure, around.supply_temperature, around.ambient_pressure, around.ambient_temperature, payload
    )
    after, waves = slots(states), slots(each(_wave, plant.joints, shares, T))
    n = len(plant.steps)
    advance(plant.arm, joined, after, slots(drives), waves, carrying, T / n, n)
    return gather(states, after)
