"""Commands to brakes, dither and supply, and the stiffness of joints.

A brake with a calliper is released while the goal moves, and closed otherwise: friction helps a joint to land, and
delays a joint that follows. Dither stops while the arm rests and friction holds it safely, since dither consumes most
of the air at rest.

Dither lets as much air in as out, so that the pressure in the hoses follows that of the supply. The cam keeps the
torque per pressure constant over the stroke, so that stiffness comes from the change of the hoses' volumes. Losses act
as springs too, softer for larger rotations: the stiffness of a joint with shut valves is that of a rotation by
`STIFFNESS_ROTATION` back and forth.

If a stiffness is demanded, regulators bring the pressures of a resting arm to the values that yield it. Then the brakes
are released, and once the arm is stationary without them dither stops too, and with shut valves the air alone holds the
arm: it is compliant, and springs back. The law does not control its position until another demand comes.

| symbol | meaning | unit |
|---|---|---|
| k | stiffness; of a demand, 0 for none | N m/rad |
| K, V | torque per pressure and volume of a hose | m3/rad, m3 |
| c | volume that a hose gains per pressure | m3/Pa |
| n | polytropic exponent | 1 |
| p, p_s, p_a | absolute pressures in the hoses, of the supply and outside | Pa |
| T | control cycle | s |
"""

from typing import NamedTuple

from layflat.control.tracking.arrival import Tolerance
from layflat.control.tracking.model import gas_torque, opposing_torque
from layflat.jit import composition, law
from layflat.lanes import each, select, total
from layflat.physics.adjustable import DriveFractions, adjust_fractions
from layflat.physics.algebra import max_item, max_magnitude, min_item
from layflat.physics.flow import effective_pressure, upstream_pressure
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.hysteresis import at_rest, torques, turned

EXPONENT = 1.0  # n: isothermal, since at rest air takes the temperature of its hose
STIFFNESS_ROTATION = 0.08  # rotation for which a stiffness is defined, rad
STIFFNESS_TIME = 1.0  # duration of this rotation, s
PRESSURE_ITERATIONS = 5  # fixed-point iterations for the pressure of a stiffness: the last changes less than 0.1 %
SUPPLY_GAIN = 3.0  # pressure of the supply beyond the goal, per error of the hoses' mean pressure
SUPPLY_RATIO = 1.0  # min pressure of the supply over the greater pressure in the hoses
STIFFNESS_TOLERANCE = 0.03  # relative error of a stiffness that counts as reached
SUPPLY_LIMITS = 0.01, 0.03  # shares of the supply within which the hoses are at its min and at its max pressure


@law
def _hose_stiffness(hose, travel, p, p_a):
    """Return a hose's part of the stiffness of a joint with shut valves, N m/rad: of its air, and of its losses."""
    K, np = torque_per_pressure(hose.stroke, travel), EXPONENT * p
    V = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    lost = turned(hose.loss, at_rest(hose.loss), STIFFNESS_ROTATION, max(p - p_a, 0.0), STIFFNESS_TIME)
    return K * K * np / (V + hose.chamber.compliance * np) + total(torques(hose.loss, lost)) / STIFFNESS_ROTATION


@law
def joint_stiffness(joint, q, p_1, p_2, p_a):
    """Return the stiffness of a joint at an angle with these pressures in hoses A and B, N m/rad."""
    a, b = joint.hose_a, joint.hose_b
    return _hose_stiffness(a, a.neutral + q, p_1, p_a) + _hose_stiffness(b, b.neutral - q, p_2, p_a)


@law
def state_stiffness(joint, state, around):
    """Return the stiffness of a joint in a state if its valve were shut, N m/rad."""
    p_1, p_2 = state.hose_a.pressure, state.hose_b.pressure
    return joint_stiffness(joint, state.motion.angle, p_1, p_2, around.ambient_pressure)


@law
def supply_share(joint, state, q, k, around):
    """Return the share of the supply's gauge pressure that brings a joint at angle q to stiffness k, and keeps it.

    It is not limited to the range of the regulator.
    """
    p_s, p_a = around.supply_pressure, around.ambient_pressure
    p = 0.5 * (p_s + p_a)
    for _ in range(PRESSURE_ITERATIONS):
        p = p * k / joint_stiffness(joint, q, p, p, p_a)
    p_1, p_2 = state.hose_a.pressure, state.hose_b.pressure
    # Dither moves little air near its steady pressure, so the supply overshoots it.
    p = max(p + SUPPLY_GAIN * (p - 0.5 * (p_1 + p_2)), p_a)
    # A valve can't control hoses whose pressure exceeds that of its supply.
    return (max(_feeding_pressure(joint, p, p_a), SUPPLY_RATIO * max(p_1, p_2)) - p_a) / (p_s - p_a)


