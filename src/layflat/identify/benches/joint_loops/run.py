"""Torque of a joint that is turned slowly through a measured motion: the laws of slow sweeps (sim/slow.py)."""

from typing import Any, NamedTuple

from layflat.arrays import Array
from layflat.jit import kernel
from layflat.lanes import total
from layflat.physics.friction import level
from layflat.physics.hysteresis import loaded, torques
from layflat.physics.hysteresis.elasto_slip import share_carried, slip
from layflat.physics.joint import Hose
from layflat.sim.slow import Slow, free, unturned


class TurnedJoint(NamedTuple):
    """Both hoses, friction of the shaft, torque of the brake, and what the sensor of the torque adds (N m)."""

    hose_a: Hose
    hose_b: Hose
    friction: Any
    brake: float
    offset: float


class TurnedLog(NamedTuple):
    """Signals of a joint's log: angle (rad), gauge pressures (Pa), the brake's share, and the first torque (N m).

    `give` is the rotation after which the brake slips (rad); without any, a brake would follow the angle's noise.
    """

    angle: Array
    pressure_a: Array
    pressure_b: Array
    brake: Array
    first: float
    give: float


@kernel
def turned_torque(joint, log, torque):
    """Torque of a joint through a log, as measured, N m, into `torque`, (samples,)."""
    hose_a, hose_b, friction, brake = joint.hose_a, joint.hose_b, joint.friction, joint.brake
    q, p_a, p_b = log.angle, log.pressure_a, log.pressure_b
    slow = free(unturned(hose_a, hose_b), hose_a, hose_b, q[0], 0.0, p_a[0], p_b[0])
    a, b = loaded(hose_a.loss, p_a[0], 1.0), loaded(hose_b.loss, p_b[0], 1.0)
    held = level(friction, brake * log.brake[0], 0.0, slow.pull)
    wanted = slow.lossless - (log.first - joint.offset)
    share = share_carried(wanted, total(torques(hose_a.loss, a) + torques(hose_b.loss, b)) + held)
    slow = Slow(1.0, loaded(hose_a.loss, p_a[0], share), loaded(hose_b.loss, p_b[0], share), 0.0, 0.0, 0.0)
    held *= share
    for i in range(len(q)):
        turn = q[i] - q[i - 1] if i > 0 else 0.0
        slow = free(slow, hose_a, hose_b, q[i], turn, p_a[i], p_b[i])
        most = level(friction, brake * log.brake[i], 0.0, slow.pull)
        held = slip(held, most / log.give, most, turn)
        torque[i] = slow.torque - held + joint.offset
