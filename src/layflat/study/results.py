"""Summary of a study's table, and its default figure: results over the varied values."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.files import write_text
from layflat.study.folder import ANSWER_FILES, study_table
from layflat.study.study import Study

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

SUMMARY_LEVELS = (0.05, 0.5, 0.95)  # of the quantiles

DISPLAY_UNITS = {"rad": ("deg", 180.0 / pi), "m": ("mm", 1000.0), "Pa": ("bar", 1e-5)}
"""Units for people, by SI unit, with the factor from SI."""

MAX_RESULTS, MAX_VARIED = 4, 5  # rows and columns of the figure

PNG, SVG, _ = ANSWER_FILES


@dataclass(frozen=True)
class StudySummary:
    """Summary of a study's table."""

    runs: int
    settled: float | None  # fraction of runs in which every joint settles in every move; None without this metric
    diverged: int  # number of runs
    quantiles: dict[str, tuple[str, tuple[float, ...]]]  # unit, and values at `SUMMARY_LEVELS`, without diverged runs


def metric_columns(frame: pandas.DataFrame, metric: str) -> list[str]:
    """Return the columns of a metric, one for each joint and move."""
    return [name for name in frame.columns if name.split(".")[0] == metric]


def summarize_study(out: str | Path, metrics: tuple[str, ...]) -> StudySummary:
    """Return the summary of a study's table: quantiles of the chosen metrics, settled fraction, diverged runs.

    Quantiles are in units for people, and include infinite values; a diverged run counts as not settled.
    """
    frame = study_table(out)
    diverged = frame["diverged"].notna()
    quantiles = {}
    for name in frame.columns:
        values = np.sort(frame[name].dropna().to_numpy()) if name.split(".")[0] in metrics else np.empty(0)
        if len(values):
            unit, factor = DISPLAY_UNITS.get(frame.attrs["units"][name], (frame.attrs["units"][name], 1.0))
            # The nearest value, since infinite ones can't be interpolated.
            at = [values[round(share * (len(values) - 1))] for share in SUMMARY_LEVELS]
            quantiles[name] = unit, tuple(factor * float(value) for value in at)
    settling = frame[metric_columns(frame, "settling")]
    settled = ~np.isposinf(settling.to_numpy()).any(axis=1) & ~diverged
    return StudySummary(
        len(frame), float(settled.mean()) if settling.columns.size else None, int(diverged.sum()), quantiles
    )


def draw_study(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw the first metrics, each at its largest magnitude over joints and moves, over the varied values.

    There are at most `MAX_RESULTS` metrics, and `MAX_VARIED` axes: those that correlate most with the first metric.
    """
    from layflat.plot.bars_and_maps import study_figure  # noqa: PLC0415  # a summary needs no figure

    results, varied = {}, {}
    for metric in study.metrics[:MAX_RESULTS]:
        columns = metric_columns(frame, metric)
        label, factor = _display_label(metric, frame.attrs["units"][columns[0]])
        results[label] = factor * frame[columns].abs().max(axis=1, skipna=False).to_numpy(dtype=float)
    paths = _most_correlated(frame, [one.path for one in study.varied] or ["noise_seed"], next(iter(results.values())))
    for path in paths:
        label, factor = _display_label(
            path.removeprefix("joint.").removeprefix("scenario."), frame.attrs["units"][path]
        )
        varied[label] = factor * frame[path].to_numpy(dtype=float)
    return study_figure(varied, results, _case_masks(frame))


def write_figure(drawn: Figure, out: Path) -> Path:
    """Write a figure beside the table in a study's folder, as SVG and as PNG; return the SVG's path."""
    from layflat.plot.style import save_figure, to_svg  # noqa: PLC0415

    save_figure(drawn, out / PNG)
    return write_text(out / SVG, to_svg(drawn))


def _display_label(name: str, si: str) -> tuple[str, float]:
    """Return a label with the unit for people, and the factor from SI."""
    unit, factor = DISPLAY_UNITS.get(si, (si, 1.0))
    words = name.replace("_", " ").replace(".", " ")
    return words if unit == "1" else f"{words} ({unit.replace('*', ' ')})", factor


def _most_correlated(frame: pandas.DataFrame, paths: list[str], result: Array) -> list[str]:
    """Return the `MAX_VARIED` paths with the greatest rank correlation (magnitude) with a result, in their order."""
    if len(paths) <= MAX_VARIED:
        return paths
    ranks = frame[paths].rank().corrwith(frame.assign(result=result)["result"].rank()).abs().fillna(0.0)
    kept = set(ranks.sort_values(ascending=False, kind="stable").index[:MAX_VARIED])
    return [path for path in paths if path in kept]


def _case_masks(frame: pandas.DataFrame) -> dict[str, NDArray[np.bool_]]:
    """Return masks of the runs of each variant and scenario, by their names; "" where there is only one case."""
    by = [name for name in ("variant", "scenario") if name in frame and frame[name].nunique() > 1]
    names = frame[by].astype(str).agg(", ".join, axis=1) if by else frame.assign(case="")["case"]
    return {name: (names == name).to_numpy() for name in names.unique()}
