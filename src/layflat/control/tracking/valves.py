"""Openings of the valves that yield demanded torques of the air, by simulations of the model over a cycle.

The torque at the end of the cycle is interpolated linearly between a simulation with centred valves and one with fully
open valves. A command that is delayed by whole cycles acts on the state to which earlier commands bring the arm.

| symbol | meaning | unit |
|---|---|---|
| T | control cycle | s |
"""

from layflat.control.tracking.limits import holding_torque
from layflat.control.tracking.model import gas_torque, simulate_model_cycle
from layflat.control.tracking.planning import FreeResponse
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.adjustable import regulated_pressure
from layflat.physics.arms import dynamics
from layflat.physics.driver import delay_command
from layflat.physics.joint import Drive

MIN_TORQUE_GAIN = 1e-3  # min change of torque by an open valve, by which openings are divided, N m
FULL_OPENING = 0.99  # opening above which a valve counts as fully open


@law
def _delayed_drive(joint, line, opening, friction, load, shares, around, passed, T):
    """Return the `Drive` of a joint in a cycle that begins `passed` cycles after an opening was commanded.

    Its opening is the mean of what arrives in that cycle, after the valve's delay.

    Args: joint; line of earlier commands; opening, -1..1; friction and load, N m; mean `DriveFractions`; surroundings;
    passed; T.
    """
    acts, _ = delay_command(line, opening, joint.valve.delay / T - passed)
    return Drive(
        acts, friction, load, regulated_pressure(shares.supply, around.supply_pressure, around.ambient_pressure)
    )


@composition
def _predict_states(plant, states, lines, openings, passed, estimate, request, T):
    """Return the states a cycle later, if it begins `passed` cycles after these openings were commanded.

    Args: model of the plant; states; lines of earlier commands; openings, a tuple by joint; passed; `LoadEstimate`;
    `AuxiliaryRequest`; T.
    """
    drives = each(
        _delayed_drive,
        plant.joints,
        lines,
        openings,
        estimate.frictions,
        estimate.loads,
        request.mean,
        plant.around,
        passed,
        T,
    )
    return simulate_model_cycle(plant, states, drives, request.mean, estimate.payload, T)


@law
def _centred(friction):
    return 0.0 * friction


@composition
def predict_arrival(plant, states, lines, estimate, request, T):
    """Return the states when the present command arrives, whole cycles of delay later, and those a cycle from now.

    Without a whole cycle of delay, both are the present states.

    Args: model of the plant; present states; lines of earlier commands; `LoadEstimate`; `AuxiliaryRequest`; T.
    """
    later = states
    for passed in range(len(plant.late)):
        states = _predict_states(plant, states, lines, each(_centred, estimate.frictions), passed, estimate, request, T)
        if passed == 0:
            later = states
    return states, later


@law
def _motion(state):
    return state.motion.angle, state.motion.velocity


@law
def _steady_torque(velocity_torque, holds):
    return holds - velocity_torque


@composition
def free_response(plant, states, lines, estimate, request, T):
    """Return the `FreeResponse`: the arm a cycle after the arrival of a command that centres all valves.

    Args: model of the plant; states at the arrival; lines of commands; `LoadEstimate`; `AuxiliaryRequest`; T.
    """
    free = _predict_states(
        plant, states, lines, each(_centred, estimate.frictions), len(plant.late), estimate, request, T
    )
    q, v = each(_motion, free)
    mass, coriolis, pull = dynamics(plant.arm, estimate.payload, q, v)
    holds = each(holding_torque, plant.joints, q, pull)
    return FreeResponse(free, q, v, mass, each(_steady_torque, coriolis, holds), holds)


@law
def _full_opening(joint, free, torque, around):
    return select(torque > gas_torque(joint, free, around), 1.0, -1.0) + 0.0 * torque


@law
def _opening(joint, feedback, free, opened, full, torque, around):
    """Return the opening from 0 to `full` that yields the share `closing` of the missing torque, by interpolation."""
    t_0, t_1 = gas_torque(joint, free, around), gas_torque(joint, opened, around)
    gain = select(abs(t_1 - t_0) > MIN_TORQUE_GAIN, t_1 - t_0, MIN_TORQUE_GAIN)
    return full * min(max(feedback.closing * (torque - t_0) / gain, 0.0), 1.0)


@law
def _command_opening(opening, pumped, controls):
    return min(max(controls * opening + pumped, -1.0), 1.0)


@law
def _lack(joint, actuator, after, opening, torque, around):
    """Return the torque (N m) that a fully open valve lacks to one away from the middle of the range, else 0."""
    missing = torque - gas_torque(joint, after, around)
    return select((abs(opening) > FULL_OPENING) & ((torque - actuator.middle) * missing > 0.0), missing, 0.0)


@composition
def valve_openings(settings, states, lines, response, estimate, request, torques, controls, T):
    """Return the openings of the valves, the states after the cycle, and the torques that fully open valves lack, N m.

    Args: `Settings` of the law; states at the command's arrival; lines of commands; `FreeResponse`; `LoadEstimate`;
    `AuxiliaryRequest`; demanded torques of the air, N m, a tuple; controls: 1, or 0 for centred valves; T.
    """
    plant, around, passed = settings.plant, settings.plant.around, len(settings.plant.late)
    full = each(_full_opening, plant.joints, response.states, torques, around)
    opened = _predict_states(plant, states, lines, full, passed, estimate, request, T)
    openings = each(_opening, plant.joints, settings.feedback, response.states, opened, full, torques, around)
    openings = each(_command_opening, openings, request.pumped, controls)
    after = _predict_states(plant, states, lines, openings, passed, estimate, request, T)
    return openings, after, each(_lack, plant.joints, settings.actuators, after, openings, torques, around)
