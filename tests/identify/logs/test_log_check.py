"""Good logs pass; each mistake that is made in one is found, named, and told how to right."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.logs import find_issues, raise_first_error, read_log, save_run
from layflat.identify.logs.checks.channels import Issue, median_filter
from layflat.identify.logs.mapping import parse_mapping
from layflat.machine import changed as described
from layflat.machine import load
from tests.identify.logs.recordings import Array, changed, mapping, recorded, run, told, write_csv

SMALL = load("paper-small-joint-fast")
Change = Callable[[Array], Array]


def checked(folder: Path, columns: dict[str, Array], plan: Any = None, *, known: bool = True) -> list[Issue]:
    log = read_log(write_csv(folder / "rig.csv", columns), plan or mapping(), joints=["small"])
    return find_issues(log, SMALL if known else None)


@pytest.mark.parametrize("changes", [{}, {"brake": 0.0}, {"payload": "4 kg"}, {"noise": False}, {"supply": "3 bar"}])
@pytest.mark.parametrize("known", [True, False])
def test_a_good_log_passes_without_a_word(tmp_path: Path, changes: dict[str, Any], known: bool) -> None:
    issues = checked(tmp_path, recorded(**changes), known=known)
    assert [f for f in issues if f.severity != "note"] == []


def test_a_simulated_run_passes(tmp_path: Path) -> None:
    assert find_issues(read_log(save_run(run(), tmp_path / "run.nc")), SMALL) == []
    assert [f for f in find_issues(run(), SMALL) if f.severity == "error"] == []
    arm = run("paper-arm-fast")
    assert find_issues(read_log(save_run(arm, tmp_path / "arm.nc")), load("paper-arm-fast")) == []


def scaled(factor: float) -> Change:
    return lambda x: factor * x


def both(columns: dict[str, Array], change: Change) -> dict[str, Array]:
    return changed(changed(columns, "pA", change), "pB", change)


PSI = 14.50377


@pytest.mark.parametrize(
    ("label", "factor", "severity", "right"),
    [
        ("bar", PSI, "error", 'unit = "psi" instead of "bar" would fit (factor 0.06895)'),
        ("bar", 100.0, "error", 'unit = "kPa" instead of "bar" would fit (factor 0.01)'),
        ("psi", 100.0, "error", 'unit = "kPa" instead of "psi" would fit (factor 0.145)'),
        ("MPa", 1.0, "error", 'unit = "bar" instead of "MPa" would fit (factor 0.1)'),
        ("kPa", 1.0, "warning", 'unit = "bar" instead of "kPa" would fit (factor 100)'),
        ("kPa", PSI, "warning", 'unit = "psi" instead of "kPa" would fit (factor 6.895)'),
        ("psi", 1.0, "warning", 'unit = "bar" instead of "psi" would fit (factor 14.5)'),
    ],
)
def test_slips_of_pressure_units(tmp_path: Path, label: str, factor: float, severity: str, right: str) -> None:
    plan = mapping(pA={"unit": label}, pB={"unit": label})
    issues = checked(tmp_path, both(recorded(), scaled(factor)), plan)
    assert right in told(issues, severity, "pressure_a.small")


def vented(x: Array) -> Array:
    """A pressure that begins vented."""
    return np.where(np.arange(x.size) < 40, 0.0, x)


def test_gauge_and_absolute(tmp_path: Path) -> None:
    gauge = both(recorded(), vented)
    absolute = both(gauge, lambda x: x + 1.01325)
    as_absolute = mapping(pA={"gauge": False}, pB={"gauge": False})
    for known in (True, False):
        assert not [f for f in checked(tmp_path, gauge, known=known) if f.severity == "error"]
        issues = checked(tmp_path, gauge, as_absolute, known=known)
        assert "below ambient; it counts from ambient pressure: gauge = true would fit" in told(
            issues, "error", "pressure_a.small"
        )
    issues = checked(tmp_path, absolute)
    expected = "where the supply has 5.01 bar; it is absolute already: gauge = false would fit"
    assert expected in told(issues, "error", "pressure_b.small")
    issues = checked(tmp_path, absolute, known=False)
    expected = "its lowest level is twice ambient pressure; if that is vented air, it is absolute already"
    assert expected in told(issues, "warning", "pressure_b.small")


def test_slips_of_angle_units(tmp_path: Path) -> None:
    wrong = mapping(theta={"unit": "rad"})
    for known in (True, False):
        issues = checked(tmp_path, recorded(), wrong, known=known)
        expected = 'unit = "deg" instead of "rad" would fit (factor 0.01745)'
        assert expected in told(issues, "error", "angle.small")
    issues = checked(tmp_path, changed(recorded(), "theta", np.radians))
    assert 'unit = "rad" instead of "deg" would fit (factor 57.3)' in told(issues, "warning", "angle.small")
    shifted = checked(tmp_path, changed(recorded(), "theta", lambda x: x + 60.0))
    assert "zero is the middle of the stroke: set offset" in told(shifted, "error", "angle.small")


def test_an_angle_in_another_unit_than_its_demand(tmp_path: Path) -> None:
    time = 0.01 * np.arange(500)
    columns = {"time": time, "angle": 0.01 * np.sin(time), "demand": 0.5 * np.sin(time + 0.1)}
    issues = find_issues(read_log(write_csv(tmp_path / "x.csv", columns)))
    expected = "moves 0.0"
    assert expected in told(issues, "error", "angle")
    assert "one of them is in deg and the other in rad" in told(issues, "error", "angle")


@pytest.mark.parametrize(
    ("plan", "column", "change", "channel", "expected"),
    [
        (mapping(), "theta", np.negative, "angle.small", "turn it round with sign = -1"),
        (mapping("valve", "ref"), "theta", np.negative, "angle.small", "or swap hoses A and B"),
        (mapping(), "valve", lambda x: 10.0 - x, "voltage.small", "turn it round with sign = -1"),
        (mapping(pA={"signal": "pressure_b"}, pB={"signal": "pressure_a"}), "theta", np.copy,
         "pressure_a.small and", "rise when the voltage falls, and the joint turns against them"),
        (mapping(), "ref", np.negative, "angle.small", "goes against demand.small"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("known", [True, False])
def test_signs(tmp_path: Path, plan: Any, column: str, change: Any, channel: str, expected: str, known: bool) -> None:
    issues = checked(tmp_path, changed(recorded(), column, change), plan, known=known)
    assert expected in told(issues, "error", channel)


def test_swapped_set_points(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    time = 0.01 * np.arange(1000)
    asked = 2e5 + 1e5 * np.repeat(rng.random(20), 50)
    follows = np.empty(1000)
    level = asked[0]
    for i, aim in enumerate(asked):
        follows[i] = level = level + 0.1 * (aim - level)
    noise = 100.0 * rng.normal(size=(2, 1000))
    columns = {"time": time, "pressure_a": follows + noise[0], "pressure_b": 5e5 - follows + noise[1],
               "setpoint_a": asked, "setpoint_b": 5e5 - asked}  # fmt: skip
    assert not find_issues(read_log(write_csv(tmp_path / "x.csv", columns)))
    columns["setpoint_a"], columns["setpoint_b"] = columns["setpoint_b"], columns["setpoint_a"]
    issues = find_issues(read_log(write_csv(tmp_path / "x.csv", columns)))
    assert "falls when setpoint_a rises" in told(issues, "error", "pressure_a")


def test_units_of_voltage_temperature_brake_and_time(tmp_path: Path) -> None:
    issues = checked(tmp_path, changed(recorded(), "valve", scaled(1e3)))
    assert 'unit = "mV" instead of "V" would fit' in told(issues, "error", "voltage.small")
    issues = checked(tmp_path, recorded(), mapping(valve={"unit": "mV"}))
    assert 'unit = "V" instead of "mV" would fit' in told(issues, "warning", "voltage.small")
    issues = checked(tmp_path, recorded(), mapping(time="s"))
    assert "check the unit of time: a factor of 0.001 would fit" in told(issues, "error", "log")
    time = 0.1 * np.arange(100)
    columns = {"time": time, "temperature": 20.0 + np.sin(time), "brake": 50.0 + 50.0 * np.sin(time)}
    issues = find_issues(read_log(write_csv(tmp_path / "x.csv", columns)))
    assert 'unit = "degC" would add 273.15 K' in told(issues, "error", "temperature")
    assert 'unit = "%" instead of "1" would fit (factor 0.01)' in told(issues, "error", "brake")


def frozen(x: Array) -> Array:
    return np.full_like(x, x[0])


def test_dead_channels(tmp_path: Path) -> None:
    issues = checked(tmp_path, changed(recorded(), "theta", frozen))
    assert "a dead sensor: leave the channel out" in told(issues, "error", "angle.small")
    still = changed(changed(changed(recorded(), "theta", frozen), "valve", frozen), "ref", frozen)
    issues = checked(tmp_path, both(still, frozen))
    assert told(issues, "error", "log").startswith("nothing in it moves more than its noise")


def test_what_is_clipped_and_what_only_rests(tmp_path: Path) -> None:
    clipped = checked(tmp_path, changed(recorded(), "theta", lambda x: np.clip(x, -30.0, 20.0)))
    assert "stands at its lowest value, -30 deg" in told(clipped, "warning", "angle.small")
    assert "stands at its highest value, 20 deg" in told(clipped, "warning", "angle.small")
    quiet = checked(tmp_path, recorded(noise=False))
    assert "stands at" not in told(quiet, "warning", "angle.small")


@pytest.mark.parametrize(("frequency", "thrown"), [(3.0, True), (0.5, False)])
def test_a_joint_that_is_thrown_to_its_stop_and_one_that_comes_to_it(frequency: float, thrown: bool) -> None:
    log = run()
    time = log["time"].to_numpy()
    angle = np.where(time > 0.5, 1.3 * np.sin(2.0 * np.pi * frequency * (time - 0.5)), 0.0)
    angle[(time > 0.6) & (time < 0.62)] = np.nan
    angle[50] = 1.3  # a wild sample
    told_of = [
        one for one in find_issues(log.assign(angle=(log["angle"].dims, angle[:, None])), SMALL) if "stop" in one.text
    ]
    assert [one.channel for one in told_of] == (["angle.small"] if thrown else [])
    if thrown:
        assert told_of[0].text == "is thrown to its stop at 0.565 s"
        assert told_of[0].right == "a fit goes no further: log it again, slower or over a smaller reach"


@pytest.mark.parametrize(("sensor", "thrown"), [("130 deg", True), ("100 deg", False)])
def test_beyond_the_end_of_a_sensor_a_stop_is_supposed_only_outside_the_stroke(sensor: str, thrown: bool) -> None:
    log = run()
    time = log["time"].to_numpy()
    end = np.radians(float(sensor.split(maxsplit=1)[0])) / 2.0
    angle = np.clip(1.3 * np.sin(2.0 * np.pi * 3.0 * time), -end, end)[:, None]
    machine = described(SMALL, "angle_sensor.range", sensor)
    found = find_issues(log.assign(angle=(log["angle"].dims, angle)), machine)
    assert any("is thrown to its stop" in one.text for one in found) == thrown


def test_a_median_of_three_leaves_a_way_as_it_is() -> None:
    way = np.sort(np.random.default_rng(0).random(50))
    np.testing.assert_array_equal(median_filter(way), way)
    spiked = way.copy()
    spiked[20] = 9.0
    assert np.abs(median_filter(spiked) - way).max() <= np.diff(way).max()


def test_missing_samples(tmp_path: Path) -> None:
    def holes(x: Array) -> Array:
        x[100:130] = np.nan
        x[300:310] = np.nan
        return x

    issues = checked(tmp_path, changed(recorded(), "theta", holes))
    expected = "40 of 601 instants (6.7 %) are missing, in 2 gaps, the longest 0.15 s from 0.500 s"
    assert expected in told(issues, "warning", "angle.small")

    def most(x: Array) -> Array:
        x[200:] = np.nan
        return x

    assert "give a whole recording" in told(
        checked(tmp_path, changed(recorded(), "theta", most)), "error", "angle.small"
    )
    empty = checked(tmp_path, changed(recorded(), "theta", lambda x: np.full_like(x, np.nan)))
    assert "holds no value" in told(empty, "error", "angle.small")


def test_missing_channels_and_joints(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "rig.csv", recorded())
    log = read_log(path, mapping("theta", "valve", "ref"), joints=["large", "small"])
    issues = find_issues(log, load("paper-arm-fast"))
    assert told(issues, "warning", "large").startswith("has no channel in this log")
    assert "has no angle; map its angle" in told(issues, "warning", "small")
    assert "has no command; map voltage" in told(issues, "warning", "small")
    other = find_issues(read_log(path, mapping(theta={"joint": "elbow"})), SMALL)
    assert "is not a joint of the machine; its joints are small" in told(other, "error", "elbow")
    commands = find_issues(read_log(path, mapping("theta", "pA", "pB")), SMALL)
    assert "holds nothing that was measured" in told(commands, "error", "log")
    assert "has no pressure" in told(commands, "note", "small")


def test_a_log_that_is_too_short(tmp_path: Path) -> None:
    few = {name: values[:8] for name, values in recorded().items()}
    assert "holds 8 samples; give 10 at the very least" in told(checked(tmp_path, few), "error", "log")
    short = {name: values[:200] for name, values in recorded().items()}
    assert "lasts 0.995 s, which is shorter than a move" in told(checked(tmp_path, short), "warning", "log")


def test_what_does_not_move(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    time = 0.01 * np.arange(1000)
    columns = {"time": time, "force": 5.0 + 0.1 * rng.normal(size=1000), "position": 0.1 * np.sin(time),
               "voltage": np.full(1000, 5.0)}  # fmt: skip
    issues = find_issues(read_log(write_csv(tmp_path / "x.csv", columns)))
    assert "moves no more than its noise" in told(issues, "warning", "force")
    assert "moves" not in told(issues, "warning", "position")
    assert "voltage never change" in told(issues, "warning", "voltage")


def test_errors_refuse_a_log_in_one_line_and_the_rest_does_not() -> None:
    worst = [Issue("error", "angle.a", "is dead", "repair it"), Issue("error", "b", "x"), Issue("note", "c", "y")]
    with pytest.raises(InputError) as caught:
        raise_first_error(worst, "rig.csv")
    assert str(caught.value) == "rig.csv: angle.a: is dead (and 1 more error); repair it"
    raise_first_error(worst[2:])


def test_a_log_of_one_joint_is_checked_beside_others(tmp_path: Path) -> None:
    columns = recorded()
    plan = parse_mapping({"time": {"column": "time_ms", "unit": "ms"}, "column": [
        {"from": "theta", "signal": "angle", "joint": "small", "unit": "deg"},
        {"from": "ref", "signal": "demand", "joint": "large", "unit": "deg"},
    ]})  # fmt: skip
    log = read_log(write_csv(tmp_path / "x.csv", columns), plan, joints=["large", "small"])
    assert not [f for f in find_issues(log, load("paper-arm-fast")) if f.severity == "error"]
