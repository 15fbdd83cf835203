"""Noise of many runs at once: NumPy's generator written for compiled loops, bit for bit equal to `sensor_noise`.

Threads can't make NumPy generators in parallel, and CUDA devices have none. So this module implements
`np.random.default_rng(seed).standard_normal()`: a PCG64 (oneill2014) starts from a hashed seed (see seeds.py), and the
ziggurat (marsaglia2000) turns its output into normal samples, with the compiler's tables.

A 128-bit number is two of 64 bits, its high and low half. The generator's `state` is such a number, and so is the
`step` that is added to it in each draw.
"""

from math import exp, log1p
from typing import NamedTuple

import numpy as np

from layflat.jit import composition, portable_kernel
from layflat.lanes import select


class Ziggurat(NamedTuple):
    """Layers under the normal density; the tail beyond them begins at `tail`."""

    inside: np.ndarray  # mantissa below which a layer's sample is accepted at once, (256,)
    widths: np.ndarray  # of layers, over 2^52, (256,)
    edges: np.ndarray  # density at the layers' ends, (256,)
    tail: float
    tail_scale: float


U = np.uint64
HALF_BITS, LOW_HALF = U(32), U(0xFFFFFFFF)
FACTOR_HIGH, FACTOR_LOW = U(0x2360ED051FC65DA4), U(0x4385DF649FCCF645)
ZERO_U64, ONE_U64 = U(0), U(1)
SIGN_SHIFT, MANTISSA_SHIFT, UNIFORM_SHIFT, ROTATION_SHIFT, LAST_BIT = U(8), U(9), U(11), U(58), U(63)
LAYER_MASK, MANTISSA_MASK = U(0xFF), U(0xFFFFFFFFFFFFF)
UNIFORM_SCALE = 2.0**-53


@composition
def _multiply_by_factor(high, low):
    """Return the lower 128 bits of a 128-bit number times the generator's factor, by halves."""
    a, b, c, d = low >> HALF_BITS, low & LOW_HALF, FACTOR_LOW >> HALF_BITS, FACTOR_LOW & LOW_HALF
    lowest = b * d
    middle = a * d + (lowest >> HALF_BITS)
    other = b * c + (middle & LOW_HALF)
    carried = a * c + (middle >> HALF_BITS) + (other >> HALF_BITS)
    return carried + high * FACTOR_LOW + low * FACTOR_HIGH, low * FACTOR_LOW


@composition
def _add_128(high, low, other_high, other_low):
    """Return the sum of two 128-bit numbers, by halves, without its carry."""
    total = low + other_low
    return high + other_high + (ONE_U64 if total < low else ZERO_U64), total


@composition
def _next_state(high, low, step_high, step_low):
    """Return the state of a generator, by halves, after one step."""
    high, low = _multiply_by_factor(high, low)
    return _add_128(high, low, step_high, step_low)


@composition
def _seed_state(high, low, step_high, step_low):
    """Return the initial state and the step of a generator, both in halves, from a hashed seed."""
    step_high, step_low = step_high << ONE_U64 | step_low >> LAST_BIT, step_low << ONE_U64 | ONE_U64
    high, low = _add_128(high, low, step_high, step_low)
    high, low = _next_state(high, low, step_high, step_low)
    return high, low, step_high, step_low


@composition
def _output_bits(high, low):
    """Return the output of a state, 64 bits: exclusive or of its halves, rotated right."""
    rotation, mixed = high >> ROTATION_SHIFT, high ^ low
    return mixed >> rotation | mixed << (-rotation & LAST_BIT)


@composition
def _uniform(high, low):
    """Return the output of a state as a uniform sample, 0 to 1."""
    return np.int64(_output_bits(high, low) >> UNIFORM_SHIFT) * UNIFORM_SCALE


@composition
def _draw_normal(high, low, step_high, step_low, ziggurat):
    """Return a standard normal sample, and the generator's state after it."""
    while True:
        high, low = _next_state(high, low, step_high, step_low)
        bits = _output_bits(high, low)
        layer, size = bits & LAYER_MASK, bits >> MANTISSA_SHIFT & MANTISSA_MASK
        # A selected sign may become a branch, taken at random, which costs more than all the rest.
        sign = 1 - 2 * np.int64(bits >> SIGN_SHIFT & ONE_U64)
        number = sign * (np.int64(size) * ziggurat.widths[layer])
        if size < ziggurat.inside[layer]:
            return number, high, low
        if layer == ZERO_U64:
            return _draw_tail(high, low, step_high, step_low, ziggurat, size >> SIGN_SHIFT & ONE_U64 == ONE_U64)
        high, low = _next_state(high, low, step_high, step_low)
        edge = ziggurat.edges[layer]
        height = (ziggurat.edges[layer - ONE_U64] - edge) * _uniform(high, low) + edge
        if height < exp(-0.5 * number * number):
            return number, high, low


@composition
def _draw_tail(high, low, step_high, step_low, ziggurat, negative):
    """Return a sample from the normal density's tail, beyond `ziggurat.tail`, and the generator's state after it."""
    while True:
        high, low = _next_state(high, low, step_high, step_low)
        beyond = -ziggurat.tail_scale * log1p(-_uniform(high, low))
        high, low = _next_state(high, low, step_high, step_low)
        height = -log1p(-_uniform(high, low))
        if height + height > beyond * beyond:
            number = ziggurat.tail + beyond
            return select(negative, -number, number), high, low


@composition
def fill_cycle(streams, ziggurat, noise, k, run):
    """Write a run's standard normal samples of cycle k to `noise`, and advance its generator; zeros without noise.

    Cycles are to be filled in order: k is the place in `noise`, (cycles, joints, sensors, runs), alone.
    """
    high, low, step_high, step_low = streams[0, run], streams[1, run], streams[2, run], streams[3, run]
    for j in range(noise.shape[1]):
        for sensor in range(2):
            number = 0.0
            if streams[4, run] == ONE_U64:
                number, high, low = _draw_normal(high, low, step_high, step_low, ziggurat)
            noise[k, j, sensor, run] = number
    streams[0, run], streams[1, run] = high, low


@composition
def seed_stream(streams, run):
    """Start a run's generator from its hashed seed, in place."""
    state = _seed_state(streams[0, run], streams[1, run], streams[2, run], streams[3, run])
    streams[0, run], streams[1, run], streams[2, run], streams[3, run] = state


@portable_kernel()
def fill_noise(streams, ziggurat, noise):
    """Fill `noise` with the noise of all runs; start and advance their generators `streams` in place."""
    for run in range(noise.shape[3]):
        seed_stream(streams, run)
    for k in range(noise.shape[0]):
        for run in range(noise.shape[3]):
            fill_cycle(streams, ziggurat, noise, k, run)
