"""Amplitude and frequency of dither over the friction of the spool: accuracy and ripple."""

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.questions.tables import listed, moves_of
from layflat.physics.valves.spool import SpoolValvePart
from layflat.plot.bars_and_maps import draw_map, edges
from layflat.plot.style import LINES, mark
from layflat.plot.style import figure as new_figure
from layflat.study import Study

FRICTION, AMPLITUDE, FREQUENCY = "valve.friction", "valve.dither.amplitude", "valve.dither.frequency"
"""Columns of the table."""
AROUND, FAST = (40.0, 60.0), (130.0, 170.0)  # frequencies that count as about 50 Hz, and as fast
GOOD = 1.5  # an amplitude is enough where the error is at most so many times the least that any amplitude reaches
WORTH, TINY = 1.5, 1e-6
"""Dither is worth it where it makes the error or the ripple so many times smaller; no number, deg."""


def _measured(study: Study, frame: pandas.DataFrame) -> tuple[pandas.DataFrame, SpoolValvePart, float]:
    """Runs with error at rest and ripple (deg, means over all moves), the arm's valve, and the friction nearest its."""
    moves, valve, frictions = moves_of(frame), study.machine.valve, frame[FRICTION].unique()
    assert isinstance(valve, SpoolValvePart)
    error = np.degrees(frame[[f"steady_error.{move}" for move in moves]].abs().mean(axis=1))
    ripple = np.degrees(frame[[f"ripple.{move}" for move in moves]].mean(axis=1))
    own = float(frictions[np.argmin(np.abs(frictions - valve.friction))])
    return frame.assign(error=error, ripple=ripple), valve, own


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
    """Draw error and ripple by amplitude, and a map of the error over frequency and amplitude."""
    runs, valve, own = _measured(study, frame)
    wide = runs[runs[FRICTION] == own].groupby([AMPLITUDE, FREQUENCY])["error"].mean().unstack()
    x, y, z = (each.to_numpy(dtype=float) for each in (wide.columns, wide.index, wide))
    labels = {"error": "Error at rest (deg)", "ripple": "Ripple at rest (deg, peak to peak)"}
    with new_figure(1, 3, width=10.4, height=4.0, above=0.62) as (made, (error, ripple, both)):
        for axes, (column, label) in zip((error, ripple), labels.items(), strict=True):
            for order, friction in enumerate(np.sort(frame[FRICTION].unique())):
                amplitudes, values = _by_amplitude(runs, column, friction)
                style = {**LINES[order], "marker": "os^D"[order % 4], "ms": 3.5}
                axes.plot(100 * amplitudes, values, label=f"{100 * friction:g} %", **style)
            axes.set(xlabel="Amplitude of dither (% of full opening)", ylabel=label, ylim=(0.0, None))
            mark(axes, 100 * valve.dither.amplitude, "built in", upright=True)
        ripple.legend(title="friction of the spool\n(% of full opening)", loc="upper right")
        draw_map(both, x, 100 * y, z, labels["error"], low=0.0, high=float(np.quantile(z, 0.95)))
        both.plot(valve.dither.frequency, 100 * valve.dither.amplitude, "+", color="#c23b4e", ms=12, mew=2.5)
        both.set_xscale("log")
        both.set_xticks([20, 50, 100, 200], ["20", "50", "100", "200"])
        both.minorticks_off()
        both.set(xlim=edges(x, log=True), ylim=edges(100 * y))
        both.set(xlabel="Frequency of dither (Hz)", ylabel="Amplitude (% of full opening)")
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Say what dither gains, how much of it is enough, at which frequency, and what air it takes."""
    runs, valve, own = _measured(study, frame)
    frictions = np.sort(frame[FRICTION].unique())
    worst = float(frictions[-1])
    (_, errors), (_, ripples) = (_by_amplitude(runs, column, worst) for column in ("error", "ripple"))
    gains = "Dither makes little difference."
    if max(errors[0] / max(errors.min(), TINY), ripples[0] / max(ripples.min(), TINY)) >= WORTH:
        enough = [
            f"{100 * _enough(*_by_amplitude(runs, 'error', friction)):.0f} % with {100 * friction:g} % of friction"
            for friction in frictions[frictions > 0.0]
        ]
        gains = f"Enough near 50 Hz is an amplitude of {listed(enough)}."
    slow, fast = (_enough(*_by_amplitude(runs, "error", own, band)) for band in (AROUND, FAST))
    more = f"takes {100 * fast:.0f} % where {100 * slow:.0f} % do near 50 Hz" if fast > slow else "does it with no more"
    amplitudes, air = _by_amplitude(runs, "air_used", own)
    given = int(np.argmin(np.abs(amplitudes - valve.dither.amplitude)))
    change = 100.0 * (air[given] / air[0] - 1.0)
    return (
        f"With a spool whose friction is {100 * worst:g} % of full opening the joint rests {errors[0]:.2f} deg off and "
        f"goes on moving by {ripples[0]:.2f} deg without dither; with dither near 50 Hz it is {errors.min():.2f} and "
        f"{ripples.min():.2f} deg at best. {gains} A dither of {FAST[0]:g} to {FAST[1]:g} Hz {more}, with "
        f"{100 * own:g} % of friction. The arm's own amplitude, {100 * amplitudes[given]:.0f} %, takes "
        f"{abs(change):.0f} % {'more' if change >= 0.0 else 'less'} air than none in the same moves."
    )
