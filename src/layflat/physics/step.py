"""A joint's half of a step: what its valve, air, losses and stops do, before and after the arm finds its velocities.

A step of h seconds goes drift (h/2) - kick (h) - drift (h/2). In the middle the angle stands still: air flows, and all
torques are gathered; then the arm (see plant.py) finds the new velocities, its brakes included, and the joint drifts
on. The first drift does the air's work implicitly, the second explicitly: together they are symmetric in time, hence of
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
from layflat.physics.chamber import pressure_after_swelling, temperature_and_roots, wall_heat
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.hysteresis import torques, turned
from layflat.physics.joint import AirTaken, HoseState, JointState, Ledger, Motion, has_second
from layflat.physics.line import exchange
from layflat.physics.stops_and_springs import spring_torque, stop_damping, stop_torque
from layflat.physics.valves import move

STEP = 0.5e-3  # default step, s: docs/speed.md says why
COARSE = 2.0 * STEP  # where many machines are compared, s: it ranks them as well


class Running(NamedTuple):
    """State of a joint between the steps of a run, its hoses joined."""

    motion: Motion
    valve: Any
    hoses: HoseState
    ledger: Ledger


class Middle(NamedTuple):
    """A joint in the middle of a step: angle held, air and valve already moved on, torques (N m) gathered."""

    angle: float
    velocity: float
    valve: Any
    hoses: HoseState
    gas_torque: float
    loss_torque: float
    torque: float
    damping: float
    pull: float  # torques of both hoses, added up: the load on the bearings where it is positive
    air_taken: float


@composition
def pack(state):
    """Join the hoses of a state."""
    return Running(state.motion, state.valve, join(state.hose_a, state.hose_b), state.ledger)


@composition
def unpack(running):
    """Part the hoses of a state: undoes `pack`."""
    a, b = halves(running.hoses)
    return JointState(running.motion, running.valve, a, b, running.ledger)


@law
def _exchange_gas(hose, state, travel, turn, valve, C_in, C_out, around, h):
    # Swell to the middle's volume, then let air and heat flow for h: new state, torques of gas and losses, damping of
    # these, air taken.
    p_a = around.ambient_pressure
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    swell = volume - state.volume
    p_0, stiffness = pressure_after_swelling(hose.chamber, state.energy, volume, swell, state.pressure, p_a)
    p = p_0 + 0.5 * state.pressure_change
    m = state.mass + 0.5 * state.mass_change
    T, roots = temperature_and_roots(hose.chamber, p, m, volume, p_a)
    wall = wall_heat(hose.chamber, T, around.ambient_temperature)
    flow, heat, taken, line = exchange(
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
def _swell(hose, state, travel):
    # Second drift of a hose: its air works at the pressure of the middle.
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
def midpoint(joint, running, command, wave, around, h):
    """First half of a step: drift to the middle, move the valve, let the air flow, gather the torques."""
    motion = running.motion
    q = motion.angle + 0.5 * h * motion.velocity
    v = motion.velocity + 0.5 * motion.velocity_change
    # What fills hose A vents hose B, where that is not missing and its port plugged.
    valve, fills, vents = move(joint.valve, running.valve, command, wave, h)
    second = has_second(joint.second)
    # The elements follow the angle from middle to middle: their last turn ended half a step before this one began.
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
    return Middle(q, v, valve, hoses, gas, loss_a + loss_b, torque, damping, pull, taken_a + taken_b)


@composition
def _book_all(ledger, mid, impulse, load_torque, mean, h):
    turn = h * mean
    return Ledger(
        ledger.gas_work + mid.gas_torque * turn,
        ledger.load_work + load_torque * turn,
        ledger.hose_work + mid.loss_torque * turn,
        ledger.brake_heat - impulse * mean,
        ledger.damping_heat + mid.damping * mid.velocity * turn,
        ledger.air_taken + mid.air_taken,
    )


@composition
def _book_air(ledger, mid, impulse, load_torque, mean, h):  # noqa: ARG001  (as all ways to book)
    return AirTaken(ledger.air_taken + mid.air_taken)


book = by_kind({Ledger: _book_all, AirTaken: _book_air})
"""Book the works of a step: `book(ledger, mid, impulse, load_torque, mean, h)`."""


@composition
def finish(joint, running, mid, v, impulse, load_torque, h):
    """Second half of a step: drift on with the new velocity v, and book the works of this step."""
    motion = running.motion
    q = mid.angle + 0.5 * h * v
    mean = 0.5 * (motion.velocity + v)
    travels = join(joint.hose_a.neutral + q, joint.hose_b.neutral - q)
    return Running(
        Motion(q, v, v - motion.velocity),
        mid.valve,
        _swell(join(joint.hose_a, joint.hose_b), mid.hoses, travels),
        book(running.ledger, mid, impulse, load_torque, mean, h),
    )
