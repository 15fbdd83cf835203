"""Metrics of many runs as a data set: dims `run`, `move` and `joint`."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from layflat._version import __version__
from layflat.description.change import annotation_at, quantity_of
from layflat.motion.scenario import SIGNALS
from layflat.physics.air import NORMAL_DENSITY
from layflat.sim.ensemble.cases import Cases
from layflat.sim.ensemble.loops import hysteresis
from layflat.sim.ensemble.results import AIR_TAKEN, DIVERGENCE_CYCLE, PEAK_ACCELERATION, Results, Traced
from layflat.sim.loop import Timing
from layflat.sim.results import METRICS, UNITS, Metrics
from layflat.sim.tally import LAST_HIGH, LAST_LOW, LAST_SUM, OVERSHOOT, SETTLED_RECORDS, last_records

TRACE_UNITS = dict(zip(Traced._fields, ("rad", "rad/s", "Pa", "Pa", "1", "V"), strict=True))


def metrics_dataset(
    prepared: Cases, results: Results, timing: Timing, workers: int, metrics: Sequence[str] = METRICS
) -> Metrics:
    """Return the results as a data set; metrics of a run that diverged are NaN, except its hysteresis.

    Beside the metrics it has `diverged` (s; NaN where a run did not), the traces that were kept, and as coordinates the
    values of the keys that vary.

    Args:
        prepared: the ensemble.
        results: results of its runs.
        timing: time grid of the runs.
        workers: threads that sweep for hysteresis.
        metrics: names of those to keep.
    """
    cycle = timing.cycle
    joints = list(prepared.base.joints)
    counts = np.zeros((len(prepared.moves), prepared.max_moves))
    for s, moves in enumerate(prepared.moves):
        counts[s, : len(moves)] = [last - first + 1 for first, last in moves]
    ends = counts - np.vectorize(last_records, otypes=[float])(counts)
    records, last = (each[prepared.scenario_index][:, :, None] for each in (counts, ends))
    tallies = results.tallies
    settled = np.where(tallies[..., SETTLED_RECORDS] < records, cycle * tallies[..., SETTLED_RECORDS], np.inf)
    settled[np.isnan(tallies[..., SETTLED_RECORDS])] = np.nan
    by_joint, tip = np.s_[:, :, :-1], np.s_[:, :, -1]
    with np.errstate(invalid="ignore"):  # of runs that diverged
        ripple = tallies[..., LAST_HIGH] - tallies[..., LAST_LOW]
    values = {
        "settling": settled[by_joint],
        "overshoot": tallies[by_joint][..., OVERSHOOT],
        "steady_error": tallies[by_joint][..., LAST_SUM] / last,
        "ripple": ripple[by_joint],
        "tip_settling": settled[tip],
        "tip_error": tallies[tip][..., LAST_HIGH],
        "air_used": results.totals[:, AIR_TAKEN] / NORMAL_DENSITY * 1000.0,
        "peak_acceleration": results.totals[:, PEAK_ACCELERATION],
    }
    diverged = results.totals[:, DIVERGENCE_CYCLE]
    variables: dict[str, Any] = {"diverged": ("run", diverged * cycle, _attributes(*UNITS["diverged"]))}
    for name, value in values.items():
        if name in metrics:
            value[~np.isnan(diverged)] = np.nan
            variables[name] = (("run", "move", "joint")[: value.ndim], value, _attributes(*UNITS[name]))
    if "hysteresis" in metrics:
        variables["hysteresis"] = (("run", "joint"), hysteresis(prepared, workers), _attributes(*UNITS["hysteresis"]))
    coords: dict[str, Any] = {
        "joint": joints,
        **{key: ("run", array, _varied_unit(prepared, key)) for key, array in prepared.vary.items()},
    }
    for column, number in enumerate(results.traced):
        name = Traced._fields[number]
        attributes = _attributes(TRACE_UNITS[name], name.replace("_", " "))
        variables[name] = (("run", "time", "joint"), results.traces[..., column], attributes)
        coords["time"] = ("time", cycle * results.every * np.arange(results.traces.shape[1]))
    # All at once: each assignment to a data set merges it with all other variables.
    data = Metrics(variables, coords)
    data.attrs = {"machine_name": prepared.base.name, "layflat_version": __version__, "step": cycle / timing.steps}
    return data


def _varied_unit(prepared: Cases, key: str) -> dict[str, str]:
    """Return the attributes of a key of `vary`: its unit; empty where it has none or no quantity is known."""
    row = SIGNALS.get(key.split(".")[1]) if key.startswith("scenario.") else None
    if row is not None:
        return {"units": row.recorded[0]}
    try:
        quantity = quantity_of(annotation_at(prepared.base, key))
    except (AttributeError, IndexError, KeyError):  # of the scenario, the start or the controller's machine
        return {}
    return {} if quantity is None else {"units": quantity.unit.replace("*", " ")}


def _attributes(unit: str, meaning: str) -> dict[str, str]:
    return {"units": unit, "long_name": meaning}
