"""What the law asks of brakes, dither and supply, and what its model knows of them.

A brake with a calliper is released while the goal moves, and closed otherwise: friction makes landings sure, and lags
what is followed. Dither stops where the arm rests and friction holds it by far: most of the air at rest is for dither.

Where a stiffness is asked for, regulators bring the pressures of a resting arm to those that give it. Then brakes are
released, and once the arm is calm without them dither stops too, and with shut valves the air is all that holds the
arm: it gives way to what pushes it, and comes back. It takes no notice of where it is until another demand comes.

| symbol | meaning | unit |
|---|---|---|
| k | stiffness that is asked for; 0: as it comes | N m/rad |
| T | control cycle | s |
"""

from typing import NamedTuple

from layflat.control.tracking.arrival import Tolerance
from layflat.control.tracking.model import gas_torque, opposing_torque
from layflat.control.tracking.stiffness import is_near, supply_share
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.adjustable import Shares, adjusted
from layflat.physics.algebra import greatest, largest, least

QUIET, FADE = 0.1, 0.1  # time at rest after which dither fades, and time in which it does so, s
SLOW_FADE = (
    0.5  # such a time where the arm is left to its stiffness: the slower, the nearer its centre the spool ends, s
)
SURE = 0.75  # share of its friction that a joint may be loaded with to rest without dither
# Once it does so: the same, and how many times the tolerance it may be off.
STILL_SURE, STILL_INSIDE = 0.95, 1.25
# Time at rest after which an arm that is to be compliant has its brakes released, is no longer led to its goal, has its
# valves shut, and has stayed where it is, so that it is left to its stiffness, s. It is led for long, since air that
# was taken in or let out is warmer or colder than its hose, and pushes the joint as it takes the hose's temperature.
RELEASED, LET_GO, SHUT, COMPLIANT = 0.05, 2.6, 2.7, 4.0
BACK, AGAIN = 10.0, 0.3  # how much faster that time runs back where it is not calm, and for how long it is led then, s
CALM = 0.1  # velocity at which it is taken for calm in between, rad/s
PUMPED = 0.6  # opening to and fro, cycle by cycle, that takes air into or out of both hoses
ANYWHERE = 1e3  # tolerance of a compliant arm, m and rad


class Auxiliary(NamedTuple):
    """What is remembered of it from cycle to cycle."""

    shares: tuple[Shares, ...]  # that the joints have by now
    rested: float  # how long the arm has been at rest with friction to hold it, s
    stiffness: tuple[float, ...]  # k
    way: float  # of what is pumped in this cycle, 1 or -1


class Asked(NamedTuple):
    """What is asked for in a cycle, and what there is in it on average: tuples with an item a joint."""

    shares: tuple[Shares, ...]
    mean: tuple[Shares, ...]
    stiffness: tuple[float, ...]  # k
    pumped: tuple[float, ...]  # openings on top
    controls: float  # 1 where valves are opened as torques want it, 0 where they stay centred
    led: float  # 1 where the arm is led to its goal without brakes, else 0
    compliant: float  # 1 where the arm is left to its stiffness, else 0


@law
def _full(joint):
    whole = 0.0 * joint.brake_torque + 1.0
    return Shares(whole, whole, whole)


@law
def _none(joint):
    return 0.0 * joint.brake_torque


@composition
def begun(joints):
    """Return what is remembered at first: brakes closed, all of dither and supply."""
    none = each(_none, joints)
    return Auxiliary(each(_full, joints), largest(none), none, largest(none) + 1.0)


@law
def _wanted(joint, state, angle, k, around, stays, quiet, released):
    parts, whole = joint.adjustables, 0.0 * joint.brake_torque + 1.0
    dither = select(stays > 0.5, max(1.0 - quiet, parts.dither.least), whole)
    supply = select((stays > 0.5) & (k > 0.0), supply_share(joint, state, angle, max(k, 1e-3), around), whole)
    return Shares(select(released > 0.5, parts.brake.least, whole), dither, min(max(supply, parts.supply.least), whole))


