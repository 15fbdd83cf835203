"""One joint: two hoses that work against each other, their valve, the losses and the stops; and its half of a step.

A step of h seconds goes drift (h/2) - kick (h) - drift (h/2). In the middle the angle stands still: air flows, and all
torques are gathered; then the arm (see plant.py) finds the new velocities, its brakes included, and the joint drifts on.
The first drift does the air's work implicitly, the second explicitly: together they are symmetric in time, hence of
second order. Air flow, damping and Coriolis terms are evaluated once, at pressures and velocities led by half of
their last change.

| symbol | meaning | unit |
|---|---|---|
| q, v | joint angle and velocity | rad, rad/s |
| h | step | s |
"""

from typing import NamedTuple

from layflat.jit import law
from layflat.physics.chamber import (
    Chamber,
    air_mass,
    energy,
    pressure_after_swelling,
    pressure_rise,
    temperature,
    wall_heat,
)
from layflat.physics.hose import Stroke, swept_volume, torque_per_pressure
from layflat.physics.loss import Loss, slip_all
from layflat.physics.sensor import Sensor
from layflat.physics.spool import advance_spool
from layflat.physics.stop import Stops, stop_damping, stop_torque
from layflat.physics.valve import Valve, chamber_flow


class Hose(NamedTuple):
    """Parameters of a hose in its joint; `neutral` is its travel at joint angle zero (rad)."""

    stroke: Stroke
    chamber: Chamber
    loss: Loss
    neutral: float


class Joint(NamedTuple):
    """Parameters of a joint; hose A turns it forward, hose B back."""

    hose_a: Hose
    hose_b: Hose
    valve: Valve
    stops: Stops
    viscous_friction: float
    brake_torque: float
    angle_sensor: Sensor
    pressure_sensor: Sensor


class Surroundings(NamedTuple):
    """What the joints share: absolute pressures (Pa), temperatures (K), payload (kg)."""

    supply_pressure: float
    supply_temperature: float
    ambient_pressure: float
    ambient_temperature: float
    payload: float


class Drive(NamedTuple):
    """What acts on a joint during one control cycle."""

    opening: float
    """Opening asked of the valve, without dither, -1..1."""
    brake_torque: float
    """Torque at which the brake slips, N m."""
    load_torque: float
    """External torque on the joint, N m."""


class HoseState(NamedTuple):
    """Energy (J), mass (kg), geometric volume (m3), pressure (Pa), last changes of both, element torques (N m)."""

    energy: float
    mass: float
    volume: float
    pressure: float
    pressure_change: float
    mass_change: float
    loss_1: float
    loss_2: float
    loss_3: float


class JointState(NamedTuple):
    """Motion, spool, both hoses, and the ledger of works since the start (J) and of air taken from the supply (kg)."""

    angle: float
    velocity: float
    velocity_change: float
    spool: float
    spool_rate: float
    hose_a: HoseState
    hose_b: HoseState
    gas_work: float
    load_work: float
    hose_work: float
    brake_heat: float
    damping_heat: float
    air_taken: float


class Middle(NamedTuple):
    """A joint in the middle of a step: angle held, air and spool already moved on, torques gathered."""

    angle: float
    velocity: float
    spool: float
    spool_rate: float
    hose_a: HoseState
    hose_b: HoseState
    gas_torque: float
    loss_torque: float
    torque: float
    damping: float
    air_taken: float


@law
def hose_at_rest(hose, travel, p, T, p_a):
    """State of a hose at a travel (rad), pressure (Pa) and temperature (K)."""
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    stored = energy(hose.chamber, p, volume, p_a)
    return HoseState(stored, air_mass(hose.chamber, p, T, volume, p_a), volume, p, 0.0, 0.0, 0.0, 0.0, 0.0)


