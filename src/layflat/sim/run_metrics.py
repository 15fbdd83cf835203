"""All metrics of a run as one data set, with the names of an ensemble's."""

from collections.abc import Callable
from typing import Any

import numpy as np

from layflat.arrays import Dataset
from layflat.description import units as u
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.motion.signal_values import Value, read_number
from layflat.sim.metrics import (
    SETTLING_BAND,
    TIP_BAND,
    MoveMetrics,
    air_used,
    measure_move,
    move_windows,
    peak_tip_acceleration,
)
from layflat.sim.tip_metrics import measure_tip_moves

__all__ = ["metrics"]

NEEDED_SIGNALS = ("angle", "demand", "tip", "air_taken")


def metrics(run: Dataset, *, band: Value = SETTLING_BAND, tip_band: Value = TIP_BAND) -> Dataset:
    """Return the metrics of a run, by the names that `ensemble` gives them: settling, overshoot, air used ...

    A move goes from one change of any demand to the next. Joints that stand still have metrics too: those of how they
    hold their angle.

    Args:
        run: run of `rollout` or `open_run`.
        band: settling band of a joint; a number is in rad.
        tip_band: settling band of the tip; a number is in m.

    Returns:
        Metrics with their units, by move and joint; `start` is the time at which a move begins, s.

    Raises:
        InputError: `run` is no simulated run, or a band is no angle or length.

    Example:
        >>> import layflat as lf
        >>> run = lf.rollout("paper-arm", {"large": "20 deg"}, start="0 deg", duration="1.5 s")
        >>> measured = lf.metrics(run)
        >>> float(measured["settling"].max())  # s
        0.995
        >>> measured["air_used"].units
        'l'
    """
    from layflat.sim.results import Metrics  # noqa: PLC0415  # xarray takes long to import

    _check_run(run)
    angle_band, distance = read_number(band, u.ANGLE, "band"), read_number(tip_band, u.LENGTH, "tip_band")
    time, joints = run["time"].to_numpy(), [str(name) for name in run["joint"].to_numpy()]
    moves = [(float(time[first]), float(time[last])) for first, last in move_windows(run["demand"].to_numpy())]
    rows = [[measure_move(run, joint, *span, angle_band) for joint in joints] for span in moves]
    tips = [tip for _, tip in measure_tip_moves(run, (distance,))]

    def each(value: Callable[[MoveMetrics], float]) -> Any:
        return ("move", "joint"), np.array([[value(one) for one in row] for row in rows])

    values: dict[str, Any] = {
        "settling": each(lambda one: one.settling),
        "overshoot": each(lambda one: one.overshoot),
        "steady_error": each(lambda one: one.steady_error),
        "ripple": each(lambda one: one.ripple),
        "tip_settling": ("move", [tip.settling[0] for tip in tips]),
        "tip_error": ("move", [tip.error for tip in tips]),
        "air_used": ((), air_used(run)),
        "peak_acceleration": ((), peak_tip_acceleration(run)),
    }
    starts = ("move", [start for start, _ in moves], {"units": "s", "long_name": "time at which the move begins"})
    return Metrics.from_values(values, {"joint": joints, "start": starts}, str(run.attrs["machine_name"]))


def _check_run(run: object) -> None:
    """Raise InputError unless `run` is a data set with the variables `NEEDED_SIGNALS`."""
    missing = [name for name in NEEDED_SIGNALS if name not in getattr(run, "data_vars", ())]
    if missing:
        what = f"has no {missing[0]}" if hasattr(run, "data_vars") else f"{shown(run)} is no run"
        raise InputError(what, where="run", right="give what `rollout` or `open_run` returns")
