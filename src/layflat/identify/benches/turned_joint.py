"""Torque of a joint that is moved slowly through a measured motion, by the laws of slow sweeps (sim/slow.py)."""

from typing import Any, NamedTuple

from layflat.arrays import Array
from layflat.jit import kernel
from layflat.lanes import total
from layflat.physics.friction import slip_torque
from layflat.physics.hysteresis import loaded, torques
from layflat.physics.hysteresis.elasto_slip import carried_fraction, slip_element
from layflat.physics.joint import HoseParameters
from layflat.sim.slow import SlowSweep, initial_sweep, turn_frictionless


class TurnedJoint(NamedTuple):
    """Parameters of a joint whose motion is measured."""

    hose_a: HoseParameters
    hose_b: HoseParameters
    friction: Any  # of the shaft
    brake: float  # torque of the brake at full duty, N m
    offset: float  # of the torque sensor, N m


class TurnedLog(NamedTuple):
    """Signals of a joint's log, (samples,) each."""

    angle: Array  # rad
    pressure_a: Array  # gauge, Pa
    pressure_b: Array
    brake: Array  # duty, 0..1
    first: float  # first measured torque, N m
    slip_angle: float  # rotation after which the brake slips, rad; a brake without any would follow the angle's noise


@kernel
def turned_torque(joint, log, torque):
    """Write the torque that a sensor measures on a joint through a log, N m, to `torque`, (samples,).

    Losses and friction begin with the common fraction of their limits that explains the first measured torque.
    """
    hose_a, hose_b, friction, brake = joint.hose_a, joint.hose_b, joint.friction, joint.brake
    q, p_a, p_b = log.angle, log.pressure_a, log.pressure_b
    slow = turn_frictionless(initial_sweep(hose_a, hose_b), hose_a, hose_b, q[0], 0.0, p_a[0], p_b[0])
    a, b = loaded(hose_a.loss, p_a[0], 1.0), loaded(hose_b.loss, p_b[0], 1.0)
    held = slip_torque(friction, brake * log.brake[0], 0.0, slow.pull)
    carried = slow.lossless - (log.first - joint.offset)
    share = carried_fraction(carried, total(torques(hose_a.loss, a) + torques(hose_b.loss, b)) + held)
    slow = SlowSweep(1.0, loaded(hose_a.loss, p_a[0], share), loaded(hose_b.loss, p_b[0], share), 0.0, 0.0, 0.0)
    held *= share
    for i in range(len(q)):
        rotation = q[i] - q[i - 1] if i > 0 else 0.0
        slow = turn_frictionless(slow, hose_a, hose_b, q[i], rotation, p_a[i], p_b[i])
        limit = slip_torque(friction, brake * log.brake[i], 0.0, slow.pull)
        held = slip_element(held, limit / log.slip_angle, limit, rotation)
        torque[i] = slow.torque - held + joint.offset
