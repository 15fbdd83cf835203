"""Results as data sets that show themselves in a notebook and draw themselves."""

from collections.abc import Mapping
from math import degrees, isfinite
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import xarray
from xarray.plot.accessor import DatasetPlotAccessor

from layflat._version import __version__
from layflat.plot.tables import html_table
from layflat.sim.metrics import measure_moves

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNITS = {
    "settling": ("s", "time until the joint stays within its band; infinite where it does not"),
    "overshoot": ("rad", "largest error beyond the goal"),
    "steady_error": ("rad", "mean error over the last fifth of the move"),
    "ripple": ("rad", "peak to peak over the last fifth of the move"),
    "tip_settling": ("s", "time until the tip stays within its band; infinite where it does not"),
    "tip_error": ("m", "largest distance of the tip from its goal over the last fifth of the move"),
    "air_used": ("l", "air taken from the supply, normal litres"),
    "hysteresis": ("1", "loop height over greatest torque of a slow sweep at supply pressure, brake on"),
    "peak_acceleration": ("m/s^2", "largest acceleration of the payload, from its position at control cycles"),
    "diverged": ("s", "when the run diverged; not a number where it did not"),
}
"""Unit and meaning of every metric."""

METRICS = tuple(name for name in UNITS if name != "diverged")
SHOWN_UNITS = {"rad": ("deg", degrees(1.0)), "m": ("mm", 1e3), "1": ("%", 100.0)}
"""Unit of a metric in tables and figures, and its factor; others are shown as they are."""
DRAWN_METRICS = ("settling", "overshoot", "steady_error", "ripple")
MAX_VARIED = 5  # columns of a figure
MOVE_COLUMNS = ("from (s)", "joint", "settling (s)", "overshoot (deg)", "steady error (deg)", "ripple (deg)")


class _RunPlot(DatasetPlotAccessor):
    """Plots of a run: its figure when it is called, else the plots of xarray."""

    def __call__(self) -> "Figure":  # type: ignore[override]
        from layflat.plot.runs import run_figure  # noqa: PLC0415  # matplotlib takes long to import
        from layflat.plot.style import add_caption  # noqa: PLC0415

        run = self._ds if "joint" in self._ds.dims else self._ds.expand_dims("joint", axis=-1)
        caption = f"{_machine_name(run)}: angle with its demand, pressures and control voltage of each joint"
        return add_caption(run_figure(run), caption)


class Run(xarray.Dataset):
    """Simulated run: signals over time, by joint. `plot()` draws it; its other plots are those of xarray."""

    __slots__ = ()

    @property
    def plot(self) -> _RunPlot:  # type: ignore[override]
        """Plots: `plot()` draws angles, pressures and voltages of all joints."""
        return _RunPlot(self)

    def _repr_html_(self) -> str:
        """Return a table of the joints' moves above the data set's own view, for notebooks."""
        if not ({"angle", "demand"} <= set(self.data_vars) and {"time", "joint"} <= set(self.dims)):
            return super()._repr_html_()
        rows = [
            [f"{since:g}", move.joint, _format_time(move.settling)]
            + [f"{degrees(value):.3f}" for value in (move.overshoot, move.steady_error, move.ripple)]
            for since, move in measure_moves(self)
        ]
        caption = f"{_machine_name(self)}: {float(self['time'][-1]):g} s, settled within 0.3 deg"
        return html_table(caption, MOVE_COLUMNS, rows) + super()._repr_html_()


