"""Cause of a run's divergence, as far as laws from outside may be it."""

from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.control import CONTROL_LAWS, Demand, Sensed
from layflat.control.checks import find_flaw
from layflat.kind_checks import place_of
from layflat.machine import Machine
from layflat.sim.cycle import DEMANDS, Signals
from layflat.sim.kernel import Case, Timing

if TYPE_CHECKING:
    import xarray

MAX_REPLAYED = 20_000  # control cycles, which plain Python repeats in some seconds


def find_cause(machine: Machine, case: Case, signals: Signals, timing: Timing, run: "xarray.Dataset") -> str:
    """Return why a run diverged, with file and line where a control law from outside is why; empty where unknown.

    Args:
        machine: the machine.
        case: its parameters.
        signals: all that acted on it.
        timing: how the run was cut.
        run: the run up to where it diverged.
    """
    law = CONTROL_LAWS.of(case.settings)
    if CONTROL_LAWS.is_from_outside(law) and not np.isfinite(run["voltage"].to_numpy()).all():
        flaw = find_flaw(law, case.settings, islice(_cycles(signals, timing.records, run), MAX_REPLAYED), timing.cycle)
        return flaw or f"control law {law.name!r} returns a number that is none ({place_of(law.step)})"
    files = ", ".join(Path(path).name for path in machine.kinds)
    return f"laws of {files} take part in it: see what they return there" if files else ""


def _cycles(signals: Signals, records: int, run: "xarray.Dataset") -> Any:
    """Yield what the control law was given, cycle by cycle."""
    sensed = zip(run["measured_angle"].to_numpy()[::records], run["measured_pressure"].to_numpy()[::records])  # noqa: B905
    asked = zip(*(signals.named(name) for name in DEMANDS))  # noqa: B905
    for (angles, pressures), demands in zip(sensed, asked):  # noqa: B905  # the run ends before its signals
        wanted = Demand(*map(_row, demands))
        yield Sensed(_row(angles), _row(pressures)), wanted


def _row(values: Any) -> tuple[float, ...]:
    return tuple(values.tolist())