@law
def _feeding_pressure(joint, p, p_a):
    """Return the supply pressure at which dither keeps the hoses at pressure p, Pa."""
    b = joint.valve.critical_ratio
    return upstream_pressure(effective_pressure(p, p_a, b, joint.valve.laminar_slope), p, b)


@law
def has_stiffness(joint, state, k, around):
    """Return 1 where a joint has stiffness k within `STIFFNESS_TOLERANCE`, or none is demanded (k <= 0), else 0.

    It is 1 as well where the joint is too stiff at the least pressure of its supply, or too soft at the greatest. The
    stiffness is that with its valve shut.
    """
    error, p_a = state_stiffness(joint, state, around) - k, around.ambient_pressure
    p = max(0.5 * (state.hose_a.pressure + state.hose_b.pressure), p_a)
    share = (_feeding_pressure(joint, p, p_a) - p_a) / (around.supply_pressure - p_a)
    low, high = SUPPLY_LIMITS
    at_min = (error > 0.0) & (share < joint.adjustables.supply.least + low)
    at_max = (error < 0.0) & (share > 1.0 - high)
    return select((k <= 0.0) | (abs(error) < STIFFNESS_TOLERANCE * k) | at_min | at_max, 1.0, 0.0)


FADE_DELAY, FADE_TIME = 0.1, 0.1  # time at rest after which dither fades, and duration of the fade, s
COMPLIANT_FADE_TIME = 0.5  # the same duration if a stiffness is demanded: the slower, the better the spool centres, s
MAX_LOAD_RATIO = 0.75  # load on a joint over its friction, up to which dither may stop
QUIET_LOAD_RATIO = 0.95  # the same once dither has stopped
QUIET_TOLERANCE_RATIO = 1.25  # tolerance of the goal once dither has stopped, over the usual one
# A compliant arm is controlled for long, since air that entered or left is warmer or colder than its hose, and moves
# the joint until it takes the hose's temperature.
RELEASE_TIME = 0.05  # time at rest after which the brakes of an arm that is to be compliant are released, s
GUIDED_TIME = 2.6  # time at rest after which the arm is no longer controlled to its goal, s
SHUT_TIME = 2.7  # time at rest after which its valves are shut, s
COMPLIANT_TIME = 4.0  # time at rest after which its position is free, s
REWIND_RATE = 10.0  # rate at which the time at rest runs back while the arm is not stationary
REGUIDED_TIME = 0.3  # time for which it is then controlled again, s
STATIONARY_SPEED = 0.1  # speed below which such an arm is stationary, rad/s
PUMPING_OPENING = 0.6  # opening, alternating from cycle to cycle, that fills or vents both hoses
UNBOUNDED_TOLERANCE = 1e3  # tolerance of a compliant arm, m and rad


class AuxiliaryState(NamedTuple):
    """State of brakes, dither and supply between cycles."""

    shares: tuple[DriveFractions, ...]  # present shares of the joints
    rested: float  # time for which the arm has rested with enough friction to hold it, s
    stiffness: tuple[float, ...]  # k
    direction: float  # of pumping in this cycle, 1 or -1


class AuxiliaryRequest(NamedTuple):
    """Commands of a cycle to brakes, dither and supply: tuples with an item per joint."""

    shares: tuple[DriveFractions, ...]  # commanded
    mean: tuple[DriveFractions, ...]  # actual shares, averaged over the cycle
    stiffness: tuple[float, ...]  # k
    pumped: tuple[float, ...]  # openings that are added to those for torques
    controls: float  # 1 while valves open for torques, 0 while they stay centred
    guided: float  # 1 while the arm is controlled to its goal with released brakes, else 0
    compliant: float  # 1 while the arm's position is free, else 0


@law
def _full(joint):
    """Return full fractions of brake, dither and supply, in the lanes of a joint's parameters."""
    whole = 0.0 * joint.brake_torque + 1.0
    return DriveFractions(whole, whole, whole)


@law
def _none(joint):
    return 0.0 * joint.brake_torque


@composition
def initial_auxiliary(joints):
    """Return the state at the start: brakes closed, full dither and supply."""
    none = each(_none, joints)
    return AuxiliaryState(each(_full, joints), max_magnitude(none), none, max_magnitude(none) + 1.0)


@law
def _requested_shares(joint, state, angle, k, around, stays, quiet, released):
    """Return the fractions of brake, dither and supply (0..1) that the state of the arm calls for, before their rates.

    `stays`, `quiet` and `released` are 1 or 0; k is the demanded stiffness, 0 for none.
    """
    parts, whole = joint.adjustables, 0.0 * joint.brake_torque + 1.0
    dither = select(stays > 0.5, max(1.0 - quiet, parts.dither.least), whole)
    supply = select((stays > 0.5) & (k > 0.0), supply_share(joint, state, angle, max(k, 1e-3), around), whole)
    return DriveFractions(
        select(released > 0.5, parts.brake.least, whole), dither, min(max(supply, parts.supply.least), whole)
    )