@law
def joint_at_rest(joint, q, p_1, p_2, around):
    """State of a joint at rest at angle q (rad) with absolute pressures p_1 in hose A and p_2 in hose B (Pa)."""
    T, p_a = around.ambient_temperature, around.ambient_pressure
    a = hose_at_rest(joint.hose_a, joint.hose_a.neutral + q, p_1, T, p_a)
    b = hose_at_rest(joint.hose_b, joint.hose_b.neutral - q, p_2, T, p_a)
    return JointState(q, 0.0, 0.0, 0.0, 0.0, a, b, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@law
def _breathe(hose, state, travel, turn, valve, x, around, h):
    """Swell to the middle's volume, then let air and heat flow for h: the new state, its mean pressure, air taken."""
    p_a = around.ambient_pressure
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    swell = volume - state.volume
    p_0 = pressure_after_swelling(hose.chamber, state.energy, volume, swell, p_a)
    p = p_0 + 0.5 * state.pressure_change
    m = state.mass + 0.5 * state.mass_change
    T = temperature(hose.chamber, p, m, volume, p_a)
    flow, heat, taken = chamber_flow(
        valve, x, p, T, around.supply_pressure, around.supply_temperature, around.ambient_pressure
    )
    heat = heat + wall_heat(hose.chamber, T, around.ambient_temperature)
    stored = state.energy - p_0 * swell + h * heat
    p_1 = p_0 + pressure_rise(hose.chamber, p_0, h * heat, volume, p_a)
    mean = 0.5 * (p_0 + p_1)
    f_1, f_2, f_3 = slip_all(hose.loss, state.loss_1, state.loss_2, state.loss_3, turn, mean - p_a)
    change = h * flow
    after = HoseState(stored, state.mass + change, volume, p_1, p_1 - p_0, change, f_1, f_2, f_3)
    return after, mean - p_a, h * taken


@law
def middle(joint, state, opening, around, h):
    """First half of a step: drift to the middle, move the spool, let the air flow, gather the torques."""
    q = state.angle + 0.5 * h * state.velocity
    v = state.velocity + 0.5 * state.velocity_change
    x, rate = advance_spool(joint.valve.spool, opening, state.spool, state.spool_rate, h)
    x_mean = 0.5 * (state.spool + x)
    # The elements follow the angle from middle to middle: their last turn ended half a step before this one began.
    turn = h * state.velocity
    s_a, s_b = joint.hose_a.neutral + q, joint.hose_b.neutral - q
    a, p_a, taken_a = _breathe(joint.hose_a, state.hose_a, s_a, turn, joint.valve, x_mean, around, h)
    b, p_b, taken_b = _breathe(joint.hose_b, state.hose_b, s_b, turn, joint.valve, -x_mean, around, h)
    gas = torque_per_pressure(joint.hose_a.stroke, s_a) * p_a - torque_per_pressure(joint.hose_b.stroke, s_b) * p_b
    loss = a.loss_1 + a.loss_2 + a.loss_3 + b.loss_1 + b.loss_2 + b.loss_3
    damping = joint.viscous_friction + stop_damping(joint.stops, q)
    torque = gas - loss + stop_torque(joint.stops, q) - damping * v
    return Middle(q, v, x, rate, a, b, gas, loss, torque, damping, taken_a + taken_b)


@law
def _swell(hose, state, travel):
    """Second drift of a hose: its air works at the pressure of the middle."""
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    return HoseState(
        state.energy - state.pressure * (volume - state.volume),
        state.mass,
        volume,
        state.pressure,
        state.pressure_change,
        state.mass_change,
        state.loss_1,
        state.loss_2,
        state.loss_3,
    )


@law
def finish(joint, state, mid, v, impulse, load_torque, h):
    """Second half of a step: drift on with the new velocity v, and book the works of this step."""
    q = mid.angle + 0.5 * h * v
    mean = 0.5 * (state.velocity + v)
    turn = h * mean
    return JointState(
        q,
        v,
        v - state.velocity,
        mid.spool,
        mid.spool_rate,
        _swell(joint.hose_a, mid.hose_a, joint.hose_a.neutral + q),
        _swell(joint.hose_b, mid.hose_b, joint.hose_b.neutral - q),
        state.gas_work + mid.gas_torque * turn,
        state.load_work + load_torque * turn,
        state.hose_work + mid.loss_torque * turn,
        state.brake_heat - impulse * mean,
        state.damping_heat + mid.damping * mid.velocity * turn,
        state.air_taken + mid.air_taken,
    )
