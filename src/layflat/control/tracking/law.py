"""The tracking law: model-based control of the whole arm towards moving and resting demands.

In every control cycle it
1. corrects its model by the sensors' readings, and estimates loads, friction and payload (estimation.py);
2. predicts the model's state a cycle later with centred valves (valves.py);
3. plans the reference for that time within the limits of torques and valves (planning.py, limits.py);
4. computes the torques towards the reference: rigid-body dynamics with feedback of angle and velocity, compensation of
   friction and losses, and loads (torques.py);
5. computes the openings with which the air exerts these torques, from a second simulation of the model with open
   valves; a third one, with these openings, predicts the state of the next cycle (valves.py).

It also commands brakes, dither and supply (auxiliary.py), and gives up a motion if its model is wrong (arrival.py).

| symbol | meaning | unit |
|---|---|---|
| q, dp | measured angle and differential pressure | rad, Pa |
| e | innovation of the angle | rad |
| T | time since the last cycle | s |
"""

from math import sqrt
from typing import Any, NamedTuple

from layflat.control.signals import Command
from layflat.control.tracking.arrival import ModelResidual, has_arrived, update_residual
from layflat.control.tracking.auxiliary import (
    AuxiliaryState,
    initial_auxiliary,
    request_auxiliaries,
    resting_time,
    resting_tolerance,
    state_stiffness,
)
from layflat.control.tracking.estimation import (
    MatrixZeros,
    ParameterEstimate,
    Prior,
    initial_estimate,
    load_estimate,
    propagate_parameters,
    update_parameters,
    upper_payload,
)
from layflat.control.tracking.limits import ActuatorLimits, LawParts, Margins
from layflat.control.tracking.model import (
    ObserverTuning,
    PlantModel,
    PressureInnovations,
    at_rest,
    correct_pressure,
    joint_angle,
    observer_gains,
    place_joint,
)
from layflat.control.tracking.planning import (
    PathState,
    delayed_goal,
    govern_references,
    is_resting,
    is_to_stay,
    plan_cycle,
)
from layflat.control.tracking.reference import Reference
from layflat.control.tracking.torques import RESTING_SPEED, Feedback, compute_torques, reanchor_path
from layflat.control.tracking.valves import free_response, predict_arrival, valve_openings
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.algebra import diagonal, max_magnitude
from layflat.physics.arms import dynamics
from layflat.physics.driver import CommandDelayLine


class Settings(NamedTuple):
    """Settings of the law; tuples have an item per joint, except in those of estimation.py."""

    plant: PlantModel
    actuators: tuple[ActuatorLimits, ...]
    observer: tuple[ObserverTuning, ...]
    feedback: tuple[Feedback, ...]
    margins: Margins
    parts: LawParts
    prior: Prior
    shapes: MatrixZeros


class Memory(NamedTuple):
    """Memory of the law: states of its model, estimated parameters, and state of its path."""

    states: tuple[Any, ...]
    lines: tuple[CommandDelayLine, ...]  # commands on their way to the valves
    innovations: tuple[PressureInnovations, ...]
    parameters: ParameterEstimate
    path: PathState
    waited: float  # time for which the arm has rested where it landed, s
    residual: ModelResidual
    auxiliary: AuxiliaryState


class Report(NamedTuple):
    """Signals of a joint that the law reports in a cycle; `SIGNALS` has units and meanings."""

    estimated_angle: float
    estimated_velocity: float
    estimated_pressure: float
    reference_angle: float
    reference_velocity: float
    wanted_torque: float
    estimated_load: float
    estimated_friction: float
    estimated_payload: float
    landed: float
    estimated_stiffness: float
    brake_share: float
    dither_share: float
    supply_share: float
    model_error: float
    given_up: float


