"""Analogue sensors with their converter: offset, noise, range, quantisation.

Noise is the same for the same seed.

| symbol | meaning | unit |
|---|---|---|
| y | quantity | rad or Pa |
| low, high | range of sensor and converter | as y |
| lsb | one count of the converter | as y |
"""

from collections.abc import Iterator
from math import floor
from typing import TYPE_CHECKING, NamedTuple

from layflat.jit import law
from layflat.lazy import numpy as np

if TYPE_CHECKING:
    from layflat.arrays import Array


class Sensor(NamedTuple):
    """Parameters of one sensor with its converter (units as in the module's table)."""

    low: float  # lower end of the range, rad or Pa
    high: float  # upper end of the range, rad or Pa
    lsb: float  # one count of the converter, rad or Pa
    offset: float  # rad or Pa
    noise: float  # standard deviation, rad or Pa


@law
def read_sensor(sensor, y, normal):
    """Return the converter's reading of the quantity y; `normal` is a sample of the standard normal distribution."""
    y = min(max(y + sensor.offset + sensor.noise * normal, sensor.low), sensor.high)
    return sensor.low + sensor.lsb * floor((y - sensor.low) / sensor.lsb + 0.5)


NOISE_BLOCK = 256  # samples of noise that are drawn at once where their number is not known


def sensor_noise(seed: int | None, samples: int, joints: int) -> "Array":
    """Return standard normal samples of angle and pressure sensors, (samples, joints, 2).

    Args:
        seed: seed of the generator; None: zeros.
        samples: number of samples.
        joints: number of joints.
    """
    shape = (samples, joints, 2)
    return np.zeros(shape) if seed is None else np.random.default_rng(seed).standard_normal(shape)


def noise_samples(seed: int | None, joints: int) -> "Iterator[Array]":
    """Yield the samples of `sensor_noise`, (joints, 2), one after the other and without end."""
    rng = None if seed is None else np.random.default_rng(seed)
    zeros = np.zeros((NOISE_BLOCK, joints, 2))
    while True:
        yield from zeros if rng is None else rng.standard_normal(zeros.shape)
