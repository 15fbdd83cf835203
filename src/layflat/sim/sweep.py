"""Slow sweeps at constant pressure: the torque-angle loops of the open-loop rigs.

The joint is turned slowly while its torque is read, so mass and air flow do not matter: torque = K p - losses - brake.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine, parameters
from layflat.sim.slow import sweep_joint


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
    torque, lossless = sweep_joint(hose_a, hose_b, angle, pressure, 0.0, brake * described.brake.torque)
    return Loop(lap, torque[len(lap) :], lossless[len(lap) :])