SIGNALS = {
    "estimated_angle": ("rad", "angle that the controller's model predicts for the end of the cycle"),
    "estimated_velocity": ("rad/s", "velocity, likewise"),
    "estimated_pressure": ("Pa", "differential pressure without dither, likewise"),
    "reference_angle": ("rad", "angle that the controller asks of itself for the end of the cycle"),
    "reference_velocity": ("rad/s", "velocity, likewise"),
    "wanted_torque": ("N*m", "torque that the air is to have then"),
    "estimated_load": ("N*m", "torque on the joint that is not in the controller's description"),
    "estimated_friction": ("N*m", "friction of the shaft, as estimated"),
    "estimated_payload": ("kg", "payload, as estimated"),
    "landed": ("1", "1 while the reference is the demand"),
    "estimated_stiffness": ("N*m/rad", "stiffness that the joint has with shut valves"),
    "brake_share": ("1", "share of its torque that the brake is given"),
    "dither_share": ("1", "share of the valve's dither"),
    "supply_share": ("1", "share of its gauge pressure that the supply is regulated to"),
    "model_error": ("1", "errors of the model's angles lately, over those to be expected"),
    "given_up": ("1", "1 while the model is too far from the plant, and the arm is held"),
}
"""Unit and meaning of each field of `Report`."""

LANDING_WAIT = 0.03  # time at rest outside its tolerance after which an arm starts a new path to its goal, s
# Innovation, in standard errors of the sensor, up to which a joint that friction holds counts as stationary: with
# dither, and without, when noise would otherwise look like a motion in hours at rest.
STATIONARY_ERRORS, QUIET_STATIONARY_ERRORS = 2.6, 8.0


@law
def _initial_joint(joint, q, dp, around):
    """Return a joint's initial state at rest, empty delay line and innovations, and a reference at its angle."""
    zero = 0.0 * q
    return (
        at_rest(joint, q, dp, around),
        CommandDelayLine(zero, zero, zero),
        PressureInnovations(zero, zero),
        Reference(q, zero, zero),
    )


@composition
def wake(settings, sensed):
    """Return the memory of the law at the start, at rest at the sensors' readings."""
    joints, around = settings.plant.joints, settings.plant.around
    states, lines, innovations, references = each(
        _initial_joint, joints, sensed.angle, sensed.differential_pressure, around
    )
    zero = 0.0 * settings.plant.around.ambient_pressure
    parameters = initial_estimate(settings.prior, settings.shapes)
    path = PathState(references, zero, zero)
    return Memory(
        states,
        lines,
        innovations,
        parameters,
        path,
        zero,
        ModelResidual(zero, zero, sensed.angle),
        initial_auxiliary(joints),
    )


@law
def _innovation(state, q):
    return q - state.motion.angle


@law
def _correct_joint(joint, state, innovation, observer, gains, q, dp, rotation, speed, shares, around):
    """Return a joint's state corrected by its measurements, and the pressure innovations after them.

    The estimated parameters change its angle by `rotation` (rad) and its velocity by `speed` (rad/s).
    """
    motion = state.motion
    e = q - motion.angle - rotation
    errors = QUIET_STATIONARY_ERRORS + shares.dither * (STATIONARY_ERRORS - QUIET_STATIONARY_ERRORS)
    stationary = (motion.velocity == 0.0) & (abs(e) < errors * observer.angle)
    v = motion.velocity + speed + select(stationary, 0.0, gains.velocity) * e
    pressure_error = dp - (state.hose_a.pressure - state.hose_b.pressure)
    change, after = correct_pressure(observer, innovation, pressure_error)
    return place_joint(joint, state, motion.angle + rotation + gains.angle * e, v, change, around), after


@law
def _send_command(line, opening):
    return CommandDelayLine(opening, line.last_1, line.last_2)


@law
def _restart_reference(state, reference, restarts):
    """Return the reference, or where `restarts` is true one at rest at the joint's angle."""
    return Reference(
        select(restarts, state.motion.angle, reference.angle),
        select(restarts, 0.0, reference.velocity),
        select(restarts, 0.0, reference.acceleration),
    )


@law
def _is_moving(state):
    return select(abs(state.motion.velocity) < RESTING_SPEED, 0.0, 1.0)


@law
def _joint_report(joint, state, reference, torque, load, friction, payload, landed, shares, residual, around):
    """Return the law's signals of one joint: estimates, reference, torque, stiffness, fractions and model residual."""
    motion = state.motion
    dp = state.hose_a.pressure - state.hose_b.pressure
    return Report(
        motion.angle, motion.velocity, dp, reference.angle, reference.velocity, torque, load, friction, payload, landed,
        state_stiffness(joint, state, around), shares.brake, shares.dither, shares.supply, sqrt(residual.mean),
        residual.held,
    )  # fmt: skip


@law
def _voltage(joint, opening):
    return joint.valve.centre_voltage + joint.valve.volts_to_full * opening


