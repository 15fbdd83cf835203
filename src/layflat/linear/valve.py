"""Small-signal model of a valve, averaged over its driver's wave: dither of a spool, pulses of on/off valves.

| symbol | meaning | unit |
|---|---|---|
| u | mean opening that the driver demands | 1 |
| y | opening that acts: u behind the valve's lag | 1 |
| C | mean conductance of a path | m3/(s Pa) |
| a_1, a_2 | coefficients of the lag: a_2 y'' + a_1 y' + y = u | s, s2 |

The valve's own law, wave included, is simulated in the plant's steps. Means over whole periods of the wave at slightly
different openings yield C and dC/du. The lag is that of the response to a small sine: friction of a spool, which dither
turns into a drag, delays of coils, and the inertia of a spool are in it. One frequency yields both coefficients.
Pulses that begin with each control cycle see its held command earlier than on average, by up to 5 deg at 20 Hz, which
no lag describes. Averages suffice because air and arm pass little of the wave on.
"""

from math import ceil, pi
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.physics.valves import at_rest, move, start_wave, turn_wave

SETTLING_TIME = 0.08  # after which a valve has forgotten its start, s
MAX_PERIODS = 20  # periods of the wave over which it is averaged: more where they are no whole number of steps
OPENING_STEP = 1e-3  # change of the opening for derivatives, fraction of full opening
OTHER_STEPS = (1e-4, 2e-2)  # changes of the opening to which a valve has to respond as to that one, likewise
MAX_CURVATURE = 0.05  # difference of its slopes over them, fraction of the greatest one
LAG_FREQUENCY = 20.0  # at which the lag is fitted, Hz: the upper end of the band of interest
LAG_PERIODS = 2  # of that frequency


class PathConductances(NamedTuple):
    """Conductances of the path that fills hose A and vents hose B, and of the reverse."""

    fills: float  # m3/(s Pa)
    vents: float  # m3/(s Pa)


class LinearValve(NamedTuple):
    """Averaged valve near an opening u (units as in the module's table)."""

    opening: float  # u
    state: Any  # of the valve's law, when the wave begins anew
    wave: Array  # conductances over whole periods, (steps, 2)
    rises: Array  # dC/du in the same steps, (steps, 2)
    other_slopes: Array  # the same over `OTHER_STEPS`, (2, 2)
    lag: tuple[float, float]  # a_1, a_2

    @property
    def paths(self) -> PathConductances:
        """Mean conductances."""
        return PathConductances(*self.wave.mean(axis=0).tolist())

    @property
    def slopes(self) -> PathConductances:
        """Mean of dC/du."""
        return PathConductances(*self.rises.mean(axis=0).tolist())


def settle_valve(valve: Any, opening: float, h: float, start: Any = None) -> tuple[Any, Array]:
    """Return the state of a valve driven to an opening for long, and its conductances in the period that follows.

    Args:
        valve: parameters.
        opening: demanded of the driver, -1 to 1.
        h: step, s.
        start: its state before, when the wave begins anew; default: at rest.

    Returns:
        The state when the wave begins anew, and conductances (steps, 2), m3/(s Pa), over whole periods.
    """
    steps = _averaging_steps(valve, h)
    settling = steps * ceil(SETTLING_TIME / (h * steps))
    state, history = _simulate(valve, np.full(settling + steps, opening), h, start)
    return state, history[settling:]


def mean_paths(valve: Any, opening: float, h: float) -> PathConductances:
    """Return the mean conductances of a valve driven to an opening for long.

    Args:
        valve: parameters.
        opening: demanded of the driver, -1 to 1.
        h: step, s.
    """
    return PathConductances(*settle_valve(valve, opening, h)[1].mean(axis=0).tolist())


def linearize_valve(valve: Any, opening: float, h: float) -> LinearValve:
    """Return the small-signal model of a valve of any kind near an opening.

    Args:
        valve: parameters.
        opening: demanded of the driver, -1 to 1.
        h: step, s.
    """
    state, wave = settle_valve(valve, opening, h)
    rises, *others = (_wave_slopes(valve, state, opening, size, h) for size in (OPENING_STEP, *OTHER_STEPS))
    slopes = rises.mean(axis=0)
    lag = _fit_lag(valve, opening, slopes, h) if slopes.any() else (0.0, 0.0)
    return LinearValve(opening, state, wave, rises, np.array(others).mean(axis=1), lag)


def check_response(name: str, valve: LinearValve) -> None:
    """Check that a valve responds to small changes of its opening, and in proportion to them.

    Args:
        name: joint of the valve, for messages.
        valve: its model.

    Raises:
        InputError: it does not, as pulses too short for a coil, or a spool that sticks.
    """
    slopes = np.array(valve.slopes)
    if not slopes.any():
        what = f"the valve of joint {name!r} does not respond at an opening of {valve.opening:.3g}"
        right = "it sticks, or is inside its dead band: give it dither, or the joint another speed or other pressures"
        raise InputError(what, where="linearize", right=right)
    if abs(slopes - valve.other_slopes).max() > MAX_CURVATURE * abs(slopes).max():
        what = f"the valve of joint {name!r} does not respond in proportion at an opening of {valve.opening:.3g}"
        right = "its dead band or its shortest pulse is near: give another speed, other pressures, or another valve"
        raise InputError(what, where="linearize", right=right)


def _wave_slopes(valve: Any, state: Any, opening: float, size: float, h: float) -> Array:
    """Return dC/du of both paths in a period, (steps, 2), by differences over a change of the opening either way."""
    forward, back = (settle_valve(valve, opening + sign * size, h, state)[1] for sign in (1.0, -1.0))
    return (forward - back) / (2.0 * size)


def _averaging_steps(valve: Any, h: float) -> int:
    """Return the number of steps closest to a whole number of periods of the valve's wave."""
    frequency = getattr(valve, "dither_frequency", None) or getattr(valve, "frequency", None)
    if not frequency:
        return 1
    steps = np.arange(1, MAX_PERIODS + 1) / (frequency * h)
    best = int(np.argmin(np.round(np.abs(steps / np.round(steps) - 1.0), 9)))
    return max(1, round(float(steps[best])))


def _simulate(valve: Any, openings: Array, h: float, start: Any = None) -> tuple[Any, Array]:
    """Return the state at the end, and the mean conductances in every step of h seconds, (steps, 2), at openings."""
    state, wave = at_rest(valve) if start is None else start, start_wave(valve, 0.0, h)
    paths = np.empty((len(openings), 2))
    for k, opening in enumerate(openings.tolist()):
        state, *paths[k] = move(valve, state, opening, wave, h)
        wave = turn_wave(valve, wave)
    return state, paths


def _fit_lag(valve: Any, opening: float, slopes: Array, h: float) -> tuple[float, float]:
    """Return a_1 and a_2 from the response of the conductances to a sine at `LAG_FREQUENCY`."""
    w, count = 2.0 * pi * LAG_FREQUENCY, ceil(LAG_PERIODS / (LAG_FREQUENCY * h))
    settling = ceil(SETTLING_TIME / h)
    times = h * (np.arange(settling + count) + 0.5)
    sine = OPENING_STEP * np.sin(w * times)
    change = _simulate(valve, opening + sine, h)[1] - _simulate(valve, opening - sine, h)[1]
    response = np.exp(-1j * w * times[settling:]) @ change[settling:] * (1j / (count * OPENING_STEP))
    ratio = complex(slopes @ response / (slopes @ slopes))
    inverse = 1.0 / ratio
    return inverse.imag / w, (1.0 - inverse.real) / (w * w)
