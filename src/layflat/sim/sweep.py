"""Slow sweeps at constant pressure: the torque-angle loops of the open-loop rigs.

The joint is turned slowly while its torque is read, so mass and air flow do not matter: its torque is K p less losses
and friction.
"""

from dataclasses import dataclass
from math import degrees
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine, load, parameters
from layflat.motion.signal_values import Value, check_whole, read_number
from layflat.sim.slow import sweep_joint

MAX_POINTS = 1_000_000  # of a sweep, each way
HIGHEST = 100e5  # no layflat hose bears more, Pa
MOST_BRAKE = 100.0  # times the brake's own torque


@dataclass(frozen=True)
class Loop:
    """A closed torque-angle loop, forward and back: angles (rad), torques (N m), and these without losses and brake."""

    angle: Array
    torque: Array
    lossless: Array

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
    machine: str | Path | Machine,
    joint: str,
    pressure: Value,
    *,
    centre: Value = 0.0,
    stroke: Value | None = None,
    brake: float = 1.0,
    points: int = 1001,
) -> Loop:
    """Turn a joint to and fro with hose A at a gauge pressure (Pa) and hose B vented, until the loop repeats.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        joint: name of the joint.
        pressure: gauge pressure in hose A, such as "3 bar"; a number is in Pa.
        centre: middle of the sweep from mid-stroke; a number is in rad.
        stroke: from end to end; default: the working stroke.
        brake: share of the brake's torque.
        points: instants each way.

    Raises:
        InputError: there is no such joint, the pressure is not positive or bursts any hose, the stroke exceeds the
            mechanical one, the brake's share is negative, or a value is of another kind.
    """
    machine = load(machine)
    if not isinstance(joint, str) or joint not in machine.joint:
        right = f"give {' or '.join(machine.joint)}"
        raise InputError(f"unknown joint {shown(joint)}", where="joint", right=right)
    described = machine.joint[joint]
    pressure, centre = read_number(pressure, u.PRESSURE, "pressure"), read_number(centre, u.ANGLE, "centre")
    brake, points = read_number(brake, None, "brake"), check_whole(points, "points", 3, MAX_POINTS)
    hose_a = parameters.hose(described)
    hose_b = hose_a if described.acting == "double" else parameters.no_hose(hose_a)
    reach = described.stops.working_stroke if stroke is None else read_number(stroke, u.ANGLE, "stroke")
    if not 0.0 < pressure <= HIGHEST:
        right = f'pressure must be positive and at most {HIGHEST / 1e5:g} bar, such as "3 bar"'
        raise InputError(f"{pressure / 1e5:g} bar is out of range", where="pressure", right=right)
    if not 0.0 < abs(centre) + reach / 2 <= described.stops.mechanical_stroke / 2 * (1.0 + 1e-9) or reach <= 0.0:
        most = f"up to {degrees(described.stops.mechanical_stroke):.6g} deg, the mechanical stroke of joint {joint!r}"
        raise InputError(f"{degrees(reach):.6g} deg is out of range", where="stroke", right=f"give {most}")
    if not 0.0 <= brake <= MOST_BRAKE:
        raise InputError(f"{brake:g} is out of range", where="brake", right=f"give a share from 0 to {MOST_BRAKE:g}")
    way = centre + reach * (np.linspace(0.0, 1.0, points) - 0.5)
    lap = np.concatenate([way, way[::-1]])
    angle = np.concatenate([lap, lap])
    friction, held = parameters.friction(described), brake * described.brake.torque
    torque, lossless = sweep_joint(hose_a, hose_b, friction, angle, pressure, 0.0, held)
    return Loop(lap, torque[len(lap) :], lossless[len(lap) :])
