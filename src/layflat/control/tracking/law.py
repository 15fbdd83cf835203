"""The tracking law: the whole arm follows its demand, moving or at rest, with a model of itself in the loop.

In a cycle it
1. corrects its model by what the sensors say, and estimates loads, friction and payload (estimation.py);
2. looks where the model would be a cycle later with its valves centred;
3. plans where it should be then: a reference that limits of torque and valve allow (planning.py, limits.py);
4. finds the torques that take it there: those of the rigid body with feedback on angle and velocity, of friction and
   losses on the way, against loads (torques.py);
5. finds the openings that bring the air to these torques, by running the model with the valves open as well; a third
   run, with the openings found, is what the model predicts (valves.py).

Besides, it sets brakes, dither and supply (auxiliary.py, stiffness.py), and gives up where its model is wrong
(arrival.py).

| symbol | meaning | unit |
|---|---|---|
| q, dp | angle and differential pressure that sensors say | rad, Pa |
| e | innovation of the angle | rad |
| T | time since the last cycle | s |
"""

from math import sqrt
from typing import Any, NamedTuple

from layflat.control.contract import Command
from layflat.control.tracking.arrival import Doubt, doubted, has_arrived
from layflat.control.tracking.auxiliary import Auxiliary, asked_of, begun, rested_for, tolerance_of
from layflat.control.tracking.estimation import (
    ParameterEstimate,
    Prior,
    Shapes,
    estimate_of,
    heaviest,
    initial_estimate,
    propagated,
    updated,
)
from layflat.control.tracking.limits import ActuatorLimits, Margins, Parts
from layflat.control.tracking.model import (
    Innovation,
    ObserverTuning,
    Plant,
    angle_of_state,
    at_rest,
    gains_of,
    placed,
    pressure_correction,
)
from layflat.control.tracking.planning import PathState, goal_of, governed, is_resting, plan_of, stays
from layflat.control.tracking.reference import Reference
from layflat.control.tracking.stiffness import stiffness_of
from layflat.control.tracking.torques import SLOW, Feedback, computed_torques, reanchored
from layflat.control.tracking.valves import free_response, states_on_arrival, valve_openings
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.algebra import diagonal, largest
from layflat.physics.arms import dynamics
from layflat.physics.delay import Line


class Settings(NamedTuple):
    """Settings of the law; tuples with an item a joint but for those of estimation.py."""

    plant: Plant
    actuators: tuple[ActuatorLimits, ...]
    observer: tuple[ObserverTuning, ...]
    feedback: tuple[Feedback, ...]
    margins: Margins
    parts: Parts
    prior: Prior
    shapes: Shapes


class Memory(NamedTuple):
    """Memory of the law: its model's state, its parameters, and where it is on its path."""

    states: tuple[Any, ...]
    lines: tuple[Line, ...]  # commands on their way to the valves
    innovations: tuple[Innovation, ...]
    parameters: ParameterEstimate
    path: PathState
    waited: float  # how long the arm has been at rest where it landed, s
    doubt: Doubt
    auxiliary: Auxiliary


class Report(NamedTuple):
    """Signals of a joint that the law shows in a cycle; `SIGNALS` has units and meanings."""

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
"""Unit and meaning of what is reported."""

WAIT = 0.03  # an arm that is at rest beside its goal for so long sets out again, s
# Standard errors of the angle's sensor by which a joint that is held does not seem to move: with dither, and without,
# where nothing shakes it, and noise has hours to seem a motion.
STILL, QUIET_STILL = 2.6, 8.0


@law
def _begun(joint, q, dp, around):
    zero = 0.0 * q
    return at_rest(joint, q, dp, around), Line(zero, zero, zero), Innovation(zero, zero), Reference(q, zero, zero)


@composition
def wake(settings, sensed):
    """Return the memory of a law that begins at these measurements, at rest."""
    joints, around = settings.plant.joints, settings.plant.around
    states, lines, innovations, references = each(_begun, joints, sensed.angle, sensed.differential_pressure, around)
    zero = 0.0 * settings.plant.around.ambient_pressure
    parameters = initial_estimate(settings.prior, settings.shapes)
    path = PathState(references, zero, zero)
    return Memory(states, lines, innovations, parameters, path, zero, Doubt(zero, zero, sensed.angle), begun(joints))


@law
def _innovation(state, q):
    return q - state.motion.angle


@law
def _corrected(joint, state, innovation, observer, gains, q, dp, turn, speed, shares, around):
    # State after the measurements of a joint; what was estimated turns it (rad) and changes its speed (rad/s).
    motion = state.motion
    e = q - motion.angle - turn
    still = QUIET_STILL + shares.dither * (STILL - QUIET_STILL)
    calm = (motion.velocity == 0.0) & (abs(e) < still * observer.angle)
    v = motion.velocity + speed + select(calm, 0.0, gains.velocity) * e
    missing = dp - (state.hose_a.pressure - state.hose_b.pressure)
    change, after = pressure_correction(observer, innovation, missing)
    return placed(joint, state, motion.angle + turn + gains.angle * e, v, change, around), after


@law
def _sent(line, opening):
    return Line(opening, line.last_1, line.last_2)