class _MetricsPlot(DatasetPlotAccessor):
    """Plots of metrics: their figure when it is called, else the plots of xarray."""

    def __call__(self) -> "Figure":  # type: ignore[override]
        """Draw the metrics of one run by move and joint, or the largest ones of each of many runs over what varied."""
        from layflat.plot.bars_and_maps import move_figure, study_figure  # noqa: PLC0415  # matplotlib loads slowly
        from layflat.plot.style import add_caption  # noqa: PLC0415

        name, metrics = _machine_name(self._ds), [key for key in DRAWN_METRICS if key in self._ds]
        if "run" not in self._ds.dims:
            moves = [
                f"{start:g} s, {joint}" for start in self._ds["start"].values for joint in self._ds["joint"].values
            ]
            values = {label: np.abs(array).ravel() for label, array in map(self._labelled, metrics)}
            return add_caption(move_figure(moves, values), f"{name}: metrics of each move, by its start and joint")
        results = {
            label: np.abs(array).reshape(len(array), -1).max(axis=1) for label, array in map(self._labelled, metrics)
        }
        varied = dict(map(self._coordinate, _varied(self._ds)[:MAX_VARIED]))
        runs = np.ones(self._ds.sizes["run"], dtype=bool)
        caption = f"{name}: the worst joint and move of each of {len(runs)} runs; the line joins medians"
        return add_caption(study_figure(varied or {"run": np.arange(len(runs))}, results, {"": runs}), caption)

    def _coordinate(self, key: str) -> tuple[str, Any]:
        """Return the label and the values of a coordinate, in the unit that figures show."""
        values = self._ds[key]
        unit, factor = SHOWN_UNITS.get(values.attrs.get("units", ""), (values.attrs.get("units", ""), 1.0))
        return f"{key} ({unit})" if unit else key, factor * values.to_numpy()

    def _labelled(self, metric: str) -> tuple[str, Any]:
        """Return the label and the values of a metric, in the unit that figures show."""
        unit, factor = SHOWN_UNITS.get(UNITS[metric][0], (UNITS[metric][0], 1.0))
        return f"{metric.replace('_', ' ').capitalize()} ({unit})", factor * self._ds[metric].to_numpy()


class Metrics(xarray.Dataset):
    """Metrics of a run, or of many, with their units. `plot()` draws them; other plots are those of xarray."""

    __slots__ = ()

    @classmethod
    def from_values(cls, values: Mapping[str, Any], coords: Mapping[str, Any], machine: str) -> Self:
        """Return metrics with their units.

        Args:
            values: dimensions and array of each metric.
            coords: coordinates.
            machine: its name.
        """
        attributes = {name: dict(zip(("units", "long_name"), UNITS[name], strict=True)) for name in values}
        variables = {name: (*value, attributes[name]) for name, value in values.items()}
        return cls(variables, coords, {"machine_name": machine, "layflat_version": __version__})

    @property
    def plot(self) -> _MetricsPlot:  # type: ignore[override]
        """Plots: `plot()` draws the metrics of each move, or those of many runs over what varied."""
        return _MetricsPlot(self)

    def _repr_html_(self) -> str:
        """Return a table of each metric's min, median and max above the data set's own view, for notebooks."""
        rows = []
        for name in [key for key in METRICS if key in self]:
            unit, factor = SHOWN_UNITS.get(UNITS[name][0], (UNITS[name][0], 1.0))
            values = factor * self[name].to_numpy().ravel()
            known = values[~np.isnan(values)]
            ends = (
                [f"{value:.4g}" for value in (known.min(), np.median(known), known.max())] if known.size else ["-"] * 3
            )
            rows.append([name, unit, *ends])
        runs = f"{self.sizes['run']} runs, of which {self.diverged_count} diverged" if "run" in self.dims else "one run"
        caption = f"{_machine_name(self)}: {runs}"
        return html_table(caption, ("metric", "unit", "min", "median", "max"), rows) + super()._repr_html_()

    @property
    def diverged_count(self) -> int:
        """Number of runs that diverged."""
        return int(self["diverged"].notnull().sum()) if "diverged" in self else 0


def _varied(metrics: xarray.Dataset) -> list[str]:
    """Return the names of the numeric coordinates that have a value per run."""
    return [
        str(key) for key, values in metrics.coords.items() if values.dims == ("run",) and values.dtype.kind in "iuf"
    ]


def _machine_name(data: xarray.Dataset) -> str:
    return str(data.attrs.get("machine_name", "run"))


def _format_time(value: float) -> str:
    return f"{value:.3f}" if isfinite(value) else "not settled"
