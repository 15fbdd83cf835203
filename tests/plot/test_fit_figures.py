"""Figures of fits: for few and many signals, with units, and a grey ground where nothing was fitted."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex

from layflat.plot.runs import MAX_MARKED_SAMPLES, ComparedSignal, measured_and_simulated
from layflat.plot.style import SHADE_COLOUR, to_svg


def signal(name: str = "angle", samples: int = 400, fitted: float = 2.0 / 3.0, unit: str = "deg") -> ComparedSignal:
    time = np.linspace(0.0, 4.0, samples)
    measured = np.sin(time)
    return ComparedSignal(name, unit, time, measured, measured + 0.01, time <= fitted * time[-1])


@pytest.mark.parametrize("count", [1, 3, 8])
def test_a_row_a_signal_with_units_on_every_axis(count: int) -> None:
    made = measured_and_simulated([signal(f"signal_{i}") for i in range(count)])
    assert len(made.axes) == 2 * count
    assert all(axes.get_ylabel().endswith("(deg)") for axes in made.axes)
    assert "_" not in made.axes[0].get_ylabel()
    assert [axes.get_xlabel() for axes in made.axes[-2:]] == ["Time (s)", "Time (s)"]
    high = made.axes[0].get_position().height * made.get_figheight()
    assert high > 1.0


def test_what_was_not_fitted_stands_on_grey_and_in_the_legend() -> None:
    for share, words in ((2.0 / 3.0, True), (2.0, False), (-1.0, True)):
        made = measured_and_simulated([signal(fitted=share)])
        legend = made.axes[0].get_legend()
        assert legend is not None
        assert ("not fitted" in [text.get_text() for text in legend.get_texts()]) == words
        for axes in made.axes:
            shades = [patch for patch in axes.patches if to_hex(patch.get_facecolor()) == SHADE_COLOUR]
            assert len(shades) == (1 if words else 0)


def test_few_samples_are_marked_and_joined_and_gaps_in_many_stay_open() -> None:
    few = measured_and_simulated([signal(samples=MAX_MARKED_SAMPLES)]).axes[0].lines[0]
    many = measured_and_simulated([signal(samples=MAX_MARKED_SAMPLES + 1)]).axes[0].lines[0]
    assert (few.get_marker(), many.get_marker()) == ("o", "None")
    for samples, whole in ((50, True), (1000, False)):
        holey = signal(samples=samples)
        holey.measured[10:20] = np.nan
        drawn = measured_and_simulated([holey]).axes[0].lines[0].get_ydata()
        assert np.isfinite(drawn).all() == whole


def test_the_same_data_give_the_same_bytes() -> None:
    first, again = (to_svg(measured_and_simulated([signal(unit="")])) for _ in range(2))
    assert first == again
