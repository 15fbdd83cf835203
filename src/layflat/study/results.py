"""What a study's table says in a few lines, and the picture of a study of one's own: results over what varies."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.files import write_text
from layflat.study.folder import ANSWER, table
from layflat.study.study import Study

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

SHARES = (0.05, 0.5, 0.95)  # of the runs below a quantile

SHOWN = {"rad": ("deg", 180.0 / pi), "m": ("mm", 1000.0), "Pa": ("bar", 1e-5)}
"""Units that people read more easily, and how many of them make an SI unit."""

MOST_RESULTS, MOST_VARIED = 4, 5  # panels of the picture, upward and across

PNG, SVG, _ = ANSWER


@dataclass(frozen=True)
class Summary:
    """A study in a few lines."""

    runs: int
    settled: float | None  # share of runs in which every joint settles in every move; None where that was not kept
    diverged: int  # runs that did
    quantiles: dict[str, tuple[str, tuple[float, ...]]]  # unit and values at `SHARES`, of runs that did not diverge


def columns_of(frame: pandas.DataFrame, metric: str) -> list[str]:
    """Return the columns of a metric, one for each joint and move."""
    return [name for name in frame.columns if name.split(".")[0] == metric]


def summary(out: str | Path, metrics: tuple[str, ...]) -> Summary:
    """Summarize the table in a study's folder."""
    frame = table(out)
    diverged = frame["diverged"].notna()
    quantiles = {}
    for name in frame.columns:
        values = np.sort(frame[name].dropna().to_numpy()) if name.split(".")[0] in metrics else np.empty(0)
        if len(values):
            unit, factor = SHOWN.get(frame.attrs["units"][name], (frame.attrs["units"][name], 1.0))
            # The nearest value, since there is no way between infinite ones.
            at = [values[round(share * (len(values) - 1))] for share in SHARES]
            quantiles[name] = unit, tuple(factor * float(value) for value in at)
    settling = frame[columns_of(frame, "settling")]
    settled = ~np.isposinf(settling.to_numpy()).any(axis=1) & ~diverged
    return Summary(len(frame), float(settled.mean()) if settling.columns.size else None, int(diverged.sum()), quantiles)


def draw(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw the first metrics of a study's table over what they depend on most; of joints and moves the worst counts."""
    from layflat.plot.bars_and_maps import study_figure  # noqa: PLC0415  # a summary needs no figure

    results, varied = {}, {}
    for metric in study.metrics[:MOST_RESULTS]:
        columns = columns_of(frame, metric)
        label, factor = _label(metric, frame.attrs["units"][columns[0]])
        results[label] = factor * frame[columns].abs().max(axis=1, skipna=False).to_numpy(dtype=float)
    paths = _most_decisive(frame, [one.path for one in study.varied] or ["noise_seed"], next(iter(results.values())))
    for path in paths:
        label, factor = _label(path.removeprefix("joint.").removeprefix("scenario."), frame.attrs["units"][path])
        varied[label] = factor * frame[path].to_numpy(dtype=float)
    return study_figure(varied, results, _cases(frame))


def write_figure(drawn: Figure, out: Path) -> Path:
    """Write a figure beside the table in a study's folder, as SVG and as PNG; return the SVG's path."""
    from layflat.plot.style import save, to_svg  # noqa: PLC0415

    save(drawn, out / PNG)
    return write_text(out / SVG, to_svg(drawn))


def _label(name: str, si: str) -> tuple[str, float]:
    """A name with the unit in which it is shown, and how many of this make the SI unit."""
    unit, factor = SHOWN.get(si, (si, 1.0))
    words = name.replace("_", " ").replace(".", " ")
    return words if unit == "1" else f"{words} ({unit.replace('*', ' ')})", factor


def _most_decisive(frame: pandas.DataFrame, paths: list[str], result: Array) -> list[str]:
    """Paths, the fewest that fit: those with which a result goes most, by rank."""
    if len(paths) <= MOST_VARIED:
        return paths
    ranks = frame[paths].rank().corrwith(frame.assign(result=result)["result"].rank()).abs().fillna(0.0)
    kept = set(ranks.sort_values(ascending=False, kind="stable").index[:MOST_VARIED])
    return [path for path in paths if path in kept]


def _cases(frame: pandas.DataFrame) -> dict[str, NDArray[np.bool_]]:
    """Return which runs belong to each variant and scenario, by their names where there are several."""
    by = [name for name in ("variant", "scenario") if name in frame and frame[name].nunique() > 1]
    names = frame[by].astype(str).agg(", ".join, axis=1) if by else frame.assign(case="")["case"]
    return {name: (names == name).to_numpy() for name in names.unique()}
