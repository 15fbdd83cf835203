"""Demanded torques of the air in the joints: rigid-body dynamics, feedback, and compensation of losses and friction.

Dry friction is undefined at rest. Its compensation follows an effective velocity: the reference's, plus terms of the
remaining path and of the joint's lag. So the torque rises as a motion begins, falls as it ends, and moves a joint that
friction holds away from its reference.

| symbol | meaning | unit |
|---|---|---|
| q, v | angle and velocity that the model predicts with centred valves | rad, rad/s |
| e | lag of a joint behind its reference | rad |
| T | control cycle | s |
"""

from typing import NamedTuple

from layflat.control.tracking.model import gas_torque, opposing_torque
from layflat.control.tracking.planning import PathState
from layflat.control.tracking.reference import Reference
from layflat.jit import composition, law
from layflat.lanes import each, gather, select, slots
from layflat.physics.algebra import diagonal, invert_symmetric, max_item, multiply_symmetric

CREEP_SPEED = 0.06  # effective velocity below which friction is compensated in part, rad/s
# Terms of the effective velocity:
PATH_GAIN = 30.0  # per remaining angle to the goal, 1/s
LEAD_TIME = 0.02  # per acceleration of the goal, s: a motion that reverses needs its compensation reversed in time
LAG_GAIN = 20.0  # per lag behind the reference beyond `LAG_DEADBAND`, 1/s
LAG_DEADBAND = 0.001  # rad
OVERRUN_GAIN = 200.0  # per angle beyond the goal that the reference has not reached yet: the joint broke away, 1/s
MAX_STIFFNESS_RATIO = 3.0  # max stiffness that the term of the lag makes, over that of feedback
MAX_DAMPING_FRACTION = 1.0  # fraction of its velocity that the damping of a light joint may remove in a cycle
RESTING_SPEED = 0.03  # speed below which a joint counts as at rest, rad/s
MAX_TRACKING_ERROR = 0.05  # error of the angle up to which feedback is never regarded as saturated, rad
UNLIMITED_LENGTH = 1e3  # length of a path that does not begin at rest, rad, so that its length limits nothing


class Feedback(NamedTuple):
    """Gains of the feedback of a joint."""

    stiffness: float  # acceleration per error of the angle, 1/s2
    damping: float  # acceleration per error of the velocity, 1/s
    closing: float  # share of a missing torque that the valve supplies in a cycle
    easing: float  # rate at which the torque of a joint that has arrived falls to its load, N m/s
    min_stiffness: float  # min torque per error of the angle, whatever the joint's inertia, N m/rad


@law
def _feedback(feedback, reference, q, v):
    return feedback.damping * (reference.velocity - v) + feedback.stiffness * (reference.angle - q)


@law
def _acceleration(feedback, reference, q, v, forward):
    return forward * reference.acceleration + _feedback(feedback, reference, q, v)


@law
def _is_saturated(actuator, feedback, inertia, torque):
    """Return 1 if feedback exceeds the joint's torque by an error that is not small (`MAX_TRACKING_ERROR`), else 0."""
    return select(abs(torque) > max(actuator.torque, MAX_TRACKING_ERROR * feedback.stiffness * inertia), 1.0, 0.0)


@law
def _reset_reference(reference, q, v, lost):
    return Reference(select(lost, q, reference.angle), select(lost, v, reference.velocity), reference.acceleration)


@composition
def reanchor_path(settings, path, response, compliant):
    """Return the path, restarted from the arm's motion if the feedback of any joint saturates.

    Saturated feedback would oscillate for ever about a reference at rest; a new path respects the torque limits.

    Args: `Settings` of the law; `PathState`; `FreeResponse`; 1 while the arm is compliant, when no path is restarted.
    """
    q, v = response.angles, response.velocities
    pulled = multiply_symmetric(response.mass, each(_feedback, settings.feedback, path.references, q, v))
    inertias = diagonal(response.mass, pulled)
    lost = (max_item(each(_is_saturated, settings.actuators, settings.feedback, inertias, pulled)) > 0.0) & (
        compliant < 0.5
    )
    references = each(_reset_reference, path.references, q, v, lost)
    return PathState(references, select(lost, UNLIMITED_LENGTH, path.length), select(lost, 0.0, path.landed))


@law
def _light_joint_feedback(feedback, reference, free, inertia, free_inertia, T):
    """Return the torque (N m) of feedback that a light joint lacks to `min_stiffness`: air, not inertia, moves it.

    Damping is limited to `MAX_DAMPING_FRACTION` of free_inertia / T (inertia of the joint with free neighbours), beyond
    which it would reverse the velocity in every cycle.
    """
    stiffness = max(feedback.min_stiffness - feedback.stiffness * inertia, 0.0)
    damping = min(stiffness * feedback.damping / max(feedback.stiffness, 1.0), MAX_DAMPING_FRACTION * free_inertia / T)
    return damping * (reference.velocity - free.motion.velocity) + stiffness * (reference.angle - free.motion.angle)


