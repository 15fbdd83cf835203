"""Amplitude and frequency of dither over the friction of the spool: accuracy and ripple."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layflat.experiments.questions.tables import Array, listed, moves_of
from layflat.physics.valves.spool import SpoolValvePart
from layflat.plot.maps import draw_map, edges
from layflat.plot.style import LINES, QUIET
from layflat.plot.style import figure as new_figure
from layflat.study import Study

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

TITLE = "How much dither, and how fast?"
CAPTION = (
    "Left: how far the braked joint is from its goal at rest, with dither near 50 Hz, by the friction of the "
    "spool; middle: how much it still moves. Right: the error over frequency and amplitude, at the friction that the "
    "paper's arm is given; the cross is the paper's frequency, with the calibrated amplitude."
)
FRICTION, AMPLITUDE, FREQUENCY = "valve.friction", "valve.dither.amplitude", "valve.dither.frequency"
"""Columns of the table."""
AROUND = (40.0, 60.0)
"""Frequencies that count as about 50 Hz."""
GOOD = 1.5
"""An amplitude is enough where the error is at most so many times the least that any amplitude reaches."""
FAST = (130.0, 170.0)
"""Frequencies that count as fast."""
WORTH, TINY = 1.5, 1e-6
"""Dither is worth it where it makes the error or the ripple so many times smaller; no number, deg."""


def _measured(frame: pandas.DataFrame) -> pandas.DataFrame:
    """Runs with their error at rest and their ripple (deg), means over all moves."""
    moves = moves_of(frame)
    error = np.degrees(frame[[f"steady_error.{move}" for move in moves]].abs().mean(axis=1))
    ripple = np.degrees(frame[[f"ripple.{move}" for move in moves]].mean(axis=1))
    return frame.assign(error=error, ripple=ripple)


def _by_amplitude(
    runs: pandas.DataFrame, column: str, friction: float, band: tuple[float, float] = AROUND
) -> tuple[Array, Array]:
    """Amplitudes, and the mean of a column at frequencies of a band."""
    own = runs[(runs[FRICTION] == friction) & runs[FREQUENCY].between(*band)]
    mean = own.groupby(AMPLITUDE)[column].mean()
    return mean.index.to_numpy(dtype=float), mean.to_numpy(dtype=float)


def _enough(amplitudes: Array, errors: Array) -> float:
    """The least amplitude from which on the error stays near the least."""
    bad = np.flatnonzero(errors > GOOD * errors.min())
    return float(amplitudes[min(bad[-1] + 1, len(amplitudes) - 1)]) if len(bad) else float(amplitudes[0])


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Error and ripple by amplitude; a map of the error over frequency and amplitude."""
    runs, valve = _measured(frame), study.machine.valve
    assert isinstance(valve, SpoolValvePart)
    with new_figure(1, 3, width=10.4, height=4.0, above=0.62) as (made, (error, ripple, both)):
        for order, friction in enumerate(np.sort(frame[FRICTION].unique())):
            style = {**LINES[order], "marker": "os^D"[order % 4], "ms": 3.5, "label": f"{100 * friction:g} %"}
            for axes, column in ((error, "error"), (ripple, "ripple")):
                amplitudes, values = _by_amplitude(runs, column, friction)
                axes.plot(100 * amplitudes, values, **style)
        for axes, what in ((error, "Error at rest (deg)"), (ripple, "Ripple at rest (deg, peak to peak)")):
            axes.set_ylabel(what)
            axes.set_xlabel("Amplitude of dither (% of full opening)")
            axes.set_ylim(bottom=0.0)
            axes.axvline(100 * valve.dither.amplitude, **QUIET)
        ripple.legend(title="friction of the spool\n(% of full opening)", loc="upper right")
        own = runs[runs[FRICTION] == _nearest(frame[FRICTION], valve.friction)]
        wide = own.groupby([AMPLITUDE, FREQUENCY])["error"].mean().unstack()
        x, y = (axis.to_numpy(dtype=float) for axis in (wide.columns, wide.index))
        z = wide.to_numpy(dtype=float)
        draw_map(both, x, 100 * y, z, "Error at rest (deg)", low=0.0, high=float(np.quantile(z, 0.95)))
        both.plot(valve.dither.frequency, 100 * valve.dither.amplitude, "+", color="#c23b4e", ms=12, mew=2.5)
        both.set_xscale("log")
        both.set_xticks([20, 50, 100, 200], ["20", "50", "100", "200"])
        both.minorticks_off()
        both.set_xlim(*edges(x, log=True))
        both.set_ylim(*edges(100 * y))
        both.set_xlabel("Frequency of dither (Hz)")
        both.set_ylabel("Amplitude (% of full opening)")
    return made


def _nearest(column: pandas.Series, value: float) -> float:
    values = column.unique()
    return float(values[np.argmin(np.abs(values - value))])


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """What dither gains, how much of it is enough, at which frequency, and what air it takes."""
    runs, valve = _measured(frame), study.machine.valve
    assert isinstance(valve, SpoolValvePart)
    frictions = np.sort(frame[FRICTION].unique())
    worst = float(frictions[-1])
    (_, errors), (_, ripples) = (_by_amplitude(runs, column, worst) for column in ("error", "ripple"))
    sentences = [
        f"With a spool whose friction is {100 * worst:g} % of full opening the joint rests {errors[0]:.2f} deg off and "
        f"goes on moving by {ripples[0]:.2f} deg without dither; with dither near 50 Hz it is {errors.min():.2f} and "
        f"{ripples.min():.2f} deg at best."
    ]
    if max(errors[0] / max(errors.min(), TINY), ripples[0] / max(ripples.min(), TINY)) < WORTH:
        sentences.append("Dither makes little difference.")
    else:
        enough = [
            f"{100 * _enough(*_by_amplitude(runs, 'error', friction)):.0f} % with {100 * friction:g} % of friction"
            for friction in frictions[frictions > 0.0]
        ]
        sentences.append(f"Enough near 50 Hz is an amplitude of {listed(enough)}.")
    own = _nearest(frame[FRICTION], valve.friction)
    slow, fast = (_enough(*_by_amplitude(runs, "error", own, band)) for band in (AROUND, FAST))
    more = f"takes {100 * fast:.0f} % where {100 * slow:.0f} % do near 50 Hz" if fast > slow else "does it with no more"
    amplitudes, air = _by_amplitude(runs, "air_used", own)
    given = int(np.argmin(np.abs(amplitudes - valve.dither.amplitude)))
    change = 100.0 * (air[given] / air[0] - 1.0)
    sentences.append(f"A dither of {FAST[0]:g} to {FAST[1]:g} Hz {more}, with {100 * own:g} % of friction.")
    sentences.append(
        f"The arm's own amplitude, {100 * amplitudes[given]:.0f} %, takes {abs(change):.0f} % "
        f"{'more' if change >= 0.0 else 'less'} air than none in the same moves."
    )
    return " ".join(sentences)
