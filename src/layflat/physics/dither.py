"""Dither of the valve's driver: a sine that is started at every control cycle and turned on from step to step.

| symbol | meaning | unit |
|---|---|---|
| f | frequency | Hz |
| t, h | time of the cycle's start, step | s |
"""

from math import floor, pi
from typing import NamedTuple

from layflat.jit import law
from layflat.physics.trig import sincos


class Dither(NamedTuple):
    """Sine and cosine in the middle of the coming step, and those of the turn in one step."""

    sine: float
    cosine: float
    turn_sine: float
    turn_cosine: float


@law
def start_dither(f, t, h):
    """Dither of the step that begins at t."""
    cycles = f * (t + 0.5 * h)
    sine, cosine = sincos(2.0 * pi * (cycles - floor(cycles + 0.5)))
    turn_sine, turn_cosine = sincos(2.0 * pi * f * h)
    return Dither(sine, cosine, turn_sine, turn_cosine)


@law
def turn_dither(dither):
    """Dither of the next step."""
    sine, cosine, turn_sine, turn_cosine = dither
    return Dither(
        sine * turn_cosine + cosine * turn_sine, cosine * turn_cosine - sine * turn_sine, turn_sine, turn_cosine
    )


@law
def weakened(dither, share):
    """A share of the dither, in this step and in all that follow."""
    return Dither(share * dither.sine, share * dither.cosine, dither.turn_sine, dither.turn_cosine)


@law
def half_change(dither):
    """Half of what the sine changes by in the coming step, to third order in the step."""
    return 0.5 * dither.cosine * dither.turn_sine
