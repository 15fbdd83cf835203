"""Amplitude and frequency of dither over the friction of the spool: accuracy and ripple."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layflat.experiments.questions.tables import Array, at_rest, moves_of
from layflat.plot.maps import draw_map, edges
from layflat.plot.style import LINES
from layflat.plot.style import figure as new_figure
from layflat.study import Study

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

TITLE = "How much dither, and how fast?"
CAPTION = (
    "Left: how far the braked joint is from its goal at rest, with dither near 50 Hz, by the friction of its spool (in "
    "% of full opening). Middle: the same over frequency and amplitude at the friction that the paper's arm is given. "
    "Right: what dither alone moves a joint without brake. The cross is the paper's frequency, with the calibrated "
    "amplitude."
)
FRICTION, AMPLITUDE, FREQUENCY = "valve.friction", "valve.dither.amplitude", "valve.dither.frequency"
"""Columns of the table."""
AROUND = (40.0, 60.0)
"""Frequencies that count as about 50 Hz."""
GOOD = 1.5
"""An amplitude is enough where the error is at most so many times the least that any amplitude reaches."""
LITTLE = 0.3
"""Less of the error than this share is little to gain."""


def _off(frame: pandas.DataFrame) -> pandas.DataFrame:
    """Runs with moves, and how far from its goal the joint is at rest on average, deg."""
    own = frame[frame["scenario"] == "moves"]
    return own.assign(off=at_rest(own, moves_of(frame)).mean(axis=1))


def _by_amplitude(off: pandas.DataFrame, friction: float, low: float, high: float) -> tuple[Array, Array]:
    """Amplitudes, and the mean error at rest (deg) at frequencies from low to high."""
    own = off[(off[FRICTION] == friction) & off[FREQUENCY].between(low, high)]
    mean = own.groupby(AMPLITUDE)["off"].mean()
    return mean.index.to_numpy(dtype=float), mean.to_numpy(dtype=float)


def _enough(amplitudes: Array, errors: Array) -> float:
    """The least amplitude from which on the error stays near the least."""
    bad = np.flatnonzero(errors > GOOD * errors.min())
    return float(amplitudes[min(bad[-1] + 1, len(amplitudes) - 1)]) if len(bad) else float(amplitudes[0])


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Error by amplitude; maps of error and motion over frequency and amplitude."""
    off, valve = _off(frame), study.machine.valve
    assert valve is not None
    with new_figure(1, 3, width=10.4, height=4.0, above=0.62) as (made, (lines, error, motion)):
        for order, friction in enumerate(np.sort(frame[FRICTION].unique())):
            amplitudes, errors = _by_amplitude(off, friction, *AROUND)
            lines.plot(100 * amplitudes, errors, label=f"{100 * friction:g} %", **LINES[order], marker="o", ms=3)
        lines.set_ylabel("Error at rest (deg)")
        lines.set_xlabel("Amplitude of dither (% of full opening)")
        lines.set_ylim(bottom=0.0)
        lines.legend(title="friction of the spool")
        friction = _nearest(frame[FRICTION], valve.friction)
        alone = frame[(frame["scenario"] == "dither alone") & (frame[FRICTION] == friction)]
        maps = (
            (error, off[off[FRICTION] == friction], "off", "Error at rest (deg)"),
            (motion, alone.assign(moved=np.degrees(alone["ripple.small.0"])), "moved", "Motion without brake (deg)"),
        )
        for axes, own, column, label in maps:
            wide = own.groupby([AMPLITUDE, FREQUENCY])[column].mean().unstack()
            x, y = (axis.to_numpy(dtype=float) for axis in (wide.columns, wide.index))
            z = wide.to_numpy(dtype=float)
            draw_map(axes, x, 100 * y, z, label, low=0.0, high=float(np.quantile(z, 0.95)))
            axes.plot(valve.dither.frequency, 100 * valve.dither.amplitude, "+", color="#c23b4e", ms=12, mew=2.5)
            axes.set_xscale("log")
            axes.set_xticks([20, 50, 100, 200], ["20", "50", "100", "200"])
            axes.minorticks_off()
            axes.set_xlim(*edges(x, log=True))
            axes.set_ylim(*edges(100 * y))
            axes.set_xlabel("Frequency of dither (Hz)")
            axes.set_ylabel("Amplitude (% of full opening)")
    return made


def _nearest(column: pandas.Series, value: float) -> float:
    values = column.unique()
    return float(values[np.argmin(np.abs(values - value))])


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """What dither gains, how much of it is enough, and what it moves."""
    off, valve = _off(frame), study.machine.valve
    assert valve is not None
    frictions = np.sort(frame[FRICTION].unique())
    worst = float(frictions[-1])
    _, errors = _by_amplitude(off, worst, *AROUND)
    gain = 1.0 - errors.min() / errors[0]
    sentences = [
        f"With a spool whose friction is {100 * worst:g} % of full opening the joint rests {errors[0]:.2f} deg off "
        f"without dither and {errors.min():.2f} deg with the best at about 50 Hz."
    ]
    if gain >= LITTLE:
        enough = ", ".join(
            f"{100 * _enough(*_by_amplitude(off, friction, *AROUND)):.0f} % with {100 * friction:g} %"
            for friction in frictions[frictions > 0.0]
        )
        sentences.append(f"Enough near 50 Hz is an amplitude of {enough} of friction.")
    else:
        sentences.append("Dither makes little difference to that.")
    own = _nearest(frame[FRICTION], valve.friction)
    slow, fast = (_enough(*_by_amplitude(off, own, *band)) for band in (AROUND, (130.0, 170.0)))
    if fast > slow:
        sentences.append(f"At 130 to 170 Hz it takes {100 * fast:.0f} % where {100 * slow:.0f} % do near 50 Hz.")
    else:
        sentences.append("A dither of 130 to 170 Hz does it with no more amplitude.")
    alone = frame[(frame["scenario"] == "dither alone") & (frame[FRICTION] == own)]
    amplitude = _nearest(frame[AMPLITUDE], valve.dither.amplitude)
    moved = np.degrees(alone[alone[AMPLITUDE] == amplitude].groupby(FREQUENCY)["ripple.small.0"].mean())
    at, top = moved.index.to_numpy(dtype=float), int(np.argmax(moved.to_numpy()))
    sentences.append(
        f"Without brake a dither of {100 * amplitude:.0f} % moves the joint by {_at(moved, 50.0):.3f} deg at 50 Hz, "
        f"{_at(moved, 150.0):.3f} at 150 Hz and at most {moved.iloc[top]:.3f} (at {at[top]:g} Hz)."
    )
    return " ".join(sentences)


def _at(values: pandas.Series, frequency: float) -> float:
    return float(values.iloc[int(np.argmin(np.abs(values.index.to_numpy(dtype=float) - frequency)))])
