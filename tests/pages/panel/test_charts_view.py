"""Charts of the panel: their ranges, also where samples are no numbers, as those of a failed sensor."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from layflat.machine import load
from layflat.pages.panel.charts_view import KINDS, ChartsView
from layflat.pages.panel.pilot import BRAKE_SIGNAL, JOINT_SIGNALS, RecentSamples

ARM = load("paper-arm")


class NotedChart:
    """Stands for a chart: it notes its bounds and its points."""

    def bounds(self, up: tuple[float, float]) -> None:
        self.up = up

    def show(self, data: dict[str, list[list[float]]]) -> None:
        self.values = [y for pairs in data.values() for _, y in pairs]


def refreshed(kind: str, samples: RecentSamples) -> NotedChart:
    """The chart of a kind, after a refresh with samples."""
    chart, view = NotedChart(), object.__new__(ChartsView)
    desk: Any = SimpleNamespace(pilot=SimpleNamespace(history=SimpleNamespace(samples=lambda: samples)), charts={})
    charts: Any = {kind: chart}
    view._desk, view._names, view._charts = desk, list(ARM.joints), charts
    view._panels = SimpleNamespace(value=kind)  # type: ignore[assignment]
    view.refresh()
    return chart


@pytest.mark.parametrize("kind", KINDS)
def test_the_range_of_a_chart_covers_the_finite_samples(kind: str) -> None:
    rng, step = np.random.default_rng(0), KINDS[kind][1]
    for lost in (np.arange(0), np.arange(2, 5), np.arange(10)):
        joints = {name: rng.uniform(-2.0, 2.0, (10, 2)) for name in (*JOINT_SIGNALS, BRAKE_SIGNAL)}
        for values in joints.values():
            values[lost] = np.nan
        chart = refreshed(kind, RecentSamples(np.linspace(-0.9, 0.0, 10), joints, {}))
        lower, upper = chart.up
        finite = [value for value in chart.values if np.isfinite(value)]
        assert lower % step == upper % step == 0.0
        assert lower < upper
        assert all(lower <= value <= upper for value in finite)
        assert len(lost) < 10 or (lower, upper) == (0.0, step)
