"""Driver of a valve: the delay of its commands, and the dither that is added to them.

| symbol | meaning | unit |
|---|---|---|
| u | commanded opening in this control cycle, and in the cycles before it | 1 |
| n | delay of driver and solenoid in control cycles, up to `MAX_DELAY_CYCLES` | 1 |
| f | frequency of the dither | Hz |
| t, h | time of the cycle's start, step | s |

A command is held for a whole cycle. Delayed by a fraction of one, the command before it acts during that fraction: the
mean over the cycle is a weighted mean of two neighbours, which has the same area. The dither is a sine that is started
at every control cycle and rotated from step to step.
"""

from math import floor, pi
from typing import NamedTuple

from layflat.jit import law
from layflat.physics.trig import sincos

MAX_DELAY_CYCLES = 3  # upper limit of the delay of a command, control cycles


class CommandDelayLine(NamedTuple):
    """Openings that were commanded one, two and three cycles ago."""

    last_1: float  # one cycle ago, -1..1
    last_2: float  # two cycles ago
    last_3: float  # three cycles ago


ZERO_COMMANDS = CommandDelayLine(0.0, 0.0, 0.0)


@law
def command_weight(n, age):
    """Return the weight of the command of `age` cycles ago under a delay of n cycles."""
    return max(1.0 - abs(n - age), 0.0)


@law
def delay_command(line, u, n):
    """Return the mean opening that acts in this cycle, and the delay line after it."""
    acts = (
        command_weight(n, 0.0) * u
        + command_weight(n, 1.0) * line.last_1
        + command_weight(n, 2.0) * line.last_2
        + command_weight(n, 3.0) * line.last_3
    )
    return acts, CommandDelayLine(u, line.last_1, line.last_2)


class DitherPhasor(NamedTuple):
    """Dither as sine and cosine of its phase in the middle of the coming step, and of the phase increment in a step."""

    sine: float  # of the phase
    cosine: float  # of the phase
    turn_sine: float  # of the phase's increment
    turn_cosine: float  # of the phase's increment


@law
def start_dither(f, t, h):
    """Return the dither of the step that begins at t."""
    cycles = f * (t + 0.5 * h)
    sine, cosine = sincos(2.0 * pi * (cycles - floor(cycles + 0.5)))
    turn_sine, turn_cosine = sincos(2.0 * pi * f * h)
    return DitherPhasor(sine, cosine, turn_sine, turn_cosine)


@law
def advance_dither(dither):
    """Return the dither a step later: its phasor rotated by the phase increment of a step."""
    sine, cosine, turn_sine, turn_cosine = dither
    return DitherPhasor(
        sine * turn_cosine + cosine * turn_sine, cosine * turn_cosine - sine * turn_sine, turn_sine, turn_cosine
    )


@law
def scale_dither(dither, fraction):
    """Return a fraction of the dither, in this step and in all that follow."""
    return DitherPhasor(fraction * dither.sine, fraction * dither.cosine, dither.turn_sine, dither.turn_cosine)


@law
def half_dither_change(dither):
    """Return half the change of the sine in the coming step, to third order in the step."""
    return 0.5 * dither.cosine * dither.turn_sine
