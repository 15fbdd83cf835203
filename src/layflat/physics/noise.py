"""Noise of the sensors: samples of the standard normal distribution, the same for the same seed."""

from collections.abc import Iterator

import numpy as np

from layflat.arrays import Array

NOISE_BLOCK = 256  # samples of noise that are drawn at once where nobody knows how many there will be


def sensor_noise(seed: int | None, samples: int, joints: int) -> Array:
    """Standard normal samples of angle and pressure sensors, (samples, joints, 2); zeros without a seed."""
    shape = (samples, joints, 2)
    return np.zeros(shape) if seed is None else np.random.default_rng(seed).standard_normal(shape)


def noise_samples(seed: int | None, joints: int) -> Iterator[Array]:
    """What `sensor_noise` gives, a sample (joints, 2) after the other and without end."""
    rng = None if seed is None else np.random.default_rng(seed)
    calm = np.zeros((NOISE_BLOCK, joints, 2))
    while True:
        yield from calm if rng is None else rng.standard_normal(calm.shape)
