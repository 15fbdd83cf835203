"""Runs as an `xarray.Dataset` and on disk (NetCDF)."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from layflat._version import __version__
from layflat.arrays import Array
from layflat.control import ControlKind
from layflat.errors import InputError
from layflat.files import whole_file
from layflat.machine import Machine
from layflat.machine.signals import signal_attributes
from layflat.motion.kinematics import tip_position
from layflat.motion.scenario import SIGNALS, Scenario
from layflat.sim.kernel import JointRecord
from layflat.sim.loop import SharedSignals, Signals, Timing
from layflat.sim.results import Run

__all__ = ["open_run", "save_run"]


def run_dataset(
    machine: Machine, scenario: Scenario, law: ControlKind, acting: Signals, timing: Timing, rows: Array, report: Array
) -> Run:
    """Return a run as a data set: its records, the control law's report, the shared signals, demand and tip.

    Signals of gauge pressure are recorded as absolute pressure.

    Args:
        machine: machine as simulated.
        scenario: scenario as simulated; written into the attributes.
        law: the kind of control law.
        acting: signals that acted on the machine.
        timing: time grid of the run.
        rows: records, (instants, joints, columns of `JointRecord`).
        report: the control law's report, (instants, joints, signals of the control law).
    """
    time = np.arange(len(rows)) * (timing.cycle / timing.records)
    both = ("time", "joint")
    variables: dict[str, Any] = {
        name: (both, rows[:, :, column], signal_attributes(name)) for column, name in enumerate(JointRecord._fields)
    }
    for column, name in enumerate(law.report._fields):  # type: ignore[attr-defined]  # a named tuple
        unit, meaning = law.signals[name]
        variables[name] = (both, report[:, :, column], {"units": unit, "long_name": meaning})
    cycle = np.minimum(np.arange(len(rows)) // timing.records, len(acting.by_joint) - 1)
    for name in ("demand", *SharedSignals._fields):
        row, values = SIGNALS[name], acting.named(name)[cycle]
        values = values + acting.named("ambient")[cycle] if row.gauge else values
        unit, meaning = row.recorded
        variables[name] = (both if row.by_joint else "time", values, {"units": unit, "long_name": meaning})
    tips = tip_position(machine, variables["angle"][1])
    variables["tip"] = (("time", "axis"), tips, signal_attributes("tip"))
    coords = {
        "time": ("time", time, {"units": "s"}),
        "joint": list(machine.joints),
        "axis": list("xyz")[: tips.shape[1]],
    }
    # All at once: each assignment to a data set merges it with all other variables.
    run = Run(variables, coords)
    run.attrs = {
        "machine": machine.model_dump_json(),
        "machine_name": machine.name,
        "layflat_version": __version__,
        "seed": scenario.seed,
        "step": timing.cycle / timing.steps,
        "scenario": json.dumps({k: v for k, v in asdict(scenario).items() if isinstance(v, (str, float, int, bool))}),
    }
    return run


def save_run(run: xarray.Dataset, path: Path) -> Path:
    """Write a data set as NetCDF and return the path.

    Raise OutputError if it can't be written, or a command runs that may not replace the existing file.
    """
    content = run.to_netcdf(None, engine="h5netcdf")  # in memory: HDF5 aborts the process on a full disk
    with whole_file(path) as temporary:
        temporary.write_bytes(content)
    return path


def open_run(path: str | Path) -> Run:
    """Read a run from a NetCDF file; raise InputError if it can't be read as NetCDF.

    Its variables are not checked: those of metrics can be opened too.

    Example:
        >>> import layflat as lf
        >>> path = lf.save(lf.rollout("paper-arm", "10 deg", duration="0.5 s"), "run.nc")
        >>> lf.open_run(path).attrs["machine_name"]
        'paper-arm'
    """
    try:
        with xarray.open_dataset(path, engine="h5netcdf") as data:
            run = data.load()
            return Run(run.data_vars, run.coords, run.attrs)
    except (OSError, ValueError) as error:
        raise InputError(f"can't be read as a run ({error})", where=str(path), right="give a NetCDF file") from None
