"""Logs for the tests: a run as a rig would have recorded it, in units of its own."""

import csv
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from layflat.identify.logs.mapping import LogMapping, parse_mapping
from layflat.sim import rollout

Array = NDArray[np.float64]

MOVES = [("0 s", "0 deg"), ("0.4 s", "35 deg"), ("1.4 s", "-40 deg"), ("2.2 s", "10 deg")]


@cache
def run(machine: str = "paper-small-joint-fast", **changes: Any) -> xarray.Dataset:
    """A run with moves that excite a joint."""
    return rollout(machine, MOVES, duration="3 s", **changes)


def recorded(machine: str = "paper-small-joint-fast", joint: str = "small", **changes: Any) -> dict[str, Array]:
    """Columns as a rig's data logger writes them: ms, deg, bar gauge, V."""
    simulated = run(machine, **changes).sel(joint=joint)
    ambient = 101325.0
    return {
        "time_ms": 1e3 * simulated["time"].values,
        "theta": np.degrees(simulated["measured_angle"].values),
        "pA": (simulated["pressure_a"].values - ambient) / 1e5,
        "pB": (simulated["pressure_b"].values - ambient) / 1e5,
        "valve": simulated["voltage"].values,
        "ref": np.degrees(simulated["demand"].values),
    }


def ticks(period: float, count: int, first: int = 0) -> Array:
    """Stamps of an even clock."""
    return period * np.arange(first, first + count, dtype=np.float64)


def entry(column: str, signal: str, unit: str, **more: Any) -> dict[str, Any]:
    return {"from": column, "signal": signal, "unit": unit, "joint": "small", **more}


ENTRIES: dict[str, dict[str, Any]] = {
    "theta": entry("theta", "angle", "deg"),
    "pA": entry("pA", "pressure_a", "bar", gauge=True),
    "pB": entry("pB", "pressure_b", "bar", gauge=True),
    "valve": entry("valve", "voltage", "V"),
    "ref": entry("ref", "demand", "deg"),
}
"""The right mapping of `recorded`, by column."""


def mapping(*left_out: str, time: str = "ms", **changed: dict[str, Any]) -> LogMapping:
    """The right mapping of `recorded`, with entries changed or left out."""
    entries = [{**plain, **changed.get(name, {})} for name, plain in ENTRIES.items() if name not in left_out]
    return parse_mapping({"time": {"column": "time_ms", "unit": time}, "column": entries})


def write_csv(path: Path, columns: dict[str, Array], delimiter: str = ",", *, header: bool = True) -> Path:
    """Exact: numbers as Python writes them, an empty cell for what is missing."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, delimiter=delimiter)
        if header:
            writer.writerow(columns)
        for row in zip(*columns.values(), strict=True):
            writer.writerow(["" if np.isnan(value) else repr(float(value)) for value in row])
    return path


def changed(columns: dict[str, Array], name: str, change: Callable[[Array], Array]) -> dict[str, Array]:
    """Columns with one of them changed."""
    return {**columns, name: change(columns[name].copy())}


def told(issues: Sequence[Any], severity: str, channel: str) -> str:
    """The texts of the issues of one severity about a channel."""
    mine = [f for f in issues if f.severity == severity and channel in f.channel]
    return " | ".join(f"{f.text}; {f.right}" for f in mine)
