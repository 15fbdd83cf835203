"""Analogue sensors behind a converter: offset, noise, range, quantisation.

| symbol | meaning | unit |
|---|---|---|
| y | quantity | rad or Pa |
| low, high | range of sensor and converter | as y |
| lsb | one count of the converter | as y |
"""

from math import floor
from typing import NamedTuple

from layflat.jit import law


class Sensor(NamedTuple):
    """Parameters of one sensor with its converter (units as in the module's table)."""

    low: float
    high: float
    lsb: float
    offset: float
    noise: float


@law
def read_sensor(sensor, y, normal):
    """What the converter reports for the quantity y; `normal` is a sample of the standard normal distribution."""
    y = min(max(y + sensor.offset + sensor.noise * normal, sensor.low), sensor.high)
    return sensor.low + sensor.lsb * floor((y - sensor.low) / sensor.lsb + 0.5)
