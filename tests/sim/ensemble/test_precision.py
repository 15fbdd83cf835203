"""Runs in single precision: what they cost in accuracy, and that all else is as in double precision."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from scipy.stats import ks_2samp

from layflat.errors import InputError
from layflat.machine import load
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble

ARM = load("paper-arm-fast")
MANY = 512
RUNS = 37  # which fills no number of registers
SWAYS = Scenario(opening=[(0.0, (0.3, -0.2)), (0.3, (-0.4, 0.3)), (0.8, (0.1, 0.1))], duration="1.5 s", noise=False)
MOVES = Scenario(demand=[(0.0, (-0.3, -0.3)), (0.2, (0.3, -0.3)), (0.9, (0.3, 0.3))], duration="1.5 s")
VARY = {"scenario.payload": np.linspace(0.0, 2.0, RUNS)}


def test_openings_lead_to_the_same_angles_within_a_hundredth_of_a_degree() -> None:
    double, single = (ensemble(ARM, SWAYS, VARY, precision=one, traces=["angle"]) for one in ("double", "single"))
    error = np.degrees((single.angle - double.angle).to_numpy())
    assert 0.0 < np.sqrt(np.mean(error**2)) < 0.01
    assert float(single.air_used.mean()) == pytest.approx(float(double.air_used.mean()), rel=1e-4)


def test_controlled_runs_are_others_of_the_same_distribution() -> None:
    # A count of a converter that falls the other way leads a controlled arm elsewhere within its band.
    vary = {"scenario.payload": np.linspace(0.0, 2.0, MANY), "seed": np.arange(MANY)}
    double, single = (ensemble(ARM, MOVES, vary, precision=one) for one in ("double", "single"))
    for name in ("settling", "steady_error", "overshoot"):
        pairs = zip(*(each[name].to_numpy().reshape(MANY, -1).T for each in (double, single)), strict=True)
        assert min(ks_2samp(one, other, method="asymp").pvalue for one, other in pairs) > 0.05, name


def test_a_joint_that_its_brake_holds_does_not_move() -> None:
    held = Scenario(opening=0.0, start=0.1, load=0.2, duration="1 s", noise=False)
    vary = VARY | {"scenario.brake": np.full(RUNS, 2.0)}
    assert np.ptp(ensemble(ARM, held, vary, precision="single", traces=["angle"]).angle.to_numpy()) == 0.0


def test_neither_neighbours_nor_threads_matter() -> None:
    vary = VARY | {"seed": np.arange(RUNS)}
    one, two = (ensemble(ARM, MOVES, vary, precision="single", threads=threads) for threads in (1, 2))
    assert one.identical(two)
    some = [RUNS - 1, 5, 0]
    alone = ensemble(ARM, MOVES, {key: values[some] for key, values in vary.items()}, precision="single")
    assert alone.identical(one.isel(run=some))


def test_another_precision_says_which_there_are() -> None:
    with pytest.raises(InputError, match='precision: \'half\' is not a precision; use "double" or "single"'):
        ensemble(ARM, MOVES, runs=1, precision="half")


def test_long_runs_need_double_precision() -> None:
    with pytest.raises(InputError, match="precision: single precision is too coarse for runs of 3600 s"):
        ensemble(ARM, Scenario(duration="1 h"), runs=1, precision="single")


ONE_BY_ONE = """
import sys

import layflat.registers

layflat.registers.host_width = lambda size=8, most=64: 1

from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble

case = Scenario(demand=[("0 s", -0.1), ("0.03 s", 0.1)], duration="0.1 s")
traces = ["angle", "pressure_a"]
many = ensemble("paper-small-joint", case, {"arm.payload": [0.5, 1.5]}, precision="single", traces=traces)
many.to_netcdf(sys.argv[1], engine="h5netcdf")
"""


@pytest.mark.compiled
def test_a_single_lane_keeps_single_precision(tmp_path: Path) -> None:
    places = {"LAYFLAT_CACHE_DIR": str(tmp_path)}
    words = [sys.executable, "-c", ONE_BY_ONE, str(tmp_path / "one.nc")]
    subprocess.run(words, env={**os.environ, **places}, check=True)
    case = Scenario(demand=[("0 s", -0.1), ("0.03 s", 0.1)], duration="0.1 s")
    many: dict[str, Any] = {"vary": {"arm.payload": [0.5, 1.5]}, "traces": ["angle", "pressure_a"]}
    here = ensemble("paper-small-joint", case, precision="single", **many)
    double = ensemble("paper-small-joint", case, **many)
    with xarray.open_dataset(tmp_path / "one.nc", engine="h5netcdf") as alone:
        for trace in ("angle", "pressure_a"):
            assert np.array_equal(alone[trace], here[trace])
            assert not np.array_equal(here[trace], double[trace])
