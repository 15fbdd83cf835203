"""A study of one's own is drawn: results over what varies."""

from pathlib import Path

import numpy as np
import pandas
import pytest

from layflat.plot.bars_and_maps import MAX_BINS, binned_medians, study_figure
from layflat.study import read_study
from layflat.study.results import draw_study
from tests.study.studies import SMALL, written


def test_medians_over_few_values_and_over_many() -> None:
    across, upward = binned_medians(
        np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0]), np.array([3.0, 1.0, 2.0, np.inf, np.nan, 1.0])
    )
    assert across.tolist() == [1.0]  # of the other three most are infinite
    assert upward.tolist() == [2.0]
    x = np.linspace(0.0, 1.0, 400)
    across, upward = binned_medians(x, 3.0 * x)
    assert len(across) == MAX_BINS
    assert upward == pytest.approx(3.0 * across)
    assert len(binned_medians(x[:20], x[:20])[0]) == 2, "a bin has eight runs or more"


def test_a_run_that_has_not_settled_is_a_cross() -> None:
    x, y = np.array([1.0, 2.0, 3.0]), np.array([0.5, np.inf, 0.7])
    made = study_figure({"x (kg)": x}, {"settling (s)": y, "air (l)": x}, {"": np.ones(3, dtype=bool)})
    dots, crosses, line = made.axes[0].lines
    assert dots.get_marker() == "o"
    assert (crosses.get_marker(), crosses.get_xdata().tolist()) == ("x", [2.0])  # type: ignore[union-attr]
    assert line.get_ydata().tolist() == [0.5, 0.7]  # type: ignore[union-attr]
    assert [axes.get_ylabel() for axes in made.axes] == ["settling (s)", "air (l)"]
    assert made.axes[1].get_xlabel() == "x (kg)"


def made_up(tmp_path: Path) -> tuple[object, pandas.DataFrame]:
    study = read_study(written(tmp_path, SMALL))
    frame = pandas.DataFrame(
        {
            "variant": ["a", "b"] * 6,
            "scenario": ["0"] * 12,
            "joint.small.brake.torque": np.repeat([1.0, 2.0, 3.0], 4),
            "scenario.payload": np.tile([0.0, 1.0], 6),
            "settling.small.0": np.arange(12.0),
            "air_used": np.ones(12),
        }
    )
    units = {"joint.small.brake.torque": "N*m", "scenario.payload": "kg", "settling.small.0": "s", "air_used": "l"}
    frame.attrs["units"] = units
    return study, frame


def test_panels_have_units_and_cases_have_names(tmp_path: Path) -> None:
    study, frame = made_up(tmp_path)
    made = draw_study(study, frame)  # type: ignore[arg-type]
    assert len(made.axes) == 4
    assert [axes.get_ylabel() for axes in made.axes[::2]] == ["settling (s)", "air used (l)"]
    assert [axes.get_xlabel() for axes in made.axes[2:]] == ["small brake torque (N m)", "payload (kg)"]
    assert [text.get_text() for text in made.legends[0].get_texts()] == ["a", "b"]
