"""A joint's part of a time step: valve, air, losses and stops, before and after the arm computes the velocities.

A step of h seconds goes drift (h/2) - kick (h) - drift (h/2). In the middle the angle is constant: air flows, and all
torques are summed; then the arm (see plant.py) computes the new velocities, brakes included, and the joint drifts on.
The first drift does the air's work implicitly, the second explicitly: together they are symmetric in time, hence of
second order. Air flow, damping and Coriolis terms are evaluated once, at pressures and velocities extrapolated by
half of their last change.

Here a joint may be lanes of several joints. Its hoses are lanes in any case: all hoses A, then all hoses B.

| symbol | meaning | unit |
|---|---|---|
| q, v | joint angle and velocity | rad, rad/s |
| h | step | s |
"""

from typing import Any, NamedTuple

from layflat.jit import by_kind, composition, law
from layflat.lanes import halves, join, total
from layflat.physics.chamber import pressure_after_expansion, temperature_and_roots, wall_heat
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.hysteresis import torques, turned
from layflat.physics.joint import AirLedger, EnergyLedger, HoseState, JointMotion, JointState, has_second
from layflat.physics.line import exchange_air
from layflat.physics.stops_and_springs import spring_torque, stop_damping, stop_torque
from layflat.physics.valves import move

STEP = 0.5e-3  # default step, s: docs/speed.md says why
COARSE_STEP = 2.0 * STEP  # step for comparing many machines, s: it ranks them alike


class PackedState(NamedTuple):
    """State of a joint between the steps of a simulation run, its hoses joined into lanes."""

    motion: JointMotion
    valve: Any
    hoses: HoseState
    ledger: EnergyLedger


class MidpointState(NamedTuple):
    """A joint in the middle of a step: air and valve already advanced, torques (N m) summed."""

    angle: float
    velocity: float
    valve: Any
    hoses: HoseState
    gas_torque: float
    loss_torque: float
    torque: float
    damping: float
    pull: float  # sum of the torques of both hoses: the load on the bearings where it is positive
    air_taken: float


@composition
def pack_hoses(state):
    """Return the `PackedState` of a joint's state, its hoses joined into lanes."""
    return PackedState(state.motion, state.valve, join(state.hose_a, state.hose_b), state.ledger)


@composition
def unpack_hoses(running):
    """Return the `JointState` of a packed state, its hoses apart: the inverse of `pack_hoses`."""
    a, b = halves(running.hoses)
    return JointState(running.motion, running.valve, a, b, running.ledger)


@law
def _exchange_gas(hose, state, travel, turn, valve, C_in, C_out, around, h):
    """Return a hose's state after a step, torques of gas and losses (N m), damping (N m s/rad) and supplied air (kg).

    The hose expands to its volume in the middle of the step, then air and heat flow for h; `turn` is the rotation, rad.
    """
    p_a = around.ambient_pressure
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    swell = volume - state.volume
    p_0, stiffness = pressure_after_expansion(hose.chamber, state.energy, volume, swell, state.pressure, p_a)
    p = p_0 + 0.5 * state.pressure_change
    m = state.mass + 0.5 * state.mass_change
    T, roots = temperature_and_roots(hose.chamber, p, m, volume, p_a)
    wall = wall_heat(hose.chamber, T, around.ambient_temperature)
    flow, heat, taken, line = exchange_air(
        hose.line, state.line, valve, (C_in, C_out), p, p_0, stiffness, T, roots, wall, around, h
    )
    heat = heat + wall
    stored = state.energy - p_0 * swell + h * heat
    p_1 = p_0 + h * heat * stiffness
    p_g = 0.5 * (p_0 + p_1) - p_a
    loss = turned(hose.loss, state.loss, turn, p_g, h)
    damping = hose.damping.base + hose.damping.slope * max(p_g, 0.0)
    change = h * flow
    after = HoseState(stored, state.mass + change, volume, p_1, p_1 - p_0, change, loss, line)
    return after, torque_per_pressure(hose.stroke, travel) * p_g, total(torques(hose.loss, loss)), damping, h * taken


