"""Amplitude and frequency of dither over the friction of the spool: accuracy and ripple."""

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.questions import join_words, move_names
from layflat.physics.valves.spool import SpoolValvePart
from layflat.plot.bars_and_maps import cell_edges, draw_map
from layflat.plot.style import draw_mark, series_style
from layflat.plot.style import styled_figure as new_figure
from layflat.study import Study

FRICTION, AMPLITUDE, FREQUENCY = "valve.friction", "valve.dither.amplitude", "valve.dither.frequency"
"""Columns of the table."""
NOMINAL_BAND, FAST_BAND = (40.0, 60.0), (130.0, 170.0)  # frequencies that count as "near 50 Hz" and as fast, Hz
MAX_ERROR_RATIO = 1.5  # error at a sufficient amplitude, over the least error of all amplitudes
MIN_IMPROVEMENT = 1.5  # factor by which worthwhile dither reduces error or ripple
MIN_ERROR = 1e-6  # lower bound of a divisor, deg


def _measure_runs(study: Study, frame: pandas.DataFrame) -> tuple[pandas.DataFrame, SpoolValvePart, float]:
    """Return runs with error at rest and ripple, the arm's valve, and the simulated friction nearest to its own.

    Error and ripple are means over all moves, deg.
    """
    moves, valve, frictions = move_names(frame), study.machine.valve, frame[FRICTION].unique()
    assert isinstance(valve, SpoolValvePart)
    error = np.degrees(frame[[f"steady_error.{move}" for move in moves]].abs().mean(axis=1))
    ripple = np.degrees(frame[[f"ripple.{move}" for move in moves]].mean(axis=1))
    nearest = float(frictions[np.argmin(np.abs(frictions - valve.friction))])
    return frame.assign(error=error, ripple=ripple), valve, nearest


def _mean_by_amplitude(
    runs: pandas.DataFrame, column: str, friction: float, band: tuple[float, float] = NOMINAL_BAND
) -> tuple[Array, Array]:
    """Return amplitudes, and the mean of a column at each, of runs with a friction, and frequencies in a band (Hz)."""
    selected = runs[(runs[FRICTION] == friction) & runs[FREQUENCY].between(*band)]
    mean = selected.groupby(AMPLITUDE)[column].mean()
    return mean.index.to_numpy(dtype=float), mean.to_numpy(dtype=float)


def _sufficient_amplitude(amplitudes: Array, errors: Array) -> float:
    """Return the least amplitude from which on the error stays within `MAX_ERROR_RATIO` of the least, else the last."""
    bad = np.flatnonzero(errors > MAX_ERROR_RATIO * errors.min())
    return float(amplitudes[min(bad[-1] + 1, len(amplitudes) - 1)]) if len(bad) else float(amplitudes[0])


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw error and ripple by amplitude, and a map of the error over frequency and amplitude."""
    runs, valve, friction_built_in = _measure_runs(study, frame)
    wide = runs[runs[FRICTION] == friction_built_in].groupby([AMPLITUDE, FREQUENCY])["error"].mean().unstack()
    frequencies, amplitudes_all, errors = (each.to_numpy(dtype=float) for each in (wide.columns, wide.index, wide))
    labels = {"error": "Error at rest (deg)", "ripple": "Ripple at rest (deg, peak to peak)"}
    with new_figure(1, 3, width=10.4, height=4.0, above=0.62) as (fig, (error, ripple, both)):
        for axes, (column, label) in zip((error, ripple), labels.items(), strict=True):
            for order, friction in enumerate(np.sort(frame[FRICTION].unique())):
                amplitudes, values = _mean_by_amplitude(runs, column, friction)
                style = {**series_style(order), "marker": "os^D"[order % 4], "ms": 3.5}
                axes.plot(100 * amplitudes, values, label=f"{100 * friction:g} %", **style)
            axes.set(xlabel="Amplitude of dither (% of full opening)", ylabel=label, ylim=(0.0, None))
            draw_mark(axes, 100 * valve.dither.amplitude, "built in", upright=True)
        ripple.legend(title="friction of the spool\n(% of full opening)", loc="upper right")
        draw_map(
            both,
            frequencies,
            100 * amplitudes_all,
            errors,
            labels["error"],
            low=0.0,
            high=float(np.quantile(errors, 0.95)),
        )
        both.plot(valve.dither.frequency, 100 * valve.dither.amplitude, "+", color="#c23b4e", ms=12, mew=2.5)
        both.set_xscale("log")
        both.set_xticks([20, 50, 100, 200], ["20", "50", "100", "200"])
        both.minorticks_off()
        both.set(xlim=cell_edges(frequencies, log=True), ylim=cell_edges(100 * amplitudes_all))
        both.set(xlabel="Frequency of dither (Hz)", ylabel="Amplitude (% of full opening)")
    return fig


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Return text on the gain of dither, its sufficient amplitude, its frequency, and its consumption of air."""
    runs, valve, friction_built_in = _measure_runs(study, frame)
    frictions = np.sort(frame[FRICTION].unique())
    worst = float(frictions[-1])
    (_, errors), (_, ripples) = (_mean_by_amplitude(runs, column, worst) for column in ("error", "ripple"))
    gains = "Dither makes little difference."
    if max(errors[0] / max(errors.min(), MIN_ERROR), ripples[0] / max(ripples.min(), MIN_ERROR)) >= MIN_IMPROVEMENT:
        enough = [
            f"{100 * _sufficient_amplitude(*_mean_by_amplitude(runs, 'error', friction)):.0f} % with "
            f"{100 * friction:g} % of friction"
            for friction in frictions[frictions > 0.0]
        ]
        gains = f"Enough near 50 Hz is an amplitude of {join_words(enough)}."
    slow, fast = (
        _sufficient_amplitude(*_mean_by_amplitude(runs, "error", friction_built_in, band))
        for band in (NOMINAL_BAND, FAST_BAND)
    )
    more = f"takes {100 * fast:.0f} % where {100 * slow:.0f} % do near 50 Hz" if fast > slow else "does it with no more"
    amplitudes, air = _mean_by_amplitude(runs, "air_used", friction_built_in)
    built_in = int(np.argmin(np.abs(amplitudes - valve.dither.amplitude)))
    change = 100.0 * (air[built_in] / air[0] - 1.0)
    return (
        f"With a spool whose friction is {100 * worst:g} % of full opening the joint rests {errors[0]:.2f} deg off and "
        f"goes on moving by {ripples[0]:.2f} deg without dither; with dither near 50 Hz it is {errors.min():.2f} and "
        f"{ripples.min():.2f} deg at best. {gains} A dither of {FAST_BAND[0]:g} to {FAST_BAND[1]:g} Hz {more}, with "
        f"{100 * friction_built_in:g} % of friction. The arm's own amplitude, {100 * amplitudes[built_in]:.0f} %, "
        f"takes {abs(change):.0f} % {'more' if change >= 0.0 else 'less'} air than none in the same moves."
    )
