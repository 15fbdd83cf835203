"""Stiffness of a joint whose valve is shut, and the supply that brings it about.

Dither lets as much air in as out, so that the pressure in the hoses follows that of the supply. The cam keeps the
torque per pressure the same over the stroke; what is left is how the hoses' volumes change. Losses are springs as well,
the softer the further a joint is turned: stiffness is meant for a turn of `TURN`, to and fro.

| symbol | meaning | unit |
|---|---|---|
| k | stiffness | N m/rad |
| K, V | torque per pressure and volume of a hose | m3/rad, m3 |
| c | volume that a hose gains per pressure | m3/Pa |
| n | polytropic exponent | 1 |
| p, p_s, p_a | absolute pressures in the hoses, of the supply and outside | Pa |
"""

from layflat.jit import law
from layflat.lanes import select, total
from layflat.physics.flow import effective_pressure, upstream_pressure
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.hysteresis import at_rest, torques, turned

EXPONENT = 1.0  # of air that has the time to take the temperature of its hose
TURN = 0.08  # that a stiffness is meant for, rad
LASTS = 1.0  # time that it takes, s
ITERATIONS = 5  # by which the pressure for a stiffness is found: the last changes less than 0.1 %
LEAD = 3.0  # times by which the supply is led beyond a pressure that is not reached
AUTHORITY = 1.0  # of the pressures in the hoses that the supply has at least
NEAR = 0.03  # of a stiffness that is as good as it
LIMIT = 0.01, 0.03  # shares of the supply by which hoses are as good as at its least pressure, and at its greatest


@law
def _of_hose(hose, travel, p, p_a):
    K, np = torque_per_pressure(hose.stroke, travel), EXPONENT * p
    V = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    lost = turned(hose.loss, at_rest(hose.loss), TURN, max(p - p_a, 0.0), LASTS)
    return K * K * np / (V + hose.chamber.compliance * np) + total(torques(hose.loss, lost)) / TURN


@law
def stiffness(joint, q, p_1, p_2, p_a):
    """Return the stiffness of a joint at an angle with these pressures in hoses A and B, N m/rad."""
    a, b = joint.hose_a, joint.hose_b
    return _of_hose(a, a.neutral + q, p_1, p_a) + _of_hose(b, b.neutral - q, p_2, p_a)


@law
def stiffness_of(joint, state, around):
    """Return the stiffness that a joint in a state would have with shut valves, N m/rad."""
    p_1, p_2 = state.hose_a.pressure, state.hose_b.pressure
    return stiffness(joint, state.motion.angle, p_1, p_2, around.ambient_pressure)


@law
def supply_share(joint, state, q, k, around):
    """Return the share of the supply's gauge pressure by which a joint comes to a stiffness, and keeps it."""
    p_s, p_a = around.supply_pressure, around.ambient_pressure
    p = 0.5 * (p_s + p_a)
    for _ in range(ITERATIONS):
        p = p * k / stiffness(joint, q, p, p, p_a)
    p_1, p_2 = state.hose_a.pressure, state.hose_b.pressure
    # Dither moves little air near the pressure that it leads to.
    p = max(p + LEAD * (p - 0.5 * (p_1 + p_2)), p_a)
    # A valve that is fed with less than its hoses have can't control them.
    return (max(_feeding(joint, p, p_a), AUTHORITY * max(p_1, p_2)) - p_a) / (p_s - p_a)


@law
def _feeding(joint, p, p_a):
    # Supply with which dither leaves a pressure in the hoses as it is.
    b = joint.valve.critical_ratio
    return upstream_pressure(effective_pressure(p, p_a, b, joint.valve.laminar_slope), p, b)


@law
def is_near(joint, state, k, around):
    """Return 1 where a joint has a stiffness, or what it can have nearest to it, or none is asked for, else 0."""
    missing, p_a = stiffness_of(joint, state, around) - k, around.ambient_pressure
    p = max(0.5 * (state.hose_a.pressure + state.hose_b.pressure), p_a)
    share = (_feeding(joint, p, p_a) - p_a) / (around.supply_pressure - p_a)
    low, high = LIMIT
    least = (missing > 0.0) & (share < joint.adjustables.supply.least + low)
    most = (missing < 0.0) & (share > 1.0 - high)
    return select((k <= 0.0) | (abs(missing) < NEAR * k) | least | most, 1.0, 0.0)