@law
def _adjusted(joint, shares, wanted, T):
    return adjusted(joint.adjustables, shares, wanted, T)


@law
def _pumped(joint, state, k, way, around):
    return PUMPED * way * (1.0 - is_near(joint, state, k, around))


@law
def _change(k, before):
    return k - before


@composition
def asked_of(plant, auxiliary, states, demand, rests, stays, T):
    """Return what is asked for in this cycle, and what is to be remembered but for how long the arm has rested by then.

    Args: whether the goal is at rest, and whether the arm is to stay where it landed (1 or 0).
    """
    k = demand.stiffness
    rested = select((stays > 0.5) & (largest(each(_change, k, auxiliary.stiffness)) == 0.0), auxiliary.rested, 0.0)
    soft = largest(k) > 0.0
    since = rested - select(soft, SHUT, QUIET)
    # A spool is centred before its dither fades, since friction keeps it where it is then.
    controls = select((since > 0.0) & (stays > 0.5), 0.0, 1.0)
    quiet = min(max(since / select(soft, SLOW_FADE, FADE), 0.0), 1.0)
    released = select((soft & (rested > RELEASED)) | (rests < 0.5), 1.0, 0.0)
    wanted = each(_wanted, plant.joints, states, demand.angle, k, plant.around, stays, quiet, released)
    mean, after = each(_adjusted, plant.joints, auxiliary.shares, wanted, T)
    pumps = select(rested > 0.0, 0.0, stays * auxiliary.way)
    pumped = each(_pumped, plant.joints, states, k, pumps, plant.around)
    led = select(soft & (rested > LET_GO), 0.0, released)
    compliant = select(soft & (rested > COMPLIANT), 1.0, 0.0)
    return Asked(wanted, mean, k, pumped, controls, led, compliant), Auxiliary(after, rested, k, -auxiliary.way)


@law
def tolerance_of(margins, auxiliary, asked):
    """Return the `Tolerance` within which the arm may stay: more where noise has hours to seem a motion."""
    widened, compliant = select(auxiliary.rested > QUIET, STILL_INSIDE, 1.0), asked.compliant > 0.5
    usual = margins.tolerance
    return Tolerance(
        select(compliant, ANYWHERE, usual.tip * widened),
        select(compliant, ANYWHERE, usual.angle * widened),
        select(compliant, ANYWHERE, usual.blind * widened),
    )


@law
def _loaded(joint, state, friction, steady, load, around):
    # Torque that friction has to hold, over what it can.
    borne = gas_torque(joint, state, around) - opposing_torque(joint, state, around) - steady + load
    return abs(borne) / max(friction, 1e-6)


@law
def _speed(state):
    return abs(state.motion.velocity)


@composition
def rested_for(plant, auxiliary, asked, states, response, estimate, resting, T):
    """Return how long the arm has been at rest with friction to hold it by far, or calm without, s."""
    k, rested = asked.stiffness, auxiliary.rested
    loaded = each(_loaded, plant.joints, states, estimate.frictions, response.steady, estimate.loads, plant.around)
    most, speed = select(rested > QUIET, STILL_SURE, SURE), largest(each(_speed, states))
    near = least(each(is_near, plant.joints, states, k, plant.around)) > 0.5
    holds = (resting > 0.5) & (speed == 0.0) & (greatest(loaded) < most) & near
    calm = ((resting > 0.5) & (speed < CALM)) | (asked.compliant > 0.5)
    freed = (largest(k) > 0.0) & (rested > RELEASED)
    # Noise may look like a motion for a cycle.
    back = max(rested - BACK * T, min(rested, LET_GO - AGAIN) + T)
    return select(freed, select(calm | (rested < LET_GO), rested + T, back), select(holds, rested + T, 0.0))