@law
def _adjust_shares(joint, shares, command, T):
    return adjust_fractions(joint.adjustables, shares, command, T)


@law
def _pumping_opening(joint, state, k, direction, around):
    return PUMPING_OPENING * direction * (1.0 - has_stiffness(joint, state, k, around))


@law
def _change(k, before):
    return k - before


@composition
def request_auxiliaries(plant, auxiliary, states, demand, rests, stays, T):
    """Return the request of a cycle, and the state after it, whose time at rest `resting_time` then updates.

    Args: model of the plant; state before; states of the joints; demand; whether the goal is at rest, and whether the
    arm is to stay where it landed (1 or 0); T.
    """
    k = demand.stiffness
    rested = select(
        (stays > 0.5) & (max_magnitude(each(_change, k, auxiliary.stiffness)) == 0.0), auxiliary.rested, 0.0
    )
    soft = max_magnitude(k) > 0.0
    since = rested - select(soft, SHUT_TIME, FADE_DELAY)
    # A spool must be centred before its dither fades, since friction then fixes its position.
    controls = select((since > 0.0) & (stays > 0.5), 0.0, 1.0)
    quiet = min(max(since / select(soft, COMPLIANT_FADE_TIME, FADE_TIME), 0.0), 1.0)
    released = select((soft & (rested > RELEASE_TIME)) | (rests < 0.5), 1.0, 0.0)
    shares = each(_requested_shares, plant.joints, states, demand.angle, k, plant.around, stays, quiet, released)
    mean, after = each(_adjust_shares, plant.joints, auxiliary.shares, shares, T)
    pumps = select(rested > 0.0, 0.0, stays * auxiliary.direction)
    pumped = each(_pumping_opening, plant.joints, states, k, pumps, plant.around)
    guided = select(soft & (rested > GUIDED_TIME), 0.0, released)
    compliant = select(soft & (rested > COMPLIANT_TIME), 1.0, 0.0)
    return AuxiliaryRequest(shares, mean, k, pumped, controls, guided, compliant), AuxiliaryState(
        after, rested, k, -auxiliary.direction
    )


@law
def resting_tolerance(margins, auxiliary, request):
    """Return the `Tolerance` within which the arm may stay: wider after a while at rest, unbounded while compliant."""
    widened, compliant = select(auxiliary.rested > FADE_DELAY, QUIET_TOLERANCE_RATIO, 1.0), request.compliant > 0.5
    usual = margins.tolerance
    return Tolerance(
        select(compliant, UNBOUNDED_TOLERANCE, usual.tip * widened),
        select(compliant, UNBOUNDED_TOLERANCE, usual.angle * widened),
        select(compliant, UNBOUNDED_TOLERANCE, usual.blind * widened),
    )


@law
def _friction_load(joint, state, friction, steady, load, around):
    """Return the torque that friction must hold over the torque that it can hold."""
    held = gas_torque(joint, state, around) - opposing_torque(joint, state, around) - steady + load
    return abs(held) / max(friction, 1e-6)


@law
def _speed(state):
    return abs(state.motion.velocity)


@composition
def resting_time(plant, auxiliary, request, states, response, estimate, resting, T):
    """Return the updated time at rest, s.

    With brakes on it counts while friction holds the arm safely, else it is 0; with released brakes it counts while
    the arm is stationary or `GUIDED_TIME` has not passed, and runs back while it moves.

    Args: model of the plant; auxiliary state and request of the cycle; states of the joints after it; free response;
    loads and frictions; whether the arm has arrived at rest (1 or 0); T.
    """
    k, rested = request.stiffness, auxiliary.rested
    loaded = each(
        _friction_load, plant.joints, states, estimate.frictions, response.steady, estimate.loads, plant.around
    )
    max_load, speed = select(rested > FADE_DELAY, QUIET_LOAD_RATIO, MAX_LOAD_RATIO), max_magnitude(each(_speed, states))
    near = min_item(each(has_stiffness, plant.joints, states, k, plant.around)) > 0.5
    holds = (resting > 0.5) & (speed == 0.0) & (max_item(loaded) < max_load) & near
    stationary = ((resting > 0.5) & (speed < STATIONARY_SPEED)) | (request.compliant > 0.5)
    freed = (max_magnitude(k) > 0.0) & (rested > RELEASE_TIME)
    # Noise may look like a motion for a cycle, so that the time runs back and is not reset.
    back = max(rested - REWIND_RATE * T, min(rested, GUIDED_TIME - REGUIDED_TIME) + T)
    return select(freed, select(stationary | (rested < GUIDED_TIME), rested + T, back), select(holds, rested + T, 0.0))
