"""Pressures that count from different levels, an ambient pressure that can't be, and angles that come late."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.logs import find_issues, read_log
from layflat.identify.logs.checks.channels import Issue
from layflat.identify.logs.checks.signs import estimate_lag
from layflat.identify.logs.grid import build_clock, build_grid
from layflat.identify.logs.mapping import parse_mapping
from layflat.machine import load
from tests.identify.logs.recordings import ENTRIES, Array, changed, entry, mapping, recorded, run, ticks, write_csv

SMALL = load("paper-small-joint-fast")
ATMOSPHERE = 1.01325  # bar


def checked(folder: Path, columns: dict[str, Array], plan: Any, *, known: bool = False) -> list[Issue]:
    log = read_log(write_csv(folder / "rig.csv", columns), plan, joints=["small"])
    return [issue for issue in find_issues(log, SMALL if known else None) if issue.severity != "note"]


def lifted(columns: dict[str, Array], by: float) -> dict[str, Array]:
    """Higher pressures in both hoses, so that a gauge pressure never falls below ambient."""
    return changed(changed(columns, "pA", lambda x: x + by), "pB", lambda x: x + by)


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize(("gauge", "hose"), [("pA", "pressure_a"), ("pB", "pressure_b")])
def test_a_gauge_beside_an_absolute_pressure_is_told(tmp_path: Path, gauge: str, hose: str, known: bool) -> None:
    """One hose counts from vacuum, the other from ambient, and the mapping says that both are absolute."""
    other = {"pA": "pB", "pB": "pA"}[gauge]
    columns = changed(lifted(recorded(), 0.4), other, lambda x: x + ATMOSPHERE)
    plan = mapping(pA={"gauge": False}, pB={"gauge": False})
    found = [issue for issue in checked(tmp_path, columns, plan, known=known) if issue.channel == f"{hose}.small"]
    assert found
    assert any("gauge = true would fit" in issue.right for issue in found)


def test_a_gauge_pressure_beside_the_difference_is_an_error(tmp_path: Path) -> None:
    columns = lifted(recorded(), 0.4)
    columns = {**changed(columns, "pA", lambda x: x + ATMOSPHERE), "dp": columns["pA"] - columns["pB"]}
    entries = [*mapping(pA={"gauge": False}, pB={"gauge": False}).model_dump(by_alias=True)["column"]]
    plain = {"time": {"column": "time_ms", "unit": "ms"}, "column": [*entries, entry("dp", "measured_pressure", "bar")]}
    (issue,) = [i for i in checked(tmp_path, columns, parse_mapping(plain)) if i.severity == "error"]
    assert issue.channel == "pressure_b.small"
    assert "about ambient pressure, and measured_pressure.small says otherwise" in issue.text


def test_a_set_point_from_another_level_is_an_error(tmp_path: Path) -> None:
    columns = lifted(recorded(), 1.2)
    columns["set"] = np.round(columns["pA"], 1) + ATMOSPHERE
    both = [{**ENTRIES["pA"], "gauge": False}, entry("set", "setpoint_a", "bar", gauge=False), ENTRIES["theta"]]
    plan = parse_mapping({"time": {"column": "time_ms", "unit": "ms"}, "column": both})
    errors = [issue for issue in checked(tmp_path, columns, plan) if "lies" in issue.text]
    assert [issue.severity for issue in errors] == ["error"]
    assert errors[0].text.startswith("lies 1.0")
    assert "gauge = true would fit pressure_a.small" in errors[0].right


@pytest.mark.parametrize(
    ("ambient", "severity", "expected"),
    [
        ("1.013 kPa", "error", "which air has nowhere"),
        ("101.3 bar", "error", "which air has nowhere"),
        ("0.3 bar", "error", "which air has nowhere"),
        ("0.8 bar", "warning", "the machine is described with 1.01 bar"),
        ("0.99 bar", "", ""),
        ("1.013 bar", "", ""),
    ],
)
def test_an_ambient_pressure_that_can_not_be(tmp_path: Path, ambient: str, severity: str, expected: str) -> None:
    plain = {**mapping().model_dump(by_alias=True, exclude={"ambient"}, exclude_none=True), "ambient": ambient}
    issues = [
        i for i in checked(tmp_path, recorded(), parse_mapping(plain), known=True) if "ambient pressure of" in i.text
    ]
    assert [issue.severity for issue in issues] == [severity] * bool(severity)
    assert all(expected in issue.text for issue in issues)


def late(by: float) -> Callable[[Array], Array]:
    """A signal that comes late, at 5 ms a sample."""

    def change(values: Array) -> Array:
        time = 0.005 * np.arange(len(values))
        return np.asarray(np.interp(time - by, time, values))

    return change


@pytest.mark.parametrize("by", [0.1, 0.05, -0.08])
@pytest.mark.parametrize("known", [True, False])
def test_an_angle_that_comes_late_is_told(tmp_path: Path, by: float, known: bool) -> None:
    (issue,) = checked(tmp_path, changed(recorded(), "theta", late(by)), mapping(), known=known)
    assert (issue.severity, issue.channel) == ("warning", "angle.small")
    found = re.match(r"comes about (\d+) ms (after|before) the pressures", issue.text)
    assert found is not None
    assert float(found[1]) * {"after": 1.0, "before": -1.0}[found[2]] == pytest.approx(1e3 * by, abs=6.0)


def test_pressures_that_come_late_are_told_the_same_way(tmp_path: Path) -> None:
    columns = changed(changed(recorded(), "pA", late(0.07)), "pB", late(0.07))
    (issue,) = checked(tmp_path, columns, mapping())
    assert re.match("comes about (65|70|75) ms before the pressures", issue.text)


@pytest.mark.parametrize("machine", ["paper-small-joint-fast", "paper-arm-fast"])
@pytest.mark.parametrize("changes", [{}, {"brake": 0.0}, {"payload": "4 kg"}])
def test_good_logs_have_no_lag(machine: str, changes: dict[str, Any]) -> None:
    simulated = run(machine, **changes)
    for joint in simulated["joint"].values:
        one = simulated.sel(joint=joint)
        assert estimate_lag(one["measured_angle"].values, one["measured_pressure"].values, 0.005) is None


@pytest.mark.parametrize("size", [0, 3, 50, 400])
def test_little_tells_no_lag(size: int) -> None:
    noise = np.random.default_rng(0).normal(size=(2, size))
    assert estimate_lag(noise[0], noise[1], 0.005) is None
    assert estimate_lag(np.zeros(size), np.zeros(size), 0.005) is None
    assert estimate_lag(np.full(size, np.nan), noise[0], 0.005) is None


def test_few_samples_that_move_tell_no_lag() -> None:
    """At 30 Hz a joint may move in so few samples that some lags have enough of them and others have not."""
    simulated = run().sel(joint="small")
    angle, pressure = simulated["measured_angle"].values[::6], simulated["measured_pressure"].values[::6]
    assert estimate_lag(angle, pressure, 0.03) is None


def test_a_lag_is_found_beside_gaps() -> None:
    simulated = run().sel(joint="small")
    angle, pressure = late(0.1)(simulated["measured_angle"].values), simulated["measured_pressure"].values.copy()
    angle[200:260], pressure[400:410] = np.nan, np.nan
    assert estimate_lag(angle, pressure, 0.005) == pytest.approx(0.1, abs=0.011)


def test_a_cycle_that_makes_no_sense_is_refused_before_work(tmp_path: Path) -> None:
    time = ticks(0.005, 12000)
    path = write_csv(tmp_path / "x.csv", {"time": time, "force": np.sin(time)})
    for cycle in ("1 us", "10 us"):
        with pytest.raises(
            InputError, match=r"cycle: 1e-0[56] s make 6e\+0[67] instants of 12000 samples; give 0.0013 s"
        ):
            read_log(path, cycle=cycle)
    assert read_log(path, cycle="0.5 ms").sizes["time"] > 100_000


def test_signals_that_do_not_fit_into_memory_are_refused_before_work() -> None:
    clock = build_clock(np.array([0.0, 1.0, 400.0]), "log")
    with pytest.raises(InputError, match=r"20 signals at 40000001 instants are 6.4 GB; cut the log, map fewer columns"):
        build_grid([*[clock] * 19, build_clock(np.append(ticks(1e-5, 3), 400.0), "log")], None, "log")
