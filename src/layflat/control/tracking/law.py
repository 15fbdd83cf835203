"""The tracking law: the whole arm follows its demand, moving or at rest, with a model of itself in the loop.

In a cycle it
1. corrects its model by what the sensors say, and estimates loads, friction and payload (estimation.py);
2. looks where the model would be a cycle later with its valves centred;
3. plans where it should be then: a reference that limits of torque and valve allow (planning.py, limits.py);
4. finds the torques that take it there: those of the rigid body with feedback on angle and velocity, of friction and
   losses on the way, against loads (torques.py);
5. finds the openings that bring the air to these torques, by running the model with the valves open as well; a third
   run, with the openings found, is what the model predicts (valves.py).

| symbol | meaning | unit |
|---|---|---|
| q, dp | angle and differential pressure that sensors say | rad, Pa |
| e | innovation of the angle | rad |
| T | time since the last cycle | s |
"""

from typing import Any, NamedTuple

from layflat.control.kind import voltages_alone
from layflat.control.tracking.algebra import diagonal, largest
from layflat.control.tracking.estimation import (
    ParameterEstimate,
    Prior,
    Shapes,
    estimate_of,
    initial_estimate,
    propagated,
    updated,
)
from layflat.control.tracking.limits import ActuatorLimits, Margins
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
from layflat.control.tracking.planning import PathState, goal_of, governed, plan_of, tip_distance
from layflat.control.tracking.reference import Reference, angle_of
from layflat.control.tracking.torques import SLOW, Feedback, computed_torques, reanchored
from layflat.control.tracking.valves import free_response, states_on_arrival, valve_openings
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.arms import dynamics
from layflat.physics.delay import Line


class Settings(NamedTuple):
    """Settings of the law; tuples with an item a joint but for those of estimation.py."""

    plant: Plant
    actuators: tuple[ActuatorLimits, ...]
    observer: tuple[ObserverTuning, ...]
    feedback: tuple[Feedback, ...]
    margins: Margins
    prior: Prior
    shapes: Shapes


class Memory(NamedTuple):
    """What the law remembers: its model's state, its parameters, and where it is on its path."""

    states: tuple[Any, ...]
    lines: tuple[Line, ...]  # commands on their way to the valves
    innovations: tuple[Innovation, ...]
    parameters: ParameterEstimate
    path: PathState
    waited: float  # how long the arm has been at rest where it landed, s


class Report(NamedTuple):
    """What the law shows of a joint in a cycle; `SIGNALS` has units and meanings."""

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
}
"""Unit and meaning of what is reported."""

WAIT = 0.03  # an arm that is at rest beside its goal for so long sets out again, s
STILL = 1.5  # counts of the angle's converter by which a joint that is held does not seem to move


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
    return Memory(states, lines, innovations, parameters, PathState(references, zero, zero), zero)


@law
def _innovation(state, q):
    return q - state.motion.angle


@law
def _corrected(joint, state, innovation, observer, gains, q, dp, turn, speed, around):
    # State after the measurements of a joint; what was estimated turns it (rad) and changes its speed (rad/s).
    motion = state.motion
    e = q - motion.angle - turn
    # A count of the converter moves no joint that is held.
    calm = (motion.velocity == 0.0) & (abs(e) < STILL * joint.angle_sensor.lsb)
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
def _shown(state, reference, wanted, load, friction, payload, landed):
    motion = state.motion
    dp = state.hose_a.pressure - state.hose_b.pressure
    return Report(
        motion.angle, motion.velocity, dp, reference.angle, reference.velocity, wanted, load, friction, payload, landed
    )


@law
def _voltage(joint, opening):
    return joint.valve.centre_voltage + joint.valve.volts_to_full * opening


@composition
def _observed(settings, memory, sensed, T):
    """Return states, innovations and parameters after the measurements, and the gains that the angles had."""
    plant = settings.plant
    errors = each(_innovation, memory.states, sensed.angle)
    parameters, turns, speeds = updated(settings.prior, memory.parameters, errors)
    mass, _, _ = dynamics(plant.arm, estimate_of(parameters, plant.joints).payload, sensed.angle, sensed.angle)
    gains = each(gains_of, settings.observer, diagonal(mass, sensed.angle), T)
    states, innovations = each(
        _corrected, plant.joints, memory.states, memory.innovations, settings.observer, gains, sensed.angle,
        sensed.differential_pressure, turns, speeds, plant.around,
    )  # fmt: skip
    return states, innovations, parameters, gains


@composition
def _landing(settings, memory, plan, references, goals, after, T):
    """Return the path, and how long the arm has waited: at rest beside its goal it sets out again from there, s."""
    slow = (largest(each(_moves, after)) == 0.0) & (plan.landed > 0.5)
    waited = select(slow, memory.waited + T, 0.0)
    angles = each(angle_of_state, after)
    missed = tip_distance(settings.plant.arm, angles, each(angle_of, goals)) > settings.margins.tolerance
    again = (waited > WAIT) & (plan.rests > 0.5) & missed
    path = PathState(each(_again, after, references, again), plan.length, select(again, 0.0, plan.landed))
    return path, select(again, 0.0, waited)


@composition
def step(settings, memory, sensed, demand, elapsed):
    """Do one cycle; return memory, command and report (see control/kind.py)."""
    plant, lines, T = settings.plant, memory.lines, elapsed
    states, innovations, parameters, gains = _observed(settings, memory, sensed, T)
    estimate = estimate_of(parameters, plant.joints)
    begun, later = states_on_arrival(plant, states, lines, estimate, T)
    response = free_response(plant, begun, lines, estimate, T)
    goals = each(goal_of, demand.angle, demand.velocity, demand.acceleration, T * len(plant.late))
    plan = plan_of(settings, reanchored(settings, memory.path, response), estimate, response, goals, T)
    torques = computed_torques(settings, plan, begun, response, goals, estimate, T)
    openings, after, lacks = valve_openings(settings, begun, lines, response, estimate, torques, T)
    if len(plant.late) == 0:
        later = after
    references = governed(settings, plan, response, goals, lacks, T)
    path, waited = _landing(settings, memory, plan, references, goals, after, T)
    parameters = propagated(settings.prior, parameters, settings.shapes, plant.arm, gains, states, later, T)
    report = each(
        _shown, later, path.references, torques, estimate.loads, estimate.frictions, estimate.payload, plan.landed
    )
    remembered = Memory(later, each(_sent, lines, openings), innovations, parameters, path, waited)
    return remembered, voltages_alone(each(_voltage, plant.joints, openings)), report
