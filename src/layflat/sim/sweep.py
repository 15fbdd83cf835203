"""Slow sweeps at constant pressure: the torque-angle loops of the open-loop rigs.

The joint is rotated slowly while its torque is measured, so mass and air flow do not matter: its torque is K p less
losses and friction.
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
from layflat.motion.signal_values import Value, check_integer, read_number
from layflat.sim.slow import sweep_joint

MAX_POINTS = 1_000_000  # of a sweep, in each direction
MAX_SWEEP_PRESSURE = 100e5  # no layflat hose withstands more, Pa
MAX_BRAKE_RATIO = 100.0  # friction torque of the brake over its own


@dataclass(frozen=True)
class HysteresisLoop:
    """Closed torque-angle loop of a slow sweep, forward and back."""

    angle: Array  # rad, (points forward and back,)
    torque: Array  # N m
    lossless: Array  # torque without losses and brake, N m

    @property
    def height(self) -> float:
        """Maximum difference between the torques forward and back at the same angle, N m."""
        half = len(self.angle) // 2
        return float(np.max(np.abs(self.torque[:half] - self.torque[half:][::-1])))

    @property
    def maximum_torque(self) -> float:
        """Maximum torque without losses and brake, N m."""
        return float(np.max(np.abs(self.lossless)))

    @property
    def hysteresis(self) -> float:
        """Height of the loop over the maximum torque."""
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
) -> HysteresisLoop:
    """Sweep a joint back and forth twice with hose A at a gauge pressure and hose B vented; return the second loop.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        joint: name of the joint.
        pressure: gauge pressure in hose A, such as "3 bar"; a number is in Pa.
        centre: centre of the sweep, from mid-stroke; a number is in rad.
        stroke: range of the sweep, from end to end; a number is in rad; default: the working stroke.
        brake: fraction of the brake's torque that acts, 0 to 100.
        points: instants in each direction.

    Raises:
        InputError: there is no such joint, the pressure is not positive or above that of any hose, the sweep leaves
            the mechanical stroke, the brake's fraction is not 0 to 100, or a value has the wrong unit.
    """
    machine = load(machine)
    if not isinstance(joint, str) or joint not in machine.joint:
        right = f"give {' or '.join(machine.joint)}"
        raise InputError(f"unknown joint {shown(joint)}", where="joint", right=right)
    described = machine.joint[joint]
    pressure, centre = read_number(pressure, u.PRESSURE, "pressure"), read_number(centre, u.ANGLE, "centre")
    brake, points = read_number(brake, None, "brake"), check_integer(points, "points", 3, MAX_POINTS)
    hose_a = parameters.hose(described)
    hose_b = hose_a if described.acting == "double" else parameters.missing_hose(hose_a)
    span = described.stops.working_stroke if stroke is None else read_number(stroke, u.ANGLE, "stroke")
    if not 0.0 < pressure <= MAX_SWEEP_PRESSURE:
        right = f'pressure must be positive and at most {MAX_SWEEP_PRESSURE / 1e5:g} bar, such as "3 bar"'
        raise InputError(f"{pressure / 1e5:g} bar is out of range", where="pressure", right=right)
    if not 0.0 < abs(centre) + span / 2 <= described.stops.mechanical_stroke / 2 * (1.0 + 1e-9) or span <= 0.0:
        limit = f"up to {degrees(described.stops.mechanical_stroke):.6g} deg, the mechanical stroke of joint {joint!r}"
        raise InputError(f"{degrees(span):.6g} deg is out of range", where="stroke", right=f"give {limit}")
    if not 0.0 <= brake <= MAX_BRAKE_RATIO:
        raise InputError(
            f"{brake:g} is out of range", where="brake", right=f"give a fraction from 0 to {MAX_BRAKE_RATIO:g}"
        )
    forward = centre + span * (np.linspace(0.0, 1.0, points) - 0.5)
    lap = np.concatenate([forward, forward[::-1]])
    angle = np.concatenate([lap, lap])
    friction, brake_torque = parameters.friction(described), brake * described.brake.torque
    torque, lossless = np.empty_like(angle), np.empty_like(angle)
    sweep_joint(hose_a, hose_b, friction, angle, pressure, 0.0, brake_torque, torque, lossless)
    return HysteresisLoop(lap, torque[len(lap) :], lossless[len(lap) :])
