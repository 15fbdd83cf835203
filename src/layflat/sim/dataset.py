"""A run as an `xarray.Dataset`, and runs on disk (NetCDF)."""

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
from layflat.machine.signals import attributes
from layflat.motion.kinematics import tip_position
from layflat.motion.scenario import SIGNALS, Scenario
from layflat.sim.cycle import Around, Signals
from layflat.sim.kernel import Sample, Timing


def dataset(
    machine: Machine, scenario: Scenario, law: ControlKind, acting: Signals, timing: Timing, rows: Array, shown: Array
) -> xarray.Dataset:
    """Return a run with named columns, those of the control law's report among them, and with its demand and tip.

    Args:
        machine: as simulated.
        scenario: what happened.
        law: the kind of control law.
        acting: what acted on the machine.
        timing: the run's cut into cycles, steps and records.
        rows: (instants, joints, columns of `Sample`).
        shown: (instants, joints, signals of the control law).
    """
    time = np.arange(len(rows)) * (timing.cycle / timing.records)
    both = ("time", "joint")
    said: dict[str, Any] = {
        name: (both, rows[:, :, column], attributes(name)) for column, name in enumerate(Sample._fields)
    }
    for column, name in enumerate(law.report._fields):  # type: ignore[attr-defined]  # a named tuple
        unit, meaning = law.signals[name]
        said[name] = (both, shown[:, :, column], {"units": unit, "long_name": meaning})
    cycle = np.minimum(np.arange(len(rows)) // timing.records, len(acting.by_joint) - 1)
    for name in ("demand", *Around._fields):
        row, values = SIGNALS[name], acting.named(name)[cycle]
        values = values + acting.named("ambient")[cycle] if row.gauge else values
        unit, meaning = row.recorded
        said[name] = (both if row.by_joint else "time", values, {"units": unit, "long_name": meaning})
    tips = tip_position(machine, said["angle"][1])
    said["tip"] = (("time", "axis"), tips, attributes("tip"))
    coords = {
        "time": ("time", time, {"units": "s"}),
        "joint": list(machine.joints),
        "axis": list("xyz")[: tips.shape[1]],
    }
    # All at once: laid into a dataset one by one, they would be merged with all others each time.
    run = xarray.Dataset(said, coords)
    run.attrs = {
        "machine": machine.model_dump_json(),
        "machine_name": machine.name,
        "layflat_version": __version__,
        "seed": scenario.seed,
        "step": timing.cycle / timing.steps,
        "scenario": json.dumps({k: v for k, v in asdict(scenario).items() if isinstance(v, (str, float, int, bool))}),
    }
    return run


def save(run: xarray.Dataset, path: Path) -> Path:
    """Write a run as NetCDF; raise OutputError if it can't be written there."""
    content = run.to_netcdf(None, engine="h5netcdf")  # in memory: HDF5 brings the process down on a full disk
    with whole_file(path) as temporary:
        temporary.write_bytes(content)
    return path


def open_run(path: Path) -> xarray.Dataset:
    """Read a run back; raise InputError if the file is missing or is not a run."""
    try:
        with xarray.open_dataset(path, engine="h5netcdf") as run:
            return run.load()
    except (OSError, ValueError) as error:
        raise InputError(f"can't be read as a run ({error})", where=str(path), right="give a NetCDF file") from None