@law
def _again(state, reference, again):
    # A reference that begins where the joint is.
    return Reference(
        select(again, state.motion.angle, reference.angle),
        select(again, 0.0, reference.velocity),
        select(again, 0.0, reference.acceleration),
    )


@law
def _moves(state):
    return select(abs(state.motion.velocity) < SLOW, 0.0, 1.0)


@law
def _shown(joint, state, reference, wanted, load, friction, payload, landed, shares, doubt, around):
    motion = state.motion
    dp = state.hose_a.pressure - state.hose_b.pressure
    return Report(
        motion.angle, motion.velocity, dp, reference.angle, reference.velocity, wanted, load, friction, payload, landed,
        stiffness_of(joint, state, around), shares.brake, shares.dither, shares.supply, sqrt(doubt.mean), doubt.held,
    )  # fmt: skip


@law
def _voltage(joint, opening):
    return joint.valve.centre_voltage + joint.valve.volts_to_full * opening


@composition
def _observed(settings, memory, sensed, asked, T):
    """Return states, innovations and parameters after the measurements, and the gains that the angles had."""
    plant = settings.plant
    errors = each(_innovation, memory.states, sensed.angle)
    parameters, turns, speeds, doubt = updated(settings.prior, memory.parameters, errors, 1.0 - asked.compliant)
    mass, _, _ = dynamics(
        plant.arm, estimate_of(parameters, plant.joints, asked.mean).payload, sensed.angle, sensed.angle
    )
    gains = each(gains_of, settings.observer, diagonal(mass, sensed.angle), T)
    states, innovations = each(
        _corrected, plant.joints, memory.states, memory.innovations, settings.observer, gains, sensed.angle,
        sensed.differential_pressure, turns, speeds, asked.mean, plant.around,
    )  # fmt: skip
    return states, innovations, parameters, gains, doubt


@composition
def _landing(settings, memory, plan, references, goals, after, tolerance, T):
    """Return the path, and how long the arm has waited: at rest beside its goal it sets out again from there, s."""
    slow = (largest(each(_moves, after)) == 0.0) & (plan.landed > 0.5)
    waited = select(slow, memory.waited + T, 0.0)
    angles = each(angle_of_state, after)
    missed = select(has_arrived(settings.plant.arm, angles, goals, tolerance), 0.0, 1.0) > 0.5
    again = (waited > WAIT) & (plan.rests > 0.5) & missed & (settings.parts.landing > 0.5)
    path = PathState(each(_again, after, references, again), plan.length, select(again, 0.0, plan.landed))
    return path, select(again, 0.0, waited)


@composition
def step(settings, memory, sensed, demand, elapsed):
    """Do one cycle; return memory, command and report (see control/kind.py)."""
    plant, lines, T = settings.plant, memory.lines, elapsed
    goals = each(goal_of, demand.angle, demand.velocity, demand.acceleration, T * len(plant.late))
    gave_up = memory.doubt.held > 0.5
    rests = select(is_resting(goals) | gave_up, 1.0, 0.0)
    remains = select(stays(memory.path, goals) & (memory.doubt.held < 0.5), 1.0, 0.0)
    asked, auxiliary = asked_of(plant, memory.auxiliary, memory.states, demand, rests, remains, T)
    states, innovations, parameters, gains, square = _observed(settings, memory, sensed, asked, T)
    doubt = doubted(memory.doubt, square, demand.angle, T)
    estimate = estimate_of(parameters, plant.joints, asked.mean)
    tolerance = tolerance_of(settings.margins, auxiliary, asked)
    met, later = states_on_arrival(plant, states, lines, estimate, asked, T)
    response = free_response(plant, met, lines, estimate, asked, T)
    begun_anew = reanchored(settings, memory.path, response, asked.compliant)
    most = heaviest(settings.prior, parameters)
    plan = plan_of(settings, begun_anew, estimate, most, response, goals, tolerance, T)
    torques = computed_torques(settings, plan, met, response, goals, estimate, asked, T)
    openings, after, lacks = valve_openings(
        settings, met, lines, response, estimate, asked, torques, asked.controls * (1.0 - doubt.held), T
    )
    if len(plant.late) == 0:
        later = after
    references = governed(settings, plan, response, goals, lacks, T)
    path, waited = _landing(settings, memory, plan, references, goals, after, tolerance, T)
    parameters = propagated(
        settings.prior, parameters, settings.shapes, plant.arm, gains, states, later, asked.mean, plan.left, T
    )
    rested = rested_for(plant, auxiliary, asked, after, response, estimate, plan.resting, T)
    report = each(
        _shown, plant.joints, later, path.references, torques, estimate.loads, estimate.frictions, estimate.payload,
        plan.landed, asked.mean, doubt, plant.around,
    )  # fmt: skip
    auxiliary = Auxiliary(auxiliary.shares, rested, auxiliary.stiffness, auxiliary.way)
    sent = each(_sent, lines, openings)
    remembered = Memory(later, sent, innovations, parameters, path, waited, doubt, auxiliary)
    command = Command(each(_voltage, plant.joints, openings), asked.shares)
    return remembered, command, report
