"""Slow sweeps at constant pressure: the torque-angle loops of the open-loop rigs.

The joint is turned slowly while its torque is read, so mass and air flow do not matter: torque = K p - losses - brake.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.jit import kernel, law
from layflat.lanes import select
from layflat.machine import Machine, parameters
from layflat.physics.hose import torque_per_pressure
from layflat.physics.loss import slip_all


@dataclass(frozen=True)
class Loop:
    """A closed torque-angle loop, forward and back: angles (rad), torques (N m), and these without losses and brake."""

    angle: NDArray[np.float64]
    torque: NDArray[np.float64]
    lossless: NDArray[np.float64]

    @property
    def height(self) -> float:
        """Greatest difference of torque between the way forward and the way back, N m."""
        half = len(self.angle) // 2
        return float(np.max(np.abs(self.torque[:half] - self.torque[half:][::-1])))

    @property
    def maximum_torque(self) -> float:
        """Greatest torque without losses and brake, N m."""
        return float(np.max(np.abs(self.lossless)))

    @property
    def hysteresis(self) -> float:
        """Height over maximum torque."""
        return self.height / self.maximum_torque


class Slow(NamedTuple):
    """A joint on a slow sweep: its way, the torques of the slipping elements, torque without losses, and with (N m)."""

    way: float
    slip_a: tuple[float, float, float]
    slip_b: tuple[float, float, float]
    lossless: float
    torque: float


UNTURNED = Slow(1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0)


@law
def turned(slow, hose_a, hose_b, q, turn, p_a, p_b, brake):  # type: ignore[no-untyped-def]
    """The joint turned by `turn` to angle q, at constant gauge pressures."""
    way = select(turn > 0.0, 1.0, select(turn < 0.0, -1.0, slow.way))
    slip_a = slip_all(hose_a.loss, slow.slip_a[0], slow.slip_a[1], slow.slip_a[2], turn, p_a)
    slip_b = slip_all(hose_b.loss, slow.slip_b[0], slow.slip_b[1], slow.slip_b[2], turn, p_b)
    pull = torque_per_pressure(hose_a.stroke, hose_a.neutral + q) * p_a
    push = torque_per_pressure(hose_b.stroke, hose_b.neutral - q) * p_b
    lossless = pull - push
    lost = slip_a[0] + slip_a[1] + slip_a[2] + slip_b[0] + slip_b[1] + slip_b[2]
    return Slow(way, slip_a, slip_b, lossless, lossless - lost - way * brake)


@kernel
def _sweep(hose_a, hose_b, q, p_a, p_b, brake):  # type: ignore[no-untyped-def]
    torque, lossless = np.empty_like(q), np.empty_like(q)
    slow = UNTURNED
    for i in range(len(q)):
        turn = q[i] - q[i - 1] if i > 0 else 0.0
        slow = turned(slow, hose_a, hose_b, q[i], turn, p_a, p_b, brake)
        torque[i], lossless[i] = slow.torque, slow.lossless
    return torque, lossless


def sweep(
    machine: Machine,
    joint: str,
    pressure: float,
    *,
    centre: float = 0.0,
    stroke: float | None = None,
    brake: float = 1.0,
    points: int = 1001,
) -> Loop:
    """Turn a joint to and fro with hose A at a gauge pressure (Pa) and hose B vented, until the loop repeats.

    Args:
        machine: the machine.
        joint: name of the joint.
        pressure: gauge pressure in hose A, Pa.
        centre: middle of the sweep, rad from mid-stroke.
        stroke: from end to end, rad; the working stroke where not given.
        brake: share of the brake's torque.
        points: instants each way.
    """
    described = machine.joint[joint]
    hose_a = parameters.hose(described)
    hose_b = hose_a if described.acting == "double" else parameters.NO_HOSE
    reach = described.stops.working_stroke if stroke is None else stroke
    way = centre + reach * (np.linspace(0.0, 1.0, points) - 0.5)
    lap = np.concatenate([way, way[::-1]])
    angle = np.concatenate([lap, lap])
    torque, lossless = _sweep(hose_a, hose_b, angle, pressure, 0.0, brake * described.brake.torque)
    return Loop(lap, torque[len(lap) :], lossless[len(lap) :])
