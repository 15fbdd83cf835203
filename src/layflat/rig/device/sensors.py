"""Converters that may fail: what they report of what the sensors say."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine, parameters
from layflat.physics.sensor import Sensor, read_sensor

Array = NDArray[np.float64]

ANGLE, PRESSURE = 0, 1
"""The two sensors of a joint."""


class Converters:
    """Sound converters, until told otherwise.

    Args:
        machine: whose sensors they read.
    """

    def __init__(self, machine: Machine) -> None:
        joints = parameters.joints(machine)
        self._rails = [tuple(map(rails, (joint.angle_sensor, joint.pressure_sensor))) for joint in joints]
        self._fixed: dict[tuple[int, int], float | None] = {}

    def fix_low(self, joint: int, sensor: int) -> None:
        """A converter reports the low end of its range."""
        self._fixed[joint, sensor] = self._rails[joint][sensor][0]

    def fix_high(self, joint: int, sensor: int) -> None:
        """A converter reports the high end of its range."""
        self._fixed[joint, sensor] = self._rails[joint][sensor][1]

    def freeze(self, joint: int, sensor: int) -> None:
        """A converter goes on to report its next sample."""
        self._fixed[joint, sensor] = None

    def mend(self, joint: int, sensor: int) -> None:
        """A converter reports what its sensor says."""
        self._fixed.pop((joint, sensor), None)

    def convert(self, angles: Array, pressures: Array) -> None:
        """Put in place what failed converters report."""
        samples = (angles, pressures)
        for (joint, sensor), value in self._fixed.items():
            if value is None:
                self._fixed[joint, sensor] = float(samples[sensor][joint])
            else:
                samples[sensor][joint] = value


def rails(sensor: Sensor) -> tuple[float, float]:
    """What a converter reports at both ends of its range."""
    read: Callable[..., float] = read_sensor
    return read(sensor, -1e9, 0.0), read(sensor, 1e9, 0.0)
