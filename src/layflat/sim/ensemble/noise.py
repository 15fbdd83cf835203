"""Noise of many runs at once: the bits of `sensor_noise`, from numpy's generator written for compiled loops.

Threads can't make generators side by side, and CUDA devices have none of numpy's. So what
`np.random.default_rng(seed).standard_normal()` does stands here: a PCG64 (oneill2014) begins with a hashed seed (see
seeds.py), and what it yields becomes normal by the ziggurat (marsaglia2000), with the tables that the compiler has.

A number of 128 bits is two of 64, its high and its low half. The generator's `state` is such a number, and so is the
`step` that is added to it each time.
"""

from math import exp, log1p
from typing import NamedTuple

import numpy as np

from layflat.jit import composition, kernel
from layflat.lanes import select


class Ziggurat(NamedTuple):
    """Layers under the normal density; the tail beyond them begins at `tail`."""

    inside: np.ndarray  # below this a layer's number is under the density in any case, (256,)
    widths: np.ndarray  # of layers, over 2^52
    edges: np.ndarray  # density at the layers' ends
    tail: float
    tail_scale: float


U = np.uint64
HALF, LOW_HALF = U(32), U(0xFFFFFFFF)
FACTOR_HIGH, FACTOR_LOW = U(0x2360ED051FC65DA4), U(0x4385DF649FCCF645)
ZERO, ONE, EIGHT, NINE, ELEVEN, TURN, ALL, LAYER, MANTISSA = map(U, (0, 1, 8, 9, 11, 58, 63, 0xFF, 0xFFFFFFFFFFFFF))
UNIT = 2.0**-53


@composition
def _times_factor(high, low):
    # 64 times 64 bits are 128, by halves.
    a, b, c, d = low >> HALF, low & LOW_HALF, FACTOR_LOW >> HALF, FACTOR_LOW & LOW_HALF
    lowest = b * d
    middle = a * d + (lowest >> HALF)
    other = b * c + (middle & LOW_HALF)
    carried = a * c + (middle >> HALF) + (other >> HALF)
    return carried + high * FACTOR_LOW + low * FACTOR_HIGH, low * FACTOR_LOW


@composition
def _plus(high, low, other_high, other_low):
    total = low + other_low
    return high + other_high + (ONE if total < low else ZERO), total


@composition
def _stepped(high, low, step_high, step_low):
    high, low = _times_factor(high, low)
    return _plus(high, low, step_high, step_low)


@composition
def _begun(high, low, step_high, step_low):
    # State and step of a generator from what a seed was hashed to.
    step_high, step_low = step_high << ONE | step_low >> ALL, step_low << ONE | ONE
    high, low = _plus(high, low, step_high, step_low)
    high, low = _stepped(high, low, step_high, step_low)
    return high, low, step_high, step_low


@composition
def _shown(high, low):
    # What a state yields: its halves laid over each other and turned.
    turn, mixed = high >> TURN, high ^ low
    return mixed >> turn | mixed << (-turn & ALL)


@composition
def _share(high, low):
    # What a state yields as a number from 0 to 1.
    return np.int64(_shown(high, low) >> ELEVEN) * UNIT


@composition
def _normal(high, low, step_high, step_low, ziggurat):
    # A number of the normal distribution, and the state then.
    while True:
        high, low = _stepped(high, low, step_high, step_low)
        bits = _shown(high, low)
        layer, size = bits & LAYER, bits >> NINE & MANTISSA
        # A sign that is chosen may become a branch, taken at random, which costs more than all the rest.
        sign = 1 - 2 * np.int64(bits >> EIGHT & ONE)
        number = sign * (np.int64(size) * ziggurat.widths[layer])
        if size < ziggurat.inside[layer]:
            return number, high, low
        if layer == ZERO:
            return _tail(high, low, step_high, step_low, ziggurat, size >> EIGHT & ONE == ONE)
        high, low = _stepped(high, low, step_high, step_low)
        edge = ziggurat.edges[layer]
        height = (ziggurat.edges[layer - ONE] - edge) * _share(high, low) + edge
        if height < exp(-0.5 * number * number):
            return number, high, low


@composition
def _tail(high, low, step_high, step_low, ziggurat, negative):
    while True:
        high, low = _stepped(high, low, step_high, step_low)
        beyond = -ziggurat.tail_scale * log1p(-_share(high, low))
        high, low = _stepped(high, low, step_high, step_low)
        height = -log1p(-_share(high, low))
        if height + height > beyond * beyond:
            number = ziggurat.tail + beyond
            return select(negative, -number, number), high, low


@composition
def fill_cycle(streams, ziggurat, noise, k, run):
    """Draw what comes next of a run's noise, in cycle k; its generator goes on from there."""
    high, low, step_high, step_low = streams[0, run], streams[1, run], streams[2, run], streams[3, run]
    for j in range(noise.shape[1]):
        for sensor in range(2):
            number = 0.0
            if streams[4, run] == ONE:
                number, high, low = _normal(high, low, step_high, step_low, ziggurat)
            noise[k, j, sensor, run] = number
    streams[0, run], streams[1, run] = high, low


@composition
def begin(streams, run):
    """Make a run's generator of what its seed was hashed to."""
    begun = _begun(streams[0, run], streams[1, run], streams[2, run], streams[3, run])
    streams[0, run], streams[1, run], streams[2, run], streams[3, run] = begun


@kernel
def fill(streams, ziggurat, noise):
    """Fill in the noise of runs, cycle by cycle, so that what lies side by side is written one after the other."""
    for run in range(noise.shape[3]):
        begin(streams, run)
    for k in range(noise.shape[0]):
        for run in range(noise.shape[3]):
            fill_cycle(streams, ziggurat, noise, k, run)
