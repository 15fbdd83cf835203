"""Figures of a regulated joint's logs: set-points, pressures and angles as they were, in gauge pressure."""

from __future__ import annotations

import numpy as np
import pytest
from looks import covered, cut_off, line_of, looks, units_of

from layflat.plot.free_run import START, Shown, free_runs

AMBIENT = 1.01325e5
TIME = np.linspace(0.0, 3.0, 301)


def shown(filled: float = 0.0) -> Shown:
    """A log whose chambers stand at the ambient pressure and rise from `filled` (Pa) below it in the beginning."""
    start = -filled * (TIME < 0.5 * START)
    a, b = AMBIENT + 5e4 + 1e4 * np.sin(TIME) + start, AMBIENT + 4e4 - 1e4 * np.sin(TIME) + start
    angle = 0.3 * np.sin(TIME)
    simulated = np.stack([angle + 0.01, a + 500.0, b - 500.0], axis=-1)
    return Shown(TIME, a + 100.0, b - 100.0, angle, a, b, simulated)


@pytest.mark.parametrize("count", [1, 3])
def test_a_column_a_log_by_its_title_with_units(count: int) -> None:
    made = free_runs({f"log {i}": shown() for i in range(count)}, AMBIENT)
    assert len(made.axes) == 3 * count
    assert [axes.get_title() for axes in made.axes[:count]] == [f"log {i}" for i in range(count)]
    assert all(label.endswith(")") for label in units_of(made))
    assert covered(made) == []
    assert cut_off(made) == []


def test_pressures_are_gauge_and_angles_in_degrees() -> None:
    log = shown()
    asked, pressure, angle = free_runs({"log": log}, AMBIENT).axes
    np.testing.assert_allclose(line_of(asked, "chamber B")[1], 1e-3 * (log.setpoint_b - AMBIENT))
    np.testing.assert_allclose(line_of(pressure, "simulated A")[1], 1e-3 * (log.simulated[:, 1] - AMBIENT))
    np.testing.assert_allclose(line_of(pressure, "measured")[1], 1e-3 * (log.pressure_a - AMBIENT))
    np.testing.assert_allclose(line_of(angle, "simulated")[1], np.degrees(log.simulated[:, 0]))
    assert len(set(looks(pressure))) == 3
    assert asked.lines[0].get_drawstyle() == "steps-post"


def test_filling_in_the_beginning_does_not_squeeze_the_rest() -> None:
    usual, filled = (free_runs({"log": shown(filled=start)}, AMBIENT).axes[1].get_ylim() for start in (0.0, 5e4))
    assert filled == pytest.approx(usual)
    low, high = filled
    assert low < 30.0
    assert high > 60.0
