"""Logs of rigs that nobody here built, with the mappings of `research/measured_logs`."""

from pathlib import Path

import numpy as np
import pytest
import xarray

from layflat.identify.logs import find_issues, guess_mapping, read_log

MAPPINGS = Path(__file__).parents[3] / "research" / "measured_logs"


@pytest.fixture(scope="module")
def affetto(measured_data: Path) -> dict[Path, xarray.Dataset]:
    paths = sorted((measured_data / "affetto").glob("*.csv"))
    return {path: read_log(path, MAPPINGS / "affetto.toml") for path in paths}


def test_affetto(affetto: dict[Path, xarray.Dataset]) -> None:
    for path, whole in affetto.items():
        log = read_log(path, MAPPINGS / "affetto.toml", joints=["elbow"]).sel(joint="elbow")
        raw = np.genfromtxt(path, delimiter=",", names=True)
        assert log.attrs["log_period"] == pytest.approx(1.0 / 30.0)
        assert np.degrees(log["angle"].values) == pytest.approx(1.2 * (raw["rq5"] - 50.0))
        assert log["pressure_b"].values == pytest.approx(101325.0 + 1e3 * raw["rpb5"])
        total = (log["setpoint_a"] + log["setpoint_b"]).values - 2 * 101325.0
        assert total == pytest.approx(340.0 * 600e3 / 255.0, rel=1e-5)
        assert not [f for f in find_issues(whole) if f.severity == "error"], path


@pytest.mark.parametrize("signal", ["angle", "pressures"])
def test_affetto_turned_round_is_found(affetto: dict[Path, xarray.Dataset], signal: str) -> None:
    for path, whole in affetto.items():
        log = whole.copy()
        if signal == "angle":
            log["angle"] = -log["angle"]
        else:
            log["pressure_a"], log["pressure_b"] = log["pressure_b"], log["pressure_a"]
        assert [f for f in find_issues(log) if f.severity == "error"], path


def test_a_guess_of_affetto_finds_the_joint_that_moves(measured_data: Path) -> None:
    guess = guess_mapping(measured_data / "affetto" / "motion_data_000.csv", ["elbow"])
    found = {entry.columns[0]: (entry.signal, entry.unit, entry.gauge) for entry in guess.mapping.column}
    assert found["rq5"] == ("angle", "deg", None)
    assert found["qdes5"] == ("demand", "deg", None)
    assert found["rpa5"] == ("pressure_a", "kPa", True)
    assert found["rpb5"] == ("pressure_b", "kPa", True)


def test_zillen(measured_data: Path) -> None:
    for path in sorted((measured_data / "zillen").glob("*.csv")):
        log = read_log(path, MAPPINGS / "zillen.toml")
        raw = np.loadtxt(path)
        assert log.attrs["log_period"] == pytest.approx(1e-3 * np.median(np.diff(raw[:, 0])), rel=0.01)
        assert log["time"].values[-1] == pytest.approx(1e-3 * raw[-1, 0], abs=0.05)
        for name, column, factor, offset in (
            ("position", 4, 1e-3, 0),
            ("pressure", 5, 1e5, 101325),
            ("force", 6, 1, 0),
        ):
            known = log[name].values[np.isfinite(log[name].values)]
            assert known.mean() == pytest.approx(raw[:, column].mean() * factor + offset, rel=0.05), (path, name)
        assert not [f for f in find_issues(log) if f.severity == "error"], path


def test_vessel(measured_data: Path) -> None:
    for path in sorted((measured_data / "vessel").glob("*.csv")):
        log = read_log(path, MAPPINGS / "vessel.toml", cycle="0.5 s")
        assert set(log.data_vars) == {"pressure", "temperature"}
        known = log["pressure"].values[np.isfinite(log["pressure"].values)]
        assert np.all(np.diff(known) < 0.0)  # it blows down
        assert float(log["temperature"].max()) < 300.0
        assert not [f for f in find_issues(log) if f.severity == "error"], path
