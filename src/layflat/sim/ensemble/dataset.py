"""The metrics of many runs as an `xarray.Dataset`: dims `run`, `move` and `joint`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray

from layflat._version import __version__
from layflat.physics.air import NORMAL_DENSITY
from layflat.sim.ensemble.cases import Cases
from layflat.sim.ensemble.loops import hysteresis
from layflat.sim.ensemble.results import ACCELERATION, AIR, DIVERGED, Results, Traced
from layflat.sim.kernel import Timing
from layflat.sim.tally import LAST_HIGH, LAST_LOW, LAST_SUM, OVERSHOOT, SETTLED, last_records

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

TRACE_UNITS = dict(zip(Traced._fields, ("rad", "rad/s", "Pa", "Pa", "1", "V"), strict=True))


def measured(
    prepared: Cases, results: Results, timing: Timing, workers: int, metrics: Sequence[str] = METRICS
) -> xarray.Dataset:
    """Name the results; so many threads sweep for hysteresis. Metrics of a run that diverged are not numbers."""
    cycle = timing.cycle
    joints = list(prepared.base.joints)
    counts = np.zeros((len(prepared.moves), prepared.most_moves))
    for s, moves in enumerate(prepared.moves):
        counts[s, : len(moves)] = [last - first + 1 for first, last in moves]
    ends = counts - np.vectorize(last_records, otypes=[float])(counts)
    records, last = (each[prepared.which][:, :, None] for each in (counts, ends))
    tallies = results.tallies
    settled = np.where(tallies[..., SETTLED] < records, cycle * tallies[..., SETTLED], np.inf)
    settled[np.isnan(tallies[..., SETTLED])] = np.nan
    each, tip = np.s_[:, :, :-1], np.s_[:, :, -1]
    with np.errstate(invalid="ignore"):  # of runs that diverged
        swing = tallies[..., LAST_HIGH] - tallies[..., LAST_LOW]
    values = {
        "settling": settled[each],
        "overshoot": tallies[each][..., OVERSHOOT],
        "steady_error": tallies[each][..., LAST_SUM] / last,
        "ripple": swing[each],
        "tip_settling": settled[tip],
        "tip_error": tallies[tip][..., LAST_HIGH],
        "air_used": results.totals[:, AIR] / NORMAL_DENSITY * 1000.0,
        "peak_acceleration": results.totals[:, ACCELERATION],
    }
    diverged = results.totals[:, DIVERGED]
    said: dict[str, Any] = {"diverged": ("run", diverged * cycle, _told(*UNITS["diverged"]))}
    for name, value in values.items():
        if name in metrics:
            value[~np.isnan(diverged)] = np.nan
            said[name] = (("run", "move", "joint")[: value.ndim], value, _told(*UNITS[name]))
    if "hysteresis" in metrics:
        said["hysteresis"] = (("run", "joint"), hysteresis(prepared, workers), _told(*UNITS["hysteresis"]))
    coords: dict[str, Any] = {"joint": joints, **{key: ("run", array) for key, array in prepared.vary.items()}}
    for column, number in enumerate(results.traced):
        name = Traced._fields[number]
        told = _told(TRACE_UNITS[name], name.replace("_", " "))
        said[name] = (("run", "time", "joint"), results.traces[..., column], told)
        coords["time"] = ("time", cycle * results.every * np.arange(results.traces.shape[1]))
    # All at once: laid into a dataset one by one, they would be merged with all others each time.
    data = xarray.Dataset(said, coords)
    data.attrs = {"machine_name": prepared.base.name, "layflat_version": __version__, "step": cycle / timing.steps}
    return data


def _told(unit: str, meaning: str) -> dict[str, str]:
    return {"units": unit, "long_name": meaning}
