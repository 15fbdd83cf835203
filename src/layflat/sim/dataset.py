"""A run as an `xarray.Dataset`, and runs on disk (NetCDF)."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import xarray
from numpy.typing import NDArray

import layflat
from layflat.errors import InputError
from layflat.files import whole_file
from layflat.machine import Machine
from layflat.sim.kernel import Sample, Signals, Timing
from layflat.sim.kinematics import tip_position
from layflat.sim.scenario import Scenario

UNITS: dict[str, tuple[str, str]] = {
    "angle": ("rad", "joint angle"),
    "velocity": ("rad/s", "joint velocity"),
    "pressure_a": ("Pa", "absolute pressure in hose A"),
    "pressure_b": ("Pa", "absolute pressure in hose B"),
    "temperature_a": ("K", "temperature of the air in hose A"),
    "temperature_b": ("K", "temperature of the air in hose B"),
    "valve_opening": ("1", "opening of the valve towards filling hose A, share of full opening"),
    "voltage": ("V", "control voltage"),
    "measured_angle": ("rad", "angle as sampled"),
    "measured_pressure": ("Pa", "differential pressure as sampled"),
    "averaged_angle": ("rad", "angle averaged over the dither period"),
    "averaged_velocity": ("rad/s", "velocity from the averaged angle"),
    "averaged_pressure": ("Pa", "differential pressure averaged over the dither period"),
    "ripple": ("Pa", "amplitude of the pressure at the dither frequency"),
    "phase": ("1", "phase of the controller"),
    "short_term": ("V", "short-term integral F"),
    "long_term": ("V", "long-term integral FL"),
    "learning": ("1", "1 while the long-term integral may build"),
    "hose_torque": ("N m", "torque lost in hose and strap"),
    "gas_work": ("J", "work of the air on the joint since the start"),
    "load_work": ("J", "work of external torques and gravity since the start"),
    "hose_work": ("J", "work done on hose and strap losses since the start"),
    "hose_stored": ("J", "part of it that is stored"),
    "brake_heat": ("J", "heat of the brake since the start"),
    "damping_heat": ("J", "heat of viscous friction and stops since the start"),
    "air_taken": ("kg", "air taken from the supply since the start"),
}
"""Unit and meaning of every recorded column."""


def dataset(
    machine: Machine, scenario: Scenario, acting: Signals, rows: NDArray[np.float64], timing: Timing
) -> xarray.Dataset:
    """Name the columns of a run and lay demand and tip position beside them."""
    time = np.arange(len(rows)) * (timing.cycle / timing.records)
    names = list(machine.joints)
    run = xarray.Dataset(coords={"time": ("time", time, {"units": "s"}), "joint": names})
    for column, name in enumerate(Sample._fields):
        unit, meaning = UNITS[name]
        run[name] = (("time", "joint"), rows[:, :, column], {"units": unit, "long_name": meaning})
    cycle = np.minimum(np.arange(len(rows)) // timing.records, len(acting.demand) - 1)
    run["demand"] = (("time", "joint"), acting.demand[cycle], {"units": "rad", "long_name": "angle asked for"})
    run["payload"] = (("time",), acting.payload[cycle], {"units": "kg", "long_name": "payload"})
    run["supply"] = (("time",), acting.supply[cycle], {"units": "Pa", "long_name": "absolute supply pressure"})
    where = {"units": "m", "long_name": "position of the tip"}
    run["tip"] = (("time", "axis"), tip_position(machine, run["angle"].to_numpy()), where)
    run = run.assign_coords(axis=["x", "y"])
    run.attrs = {
        "machine": machine.model_dump_json(),
        "machine_name": machine.name,
        "layflat_version": layflat.__version__,
        "seed": scenario.seed,
        "step": timing.cycle / timing.steps,
        "scenario": json.dumps({k: v for k, v in asdict(scenario).items() if isinstance(v, (str, float, int, bool))}),
    }
    return run


def save(run: xarray.Dataset, path: Path) -> Path:
    """Write a run as NetCDF.

    Raises:
        OutputError: it can't be written there.
    """
    with whole_file(path) as temporary:
        run.to_netcdf(temporary, engine="h5netcdf")
    return path


def open_run(path: Path) -> xarray.Dataset:
    """Read a run back.

    Raises:
        InputError: the file is missing or is no run.
    """
    try:
        with xarray.open_dataset(path, engine="h5netcdf") as run:
            return run.load()
    except (OSError, ValueError) as error:
        raise InputError(f"can't be read as a run ({error})", where=str(path), right="give a NetCDF file") from None
