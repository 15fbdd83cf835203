"""The picture of a study of one's own: its results over what varies."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.files import whole_file
from layflat.plot.study import study_figure
from layflat.plot.style import save, to_svg
from layflat.study.folder import ANSWER, table
from layflat.study.study import Study
from layflat.study.summary import in_shown

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

MOST_RESULTS, MOST_VARIED = 4, 5
"""Panels of the picture, upward and across."""

PNG, SVG, _ = ANSWER


def draw(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw the first metrics over what they depend on most; of several joints and moves the worst counts.

    Args:
        study: what was run.
        frame: its table, with units in its attributes.
    """
    units = frame.attrs["units"]
    results = {}
    for metric in study.metrics[:MOST_RESULTS]:
        columns = [name for name in frame.columns if name.split(".")[0] == metric]
        unit, factor = in_shown(units[columns[0]])
        worst = frame[columns].abs().max(axis=1, skipna=False).to_numpy(dtype=float)
        results[_label(metric, unit)] = factor * worst
    paths = _most_decisive(frame, [one.path for one in study.varied] or ["noise_seed"], next(iter(results.values())))
    varied = {}
    for path in paths:
        unit, factor = in_shown(units[path])
        name = path.removeprefix("joint.").removeprefix("scenario.")
        varied[_label(name, unit)] = factor * frame[path].to_numpy(dtype=float)
    return study_figure(varied, results, _cases(frame))


def write_picture(study: Study, out: Path) -> Path:
    """Draw the table in a study's folder, beside it, as SVG and as PNG; return the SVG's path.

    Raises:
        OutputError: it can't be written.
    """
    drawn = draw(study, table(out))
    save(drawn, out / PNG)
    with whole_file(out / SVG) as temporary:
        temporary.write_text(to_svg(drawn), encoding="utf-8")
    return out / SVG


def _label(name: str, unit: str) -> str:
    words = name.replace("_", " ").replace(".", " ")
    return words if unit == "1" else f"{words} ({unit.replace('*', ' ')})"


def _most_decisive(frame: pandas.DataFrame, paths: list[str], result: NDArray[np.float64]) -> list[str]:
    """Paths, the fewest that fit: those with which a result goes most, by rank."""
    if len(paths) <= MOST_VARIED:
        return paths
    ranks = frame[paths].rank().corrwith(frame.assign(result=result)["result"].rank()).abs().fillna(0.0)
    kept = set(ranks.sort_values(ascending=False, kind="stable").index[:MOST_VARIED])
    return [path for path in paths if path in kept]


def _cases(frame: pandas.DataFrame) -> dict[str, NDArray[np.bool_]]:
    """Which runs belong to each variant and scenario, by their names where there are several."""
    by = [name for name in ("variant", "scenario") if name in frame and frame[name].nunique() > 1]
    if not by:
        return {"": np.ones(len(frame), dtype=bool)}
    names = frame[by].astype(str).agg(", ".join, axis=1)
    return {name: (names == name).to_numpy() for name in names.unique()}