@law
def _friction_compensation(feedback, reference, free, goal, inertia, friction):
    """Return the torque (N m) against friction in the direction in which the joint is to move, at most `friction`.

    It is proportional to the effective velocity up to `CREEP_SPEED`: that of the reference, plus terms of the remaining
    path, of the goal's acceleration and of the lag, less one of an angle beyond the goal.

    Args: `Feedback`; reference; state with centred valves; goal (`Reference`); inertia of the joint, which limits the
    gain of the lag, kg m2; torque of friction, N m.
    """
    e = reference.angle - free.motion.angle
    lag = select(e > 0.0, max(e - LAG_DEADBAND, 0.0), min(e + LAG_DEADBAND, 0.0))
    remaining, error = goal.angle - reference.angle, free.motion.angle - goal.angle
    overrun = select(remaining > 0.0, max(error, 0.0), select(remaining < 0.0, min(error, 0.0), 0.0))
    stiffness = max(feedback.stiffness * inertia, feedback.min_stiffness)
    lag_gain = min(LAG_GAIN, MAX_STIFFNESS_RATIO * stiffness * CREEP_SPEED / max(friction, 1e-3))
    effective = (
        reference.velocity
        + PATH_GAIN * remaining
        + LEAD_TIME * goal.acceleration
        + lag_gain * lag
        - OVERRUN_GAIN * overrun
    )
    return friction * min(max(effective / CREEP_SPEED, -1.0), 1.0)


class TorqueTerms(NamedTuple):
    """Terms of the torque that is demanded of a joint's air, N m, without losses and damping."""

    motion: float  # acceleration, load and friction
    light: float  # additional feedback of a light joint
    load: float  # load alone, for a joint that has arrived


@law
def _torque_terms(feedback, reference, free, goal, inertial, inertia, free_inertia, steady, load, friction, T):
    """Return the `TorqueTerms` of a joint; `inertial` and `steady`: torques of its acceleration and velocity, N m."""
    compensation = _friction_compensation(feedback, reference, free, goal, inertia, friction)
    light = _light_joint_feedback(feedback, reference, free, inertia, free_inertia, T)
    return TorqueTerms(inertial + steady - load + compensation, light, steady - load)


@law
def _demanded_torque(joint, feedback, state, free, terms, k, resting, around, T):
    """Return the torque that the air of a joint is to exert, N m: of its motion, or eased towards the load if it rests.

    `resting` is 1 once the arm rests on its goal; k is the demanded stiffness, 0 for none.
    """
    opposes = opposing_torque(joint, free, around)
    moving = terms.motion + opposes + terms.light
    now, step = gas_torque(joint, state, around), feedback.easing * T
    # Friction holds the rest of the losses, unless the joint is to be compliant.
    resting_torque = terms.load + select(k > 0.0, opposes, 0.0)
    eased = min(max(resting_torque, now - step), now + step)
    return select((resting > 0.5) & (abs(free.motion.velocity) < RESTING_SPEED), eased, moving)


@law
def _zero(x):
    return 0.0 * x


@composition
def _free_inertias(mass, like, whole):
    """Return the inertia of each joint if all others are free to move, kg m2."""
    W, inertias, n = slots(invert_symmetric(mass, each(_zero, like), whole)), slots(like), len(like)
    for j in range(n):
        inertias[j] = 1.0 / W[j * n + j]
    return gather(like, inertias)


@law
def _scale_friction(friction, factor):
    return factor * friction


@composition
def compute_torques(settings, plan, states, response, goals, estimate, request, T):
    """Return the demanded torques of the air at the end of the cycle, N m, a tuple; at rest, eased to those of loads.

    Args: `Settings` of the law; `CyclePlan`; states of the joints; `FreeResponse`; goals (`Reference`), a tuple;
    `LoadEstimate`; `AuxiliaryRequest`; T.
    """
    resting = plan.resting * (1.0 - request.guided)
    parts, frictions = settings.parts, each(_scale_friction, estimate.frictions, settings.parts.friction)
    accelerations = each(
        _acceleration, settings.feedback, plan.references, response.angles, response.velocities, parts.feedforward
    )
    inertial, inertia = multiply_symmetric(response.mass, accelerations), diagonal(response.mass, accelerations)
    free_inertias = _free_inertias(response.mass, accelerations, settings.shapes.joints)
    terms = each(
        _torque_terms, settings.feedback, plan.references, response.states, goals, inertial, inertia, free_inertias,
        response.steady, estimate.loads, frictions, T,
    )  # fmt: skip
    return each(
        _demanded_torque, settings.plant.joints, settings.feedback, states, response.states, terms, request.stiffness,
        resting, settings.plant.around, T,
    )  # fmt: skip