@composition
def _observe(settings, memory, sensed, request, T):
    """Return states, innovations and parameters after the measurements, the observer's gains, and the residual."""
    plant = settings.plant
    errors = each(_innovation, memory.states, sensed.angle)
    parameters, turns, speeds, residual = update_parameters(
        settings.prior, memory.parameters, errors, 1.0 - request.compliant
    )
    mass, _, _ = dynamics(
        plant.arm, load_estimate(parameters, plant.joints, request.mean).payload, sensed.angle, sensed.angle
    )
    gains = each(observer_gains, settings.observer, diagonal(mass, sensed.angle), T)
    states, innovations = each(
        _correct_joint, plant.joints, memory.states, memory.innovations, settings.observer, gains, sensed.angle,
        sensed.differential_pressure, turns, speeds, request.mean, plant.around,
    )  # fmt: skip
    return states, innovations, parameters, gains, residual


@composition
def _update_landing(settings, memory, plan, references, goals, after, tolerance, T):
    """Return the path and the time waited, s; an arm at rest outside its tolerance starts a new path from there."""
    slow = (max_magnitude(each(_is_moving, after)) == 0.0) & (plan.landed > 0.5)
    waited = select(slow, memory.waited + T, 0.0)
    angles = each(joint_angle, after)
    missed = select(has_arrived(settings.plant.arm, angles, goals, tolerance), 0.0, 1.0) > 0.5
    restarts = (waited > LANDING_WAIT) & (plan.rests > 0.5) & missed & (settings.parts.landing > 0.5)
    references = each(_restart_reference, after, references, restarts)
    path = PathState(references, plan.length, select(restarts, 0.0, plan.landed))
    return path, select(restarts, 0.0, waited)


@composition
def step(settings, memory, sensed, demand, elapsed):
    """Return memory, command and report of one control cycle (see control/kind.py)."""
    plant, lines, T = settings.plant, memory.lines, elapsed
    goals = each(delayed_goal, demand.angle, demand.velocity, demand.acceleration, T * len(plant.late))
    gave_up = memory.residual.held > 0.5
    rests = select(is_resting(goals) | gave_up, 1.0, 0.0)
    remains = select(is_to_stay(memory.path, goals) & (memory.residual.held < 0.5), 1.0, 0.0)
    request, auxiliary = request_auxiliaries(plant, memory.auxiliary, memory.states, demand, rests, remains, T)
    states, innovations, parameters, gains, square = _observe(settings, memory, sensed, request, T)
    residual = update_residual(memory.residual, square, demand.angle, T)
    estimate = load_estimate(parameters, plant.joints, request.mean)
    tolerance = resting_tolerance(settings.margins, auxiliary, request)
    arrival, later = predict_arrival(plant, states, lines, estimate, request, T)
    response = free_response(plant, arrival, lines, estimate, request, T)
    path = reanchor_path(settings, memory.path, response, request.compliant)
    payload = upper_payload(settings.prior, parameters)
    plan = plan_cycle(settings, path, estimate, payload, response, goals, tolerance, T)
    torques = compute_torques(settings, plan, arrival, response, goals, estimate, request, T)
    openings, after, lacks = valve_openings(
        settings, arrival, lines, response, estimate, request, torques, request.controls * (1.0 - residual.held), T
    )
    if len(plant.late) == 0:
        later = after
    references = govern_references(settings, plan, response, goals, lacks, T)
    path, waited = _update_landing(settings, memory, plan, references, goals, after, tolerance, T)
    parameters = propagate_parameters(
        settings.prior,
        parameters,
        settings.shapes,
        plant.arm,
        gains,
        states,
        later,
        request.mean,
        plan.remaining_path,
        T,
    )
    rested = resting_time(plant, auxiliary, request, after, response, estimate, plan.resting, T)
    report = each(
        _joint_report, plant.joints, later, path.references, torques, estimate.loads, estimate.frictions,
        estimate.payload, plan.landed, request.mean, residual, plant.around,
    )  # fmt: skip
    auxiliary = AuxiliaryState(auxiliary.shares, rested, auxiliary.stiffness, auxiliary.direction)
    lines = each(_send_command, lines, openings)
    memory = Memory(later, lines, innovations, parameters, path, waited, residual, auxiliary)
    command = Command(each(_voltage, plant.joints, openings), request.shares)
    return memory, command, report
