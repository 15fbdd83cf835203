"""Torques that the air of the joints is to have: those of the rigid body, of feedback, and of what opposes motion.

Dry friction has no value at rest. What the law adds for it goes by a velocity that says where the joint is to go: that
of its reference, and with it what is left of the path and by how much the joint is behind. So the torque comes as a
motion begins, goes as it ends, and brings back a joint that friction holds beside its reference.

| symbol | meaning | unit |
|---|---|---|
| q, v | angle and velocity that the model will have with centred valves | rad, rad/s |
| e | angle by which a joint is behind its reference | rad |
| T | control cycle | s |
"""

from typing import NamedTuple

from layflat.control.tracking.model import gas_torque, opposing_torque
from layflat.control.tracking.planning import PathState
from layflat.control.tracking.reference import Reference
from layflat.jit import composition, law
from layflat.lanes import each, gather, select, slots
from layflat.physics.algebra import diagonal, greatest, inverse, times

CREEP = 0.06  # velocity below which friction is compensated in part, rad/s
# What counts as velocity there:
ONWARD = 30.0  # per angle that is left to the goal, 1/s
LEAD = 0.02  # per acceleration of the goal, s: a motion that turns needs its friction turned in time
BEHIND = 20.0  # per angle that a joint is behind its reference by more than `SLACK`, 1/s
SLACK = 0.001  # rad
PAST = 200.0  # per angle by which a joint has passed its goal before its reference is there: it broke away, 1/s
STIFFEST = 3.0  # times as stiff as feedback friction may so make a light joint
CALMED = 1.0  # share of its velocity that the damping of a light joint may take from it in a cycle
SLOW = 0.03  # velocity below which a joint is taken for resting, rad/s
ASTRAY = 0.05  # angle, or velocity as feedback weighs it, within which no joint is too far from its reference, rad
FREELY = 1e3  # length of a path that is not begun at rest, rad: it is not limited for its length


class Feedback(NamedTuple):
    """How torques follow from where a joint is, and should be."""

    stiffness: float  # acceleration per angle, 1/s2
    damping: float  # acceleration per velocity, 1/s
    closing: float  # share of a missing torque that the valve makes up in a cycle
    easing: float  # change of torque per time of a joint that has arrived, N m/s
    least: float  # torque per angle, however light the joint is, N m/rad


@law
def _feedback(feedback, reference, q, v):
    return feedback.damping * (reference.velocity - v) + feedback.stiffness * (reference.angle - q)


@law
def _acceleration(feedback, reference, q, v, forward):
    return forward * reference.acceleration + _feedback(feedback, reference, q, v)


@law
def _lost(actuator, feedback, inertia, torque):
    # Whether feedback asks for more than a joint has, and not only since that is little.
    return select(abs(torque) > max(actuator.torque, ASTRAY * feedback.stiffness * inertia), 1.0, 0.0)


@law
def _where_it_is(reference, q, v, lost):
    return Reference(select(lost, q, reference.angle), select(lost, v, reference.velocity), reference.acceleration)


@composition
def reanchored(settings, path, response, compliant):
    """Return the path, begun anew where the arm is if it is too far from its reference to be led back by feedback.

    Feedback that saturates would swing for ever about a reference at rest; a new path has the torques that it takes.
    """
    q, v = response.angles, response.velocities
    pulled = times(response.mass, each(_feedback, settings.feedback, path.references, q, v))
    inertias = diagonal(response.mass, pulled)
    lost = (greatest(each(_lost, settings.actuators, settings.feedback, inertias, pulled)) > 0.0) & (compliant < 0.5)
    references = each(_where_it_is, path.references, q, v, lost)
    return PathState(references, select(lost, FREELY, path.length), select(lost, 0.0, path.landed))


@law
def _light(feedback, reference, q, v, inertia, alone, T):
    # What feedback lacks of its least stiffness where a joint is light: it follows its air then, and hardly torques.
    # Damping of more than the joint has `alone`, where others give way, would turn its velocity round in every cycle.
    lacks = max(feedback.least - feedback.stiffness * inertia, 0.0)
    damping = min(lacks * feedback.damping / max(feedback.stiffness, 1.0), CALMED * alone / T)
    return damping * (reference.velocity - v) + lacks * (reference.angle - q)


@law
def _torque(
    joint,
    feedback,
    state,
    free,
    reference,
    goal,
    inertial,
    inertia,
    alone,
    steady,
    load,
    friction,
    k,
    resting,
    around,
    T,
):
    e = reference.angle - free.motion.angle
    beyond = select(e > 0.0, max(e - SLACK, 0.0), min(e + SLACK, 0.0))
    left, beside = goal.angle - reference.angle, free.motion.angle - goal.angle
    past = select(left > 0.0, max(beside, 0.0), select(left < 0.0, min(beside, 0.0), 0.0))
    stiff = max(feedback.stiffness * inertia, feedback.least)
    behind = min(BEHIND, STIFFEST * stiff * CREEP / max(friction, 1e-3))
    sliding = reference.velocity + ONWARD * left + LEAD * goal.acceleration + behind * beyond - PAST * past
    rubs = friction * min(max(sliding / CREEP, -1.0), 1.0)
    opposes = opposing_torque(joint, free, around)
    light = _light(feedback, reference, free.motion.angle, free.motion.velocity, inertia, alone, T)
    moving = inertial + steady - load + rubs + opposes + light
    now, step = gas_torque(joint, state, around), feedback.easing * T
    # Friction bears what is left of losses, unless the joint is to be compliant.
    borne = steady - load + select(k > 0.0, opposes, 0.0)
    eased = min(max(borne, now - step), now + step)
    return select((resting > 0.5) & (abs(free.motion.velocity) < SLOW), eased, moving)


@law
def _zero(x):
    return 0.0 * x


@composition
def _alone(mass, like, whole):
    # Inertia of each joint where the others give way, kg m2.
    W, found, n = slots(inverse(mass, each(_zero, like), whole)), slots(like), len(like)
    for j in range(n):
        found[j] = 1.0 / W[j * n + j]
    return gather(like, found)


@law
def _part(friction, part):
    return part * friction


@composition
def computed_torques(settings, plan, states, response, goals, estimate, asked, T):
    """Return torques of the air at the end of the cycle, N m, a tuple; joints that arrived only bear their loads."""
    resting = plan.resting * (1.0 - asked.led)
    parts, frictions = settings.parts, each(_part, estimate.frictions, settings.parts.friction)
    wanted = each(
        _acceleration, settings.feedback, plan.references, response.angles, response.velocities, parts.feedforward
    )
    inertial, inertia = times(response.mass, wanted), diagonal(response.mass, wanted)
    alone = _alone(response.mass, wanted, settings.shapes.joints)
    return each(
        _torque, settings.plant.joints, settings.feedback, states, response.states, plan.references, goals, inertial,
        inertia, alone, response.steady, estimate.loads, frictions, asked.stiffness, resting, settings.plant.around, T,
    )  # fmt: skip
