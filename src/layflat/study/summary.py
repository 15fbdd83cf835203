"""What a study's table says in a few lines."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np

from layflat.study.folder import table

SHARES = (0.05, 0.5, 0.95)
"""Of the runs below a quantile."""

SHOWN = {"rad": ("deg", 180.0 / pi), "m": ("mm", 1000.0), "Pa": ("bar", 1e-5)}
"""Units that people read more easily, and how many of them make an SI unit."""


def in_shown(unit: str) -> tuple[str, float]:
    """Return the unit in which an SI unit is shown, and how many of it make one."""
    return SHOWN.get(unit, (unit, 1.0))


@dataclass(frozen=True)
class Summary:
    """A study in a few lines.

    Args:
        runs: how many.
        settled: share of runs in which every joint settles in every move; None where that was not kept.
        diverged: runs that did.
        quantiles: unit, and the values at `SHARES`, by the name of the metric; of runs that did not diverge.
    """

    runs: int
    settled: float | None
    diverged: int
    quantiles: dict[str, tuple[str, tuple[float, ...]]]


def summary(out: str | Path, metrics: tuple[str, ...]) -> Summary:
    """Summarize the table in a study's folder."""
    frame = table(out)
    diverged = frame["diverged"].notna().to_numpy()
    quantiles = {}
    for name in frame.columns:
        if name.split(".")[0] not in metrics:
            continue
        values = frame[name].to_numpy()
        values = np.sort(values[~np.isnan(values)])
        unit, factor = in_shown(frame.attrs["units"][name])
        if len(values):
            # The nearest value, since there is no way between infinite ones.
            at = [values[round(share * (len(values) - 1))] for share in SHARES]
            quantiles[name] = unit, tuple(factor * float(value) for value in at)
    settling = [name for name in frame.columns if name.split(".")[0] == "settling"]
    settled = (~np.isposinf(frame[settling].to_numpy()).any(axis=1)) & ~diverged
    return Summary(len(frame), float(settled.mean()) if settling else None, int(diverged.sum()), quantiles)
