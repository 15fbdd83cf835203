"""Openings of the valves that bring the air to given torques: found by running the model, which knows what it takes.

A run with the valves centred and one with them open have the torques between them at the end of a cycle; in between
they are taken for straight. A command that is late by whole cycles meets the arm where commands before it bring it.

| symbol | meaning | unit |
|---|---|---|
| T | control cycle | s |
"""

from layflat.control.tracking.limits import holding
from layflat.control.tracking.model import a_cycle_later, gas_torque
from layflat.control.tracking.planning import FreeResponse
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.adjustable import regulated
from layflat.physics.arms import dynamics
from layflat.physics.delay import delayed
from layflat.physics.joint import Drive

LEAST_GAIN = 1e-3  # of torque by an open valve, N m, that counts
OPEN = 0.99  # an opening that can't be greater


@law
def _acting(joint, line, opening, friction, load, shares, around, passed, T):
    acts, _ = delayed(line, opening, joint.valve.delay / T - passed)
    return Drive(acts, friction, load, regulated(shares.supply, around.supply_pressure, around.ambient_pressure))


@composition
def _run(plant, states, lines, openings, passed, estimate, asked, T):
    # States a cycle later; it begins when so many cycles have passed since these openings were commanded.
    drives = each(
        _acting, plant.joints, lines, openings, estimate.frictions, estimate.loads, asked.mean, plant.around, passed, T
    )
    return a_cycle_later(plant, states, drives, asked.mean, estimate.payload, T)


@law
def _centred(friction):
    return 0.0 * friction


@composition
def states_on_arrival(plant, states, lines, estimate, asked, T):
    """Return the states that a command given now meets, and states a cycle from now if it meets later ones."""
    later = states
    for passed in range(len(plant.late)):
        states = _run(plant, states, lines, each(_centred, estimate.frictions), passed, estimate, asked, T)
        if passed == 0:
            later = states
    return states, later


@law
def _motion(state):
    return state.motion.angle, state.motion.velocity


@law
def _against(velocity_torque, holds):
    return holds - velocity_torque


@composition
def free_response(plant, states, lines, estimate, asked, T):
    """Return the arm a cycle after it met a command that centres all valves."""
    free = _run(plant, states, lines, each(_centred, estimate.frictions), len(plant.late), estimate, asked, T)
    q, v = each(_motion, free)
    mass, coriolis, pull = dynamics(plant.arm, estimate.payload, q, v)
    holds = each(holding, plant.joints, q, pull)
    return FreeResponse(free, q, v, mass, each(_against, coriolis, holds), holds)


@law
def _full(joint, free, wanted, around):
    return select(wanted > gas_torque(joint, free, around), 1.0, -1.0) + 0.0 * wanted


@law
def _opening(joint, feedback, free, opened, full, wanted, around):
    t_0, t_1 = gas_torque(joint, free, around), gas_torque(joint, opened, around)
    gained = select(abs(t_1 - t_0) > LEAST_GAIN, t_1 - t_0, LEAST_GAIN)
    return full * min(max(feedback.closing * (wanted - t_0) / gained, 0.0), 1.0)


@law
def _commanded(opening, pumped, controls):
    return min(max(controls * opening + pumped, -1.0), 1.0)


@law
def _lack(joint, actuator, after, opening, wanted, around):
    missing = wanted - gas_torque(joint, after, around)
    return select((abs(opening) > OPEN) & ((wanted - actuator.middle) * missing > 0.0), missing, 0.0)


@composition
def valve_openings(settings, states, lines, response, estimate, asked, torques, controls, T):
    """Return openings for torques, the states that follow, and the torques that open valves lack, N m.

    Args: controls: 1, or 0 where the valves are to stay centred.
    """
    plant, around, passed = settings.plant, settings.plant.around, len(settings.plant.late)
    full = each(_full, plant.joints, response.states, torques, around)
    opened = _run(plant, states, lines, full, passed, estimate, asked, T)
    openings = each(_opening, plant.joints, settings.feedback, response.states, opened, full, torques, around)
    openings = each(_commanded, openings, asked.pumped, controls)
    after = _run(plant, states, lines, openings, passed, estimate, asked, T)
    return openings, after, each(_lack, plant.joints, settings.actuators, after, openings, torques, around)