@law
def _finish_hose(hose, state, travel):
    """Return the hose's state after its second drift, in which its air does work at the pressure in the middle."""
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    return HoseState(
        state.energy - state.pressure * (volume - state.volume),
        state.mass,
        volume,
        state.pressure,
        state.pressure_change,
        state.mass_change,
        state.loss,
        state.line,
    )


@composition
def advance_to_midpoint(joint, running, command, wave, around, h):
    """Return the `MidpointState`: drifted by h/2, the valve moved and the air exchanged for h, and torques summed."""
    motion = running.motion
    q = motion.angle + 0.5 * h * motion.velocity
    v = motion.velocity + 0.5 * motion.velocity_change
    # The path that fills hose A vents hose B, where that is not missing and its port plugged.
    valve, fills, vents = move(joint.valve, running.valve, command, wave, h)
    second = has_second(joint.second)
    # The losses follow the angle from middle to middle: their last rotation ended half a step before this one begins.
    turn = h * motion.velocity
    hoses, gas, loss, damped, taken = _exchange_gas(
        join(joint.hose_a, joint.hose_b),
        running.hoses,
        join(joint.hose_a.neutral + q, joint.hose_b.neutral - q),
        join(turn, turn),
        join(joint.valve, joint.valve),
        join(fills, second * vents),
        join(vents, second * fills),
        join(around, around),
        h,
    )
    (gas_a, gas_b), (loss_a, loss_b), (taken_a, taken_b) = halves(gas), halves(loss), halves(taken)
    damped_a, damped_b = halves(damped)
    damping = joint.viscous_friction + stop_damping(joint.stops, q) + (damped_a + damped_b)
    elastic = stop_torque(joint.stops, q) + spring_torque(joint.spring, q)
    torque = (gas_a - gas_b) - (loss_a + loss_b) + (elastic - damping * v)
    gas, pull = gas_a - gas_b, gas_a + gas_b
    return MidpointState(q, v, valve, hoses, gas, loss_a + loss_b, torque, damping, pull, taken_a + taken_b)


@composition
def _book_energy(ledger, mid, brake_impulse, load_torque, mean_velocity, h):
    """Return the ledger with the works of one step (J) added, at the rotation h * mean_velocity.

    Units: brake_impulse N m s, load_torque N m, mean_velocity rad/s, h s.
    """
    rotation = h * mean_velocity
    return EnergyLedger(
        ledger.gas_work + mid.gas_torque * rotation,
        ledger.load_work + load_torque * rotation,
        ledger.hose_work + mid.loss_torque * rotation,
        ledger.brake_heat - brake_impulse * mean_velocity,
        ledger.damping_heat + mid.damping * mid.velocity * rotation,
        ledger.air_taken + mid.air_taken,
    )


@composition
def _book_air(ledger, mid, brake_impulse, load_torque, mean_velocity, h):  # noqa: ARG001  (signature of `_book_energy`)
    return AirLedger(ledger.air_taken + mid.air_taken)


book_step = by_kind({EnergyLedger: _book_energy, AirLedger: _book_air})
"""Ledger with the works of a step added: `book_step(ledger, mid, brake_impulse, load_torque, mean_velocity, h)`."""


@composition
def finish_step(joint, running, mid, v, impulse, load_torque, h):
    """Return the `PackedState` after a step: drifted on by h/2 at the new velocity v (rad/s), its works booked."""
    motion = running.motion
    q = mid.angle + 0.5 * h * v
    mean = 0.5 * (motion.velocity + v)
    travels = join(joint.hose_a.neutral + q, joint.hose_b.neutral - q)
    return PackedState(
        JointMotion(q, v, v - motion.velocity),
        mid.valve,
        _finish_hose(join(joint.hose_a, joint.hose_b), mid.hoses, travels),
        book_step(running.ledger, mid, impulse, load_torque, mean, h),
    )
