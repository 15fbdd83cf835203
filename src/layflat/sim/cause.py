"""Cause of a run's divergence, if laws that the user supplied may be that cause."""

from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.control import CONTROL_LAWS, Demand, Sensed
from layflat.control.checks import find_flaw
from layflat.kind_checks import place_of
from layflat.machine import Machine
from layflat.sim.loop import DEMAND_SIGNALS, Case, Signals, Timing

if TYPE_CHECKING:
    import xarray

MAX_REPLAYED = 20_000  # control cycles, which plain Python repeats in a few seconds


def find_cause(machine: Machine, case: Case, signals: Signals, timing: Timing, run: "xarray.Dataset") -> str:
    """Return a text that names the user's laws that may have caused a divergence; empty if the machine uses none.

    A user's control law that made a voltage non-finite is called again with the inputs of the run, and named by file
    and line; otherwise the text lists the user's files of laws.

    Args:
        machine: the machine.
        case: its parameters.
        signals: signals of the scenario.
        timing: time grid of the run.
        run: the run up to its divergence.
    """
    law = CONTROL_LAWS.kind_of(case.settings)
    if CONTROL_LAWS.is_from_outside(law) and not np.isfinite(run["voltage"].to_numpy()).all():
        flaw = find_flaw(
            law, case.settings, islice(_replayed_cycles(signals, timing.records, run), MAX_REPLAYED), timing.cycle
        )
        return flaw or f"control law {law.name!r} returns a number that is not finite ({place_of(law.step)})"
    files = ", ".join(Path(path).name for path in machine.kinds)
    return f"laws of {files} took part in the run: check the numbers that they return" if files else ""


def _replayed_cycles(signals: Signals, records: int, run: "xarray.Dataset") -> Any:
    """Yield readings and demands of each recorded control cycle, of `records` records each."""
    sensed = zip(run["measured_angle"].to_numpy()[::records], run["measured_pressure"].to_numpy()[::records])  # noqa: B905
    demand_rows = zip(*(signals.named(name) for name in DEMAND_SIGNALS))  # noqa: B905
    for (angles, pressures), demands in zip(sensed, demand_rows):  # noqa: B905  # the run ends before its signals
        yield Sensed(_float_row(angles), _float_row(pressures)), Demand(*map(_float_row, demands))


def _float_row(values: Any) -> tuple[float, ...]:
    return tuple(values.tolist())
