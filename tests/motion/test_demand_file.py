"""Demands over time as a file: what is written is read back, and what is wrong is said in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import InputError
from layflat.machine import load
from layflat.motion.demand_file import read_acting, read_demand, write_demand
from layflat.sim import rollout

ARM, SMALL = load("paper-arm"), load("paper-small-joint")
HEADER = "time [s],demand.small [deg]\n"


@given(st.lists(st.tuples(*[st.floats(-1.04, 1.04)] * 2), min_size=2, max_size=30))
def test_what_is_written_is_read_back(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, float]]
) -> None:
    demand = np.array(rows)
    path = tmp_path_factory.mktemp("demand") / "demand.csv"
    write_demand(ARM, 0.005 * np.arange(len(demand), dtype=np.float64), demand, path)
    assert read_demand(ARM, path, 0.005).angles == pytest.approx(demand, rel=1e-5, abs=1e-7)


def test_a_demand_holds_until_the_next(tmp_path: Path) -> None:
    path = tmp_path / "demand.csv"
    path.write_text(HEADER + "0,0\n0.012,10\n0.02,-5\n", encoding="utf-8")
    assert np.degrees(read_demand(SMALL, path, 0.005).angles[:, 0]) == pytest.approx([0.0, 0.0, 0.0, 10.0, -5.0])


def test_joints_that_a_file_does_not_name_are_held(tmp_path: Path) -> None:
    path = tmp_path / "small.csv"
    path.write_text(HEADER + "0,0\n0.01,10\n", encoding="utf-8")
    found = read_demand(ARM, path, 0.005)
    assert np.degrees(found.angles) == pytest.approx(np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 10.0]]))
    assert found.velocities is None


DISTURBED = "time [s],demand.small [deg],load.large [N mm],payload [g],supply [bar],brake.small [%]\n"


def test_disturbances_hold_until_the_next_row_in_any_unit(tmp_path: Path) -> None:
    path = tmp_path / "demand.csv"
    path.write_text(DISTURBED + "0,0,500,1200,4,100\n0.01,10,-500,800,3,50\n", encoding="utf-8")
    asked, found = read_acting(ARM, path, 0.005)
    assert np.degrees(asked.angles[:, 1]) == pytest.approx([0.0, 0.0, 10.0])
    assert found["load"] == pytest.approx(np.array([[0.5, 0.0], [0.5, 0.0], [-0.5, 0.0]]))
    assert found["payload"][:, 0] == pytest.approx([1.2, 1.2, 0.8])
    assert found["supply"][:, 0] == pytest.approx([4e5, 4e5, 3e5])
    assert found["brake"] == pytest.approx(np.array([[1.0, 1.0], [1.0, 1.0], [1.0, 0.5]]))
    with pytest.raises(InputError, match=r"has a column 'load.large \[N mm\]' of no joint"):
        read_demand(ARM, path, 0.005)


@pytest.mark.parametrize(
    ("column", "value", "expected"),
    [
        ("load.large [bar]", 1, "load.large [bar]: 'bar' is no unit of it; give 'load.large [N m]'"),
        ("load.large", 1, "None is no unit of it"),
        ("brake.small [N m]", 1, "'N m' is no unit of it; give 'brake.small [1]'"),
        ("load.wrist [N m]", 1, "has a column 'load.wrist [N m]' of no joint"),
        ("load [N m]", 1, "has a column 'load [N m]' of no joint"),
        ("payload.small [kg]", 1, "has a column 'payload.small [kg]' of no joint"),
        ("voltage.small [V]", 1, "has a column 'voltage.small [V]' of no joint"),
        ("]payload[", 1, "has a column ']payload[' of no joint"),
        ("payload [kg]", -1, "payload [kg]: -1 kg is out of range"),
    ],
)
def test_columns_that_are_no_disturbance(column: str, value: float, expected: str, tmp_path: Path) -> None:
    path = tmp_path / "demand.csv"
    path.write_text(f"time [s],demand.small [deg],{column}\n0,0,{value}\n1,0,{value}\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_acting(ARM, path, 0.005)
    assert expected in str(caught.value)


def test_a_machine_follows_it(tmp_path: Path) -> None:
    path = write_demand(
        SMALL,
        0.5 * np.arange(5, dtype=np.float64),
        np.radians([[0.0], [20.0], [20.0], [20.0], [20.0]]),
        tmp_path / "d.csv",
    )
    rows = read_demand(SMALL, path, 0.005).angles
    run = rollout(SMALL, rows, duration=len(rows) * 0.005, start=0.0)
    assert np.degrees(run["angle"][-1].item()) == pytest.approx(20.0, abs=0.5)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", r"does not have the time first, then each demand once; give 'time \[s\]', 'demand.small \[deg\]'"),
        ("time [s],demand.large [deg]\n0,1\n1,2\n", r"column 'demand.large \[deg\]' of no joint .*demand.small"),
        ("time [s]\n0\n1\n", r"does not have the time first, .*; give .*demand.small"),
        (HEADER + "0,0\n", r"holds one row of numbers; give two or more"),
        (HEADER + "0,0\n1,\n", r"line 3: is not a row of numbers; give 2"),
        (HEADER + "0,0\n1,2,3\n", r"line 3: is not a row of numbers; give 2"),
        (HEADER + "0,0\n1\n", r"line 3: is not a row of numbers; give 2"),
        (HEADER + "0,0\n1,x\n", r"line 3: is not a row of numbers; give 2"),
        (HEADER + "0,0\n1,nan\n", r"line 3: is not a row of numbers; give 2"),
        (HEADER + "0.5,0\n1,2\n", r"time \[s\]: does not grow from zero; give times 0, 0.005"),
        (HEADER + "0,0\n1,2\n1,3\n", r"time \[s\]: does not grow from zero"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text: str, expected: str, tmp_path: Path) -> None:
    path = tmp_path / "demand.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=expected) as caught:
        read_demand(SMALL, path, 0.005)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_long_file_keeps_its_cycles(tmp_path: Path) -> None:
    time = 2000.0 + 0.005 * np.arange(3, dtype=np.float64)
    path = write_demand(SMALL, np.append(0.0, time), np.zeros((4, 1)), tmp_path / "d.csv")
    assert len(read_demand(SMALL, path, 0.005).angles) == 400_003


def test_rates_are_read_back_with_the_angles(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    time, (q, v, a) = 0.005 * np.arange(9, dtype=np.float64), 0.5 * rng.standard_normal((3, 9, 2)).clip(-2, 2)
    path = write_demand(ARM, time, q, tmp_path / "d.csv", velocity=v, acceleration=a)
    for mine, read in zip((q, v, a), read_demand(ARM, path, 0.005), strict=True):
        assert read is not None
        assert read == pytest.approx(mine, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize(("with_acceleration", "degree"), [(False, 3), (True, 5)])
def test_a_coarse_file_with_rates_gives_a_smooth_motion(with_acceleration: bool, degree: int, tmp_path: Path) -> None:
    """Rows that give velocities say all of a polynomial of third degree, and with accelerations of fifth."""
    motion = np.polynomial.Polynomial(0.2 * np.array([0.1, -0.5, 1.0, -1.0, 0.5, -0.2])[: degree + 1])
    time = np.array([0.0, 0.3, 1.0])
    q, v, a = (motion.deriv(k)(time)[:, None] for k in range(3))
    acceleration = a if with_acceleration else None
    path = write_demand(SMALL, time, q, tmp_path / "d.csv", velocity=v, acceleration=acceleration)
    found = read_demand(SMALL, path, 0.01)
    at = np.linspace(0.0, 1.0, 101)
    assert found.velocities is not None
    assert found.angles[:, 0] == pytest.approx(motion(at), abs=1e-6)
    assert found.velocities[:, 0] == pytest.approx(motion.deriv()(at), abs=1e-5)
    assert (found.accelerations is not None) == with_acceleration
    if found.accelerations is not None:
        assert found.accelerations[:, 0] == pytest.approx(motion.deriv(2)(at), abs=1e-4)


def test_a_joint_without_rates_beside_one_that_has_them(tmp_path: Path) -> None:
    path = tmp_path / "d.csv"
    head = "time [s],demand.large [deg],demand.small [deg],demand_velocity.small [deg/s]\n"
    rows = [f"{t:.2f},{10 * t:.1f},{20 * t:.1f},20\n" for t in np.arange(0, 1, 0.01)]
    path.write_text(head + "".join(rows), encoding="utf-8")
    found = read_demand(ARM, path, 0.01)
    assert found.velocities is not None
    assert np.degrees(found.velocities[1:-1]) == pytest.approx(np.tile([10.0, 20.0], (98, 1)), rel=1e-6)
    assert found.accelerations is None


RATES = "time [s],demand.small [deg],demand_velocity.small [deg/s]\n"
CHANGES = "time [s],demand.small [deg],demand_acceleration.small [deg/s2]\n"
OTHERS = "time [s],demand.small [deg],demand_velocity.large [deg/s]\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (HEADER + "0,0\n1,61\n", r"line 3: asks joint 'small' for 61 deg at 1 s; stay within \+-60 deg"),
        (RATES + "0,0,0\n1,10,-999\n", r"line 3: asks joint 'small' for -999 deg/s at 1 s; it can do 140.49 deg/s"),
        (RATES + "0,0,0\n0.1,30,0\n", r"between its rows: asks joint 'small' for .* deg/s at 0.0.* s; it can do 140"),
        (RATES + "0,59,60\n0.5,59,0\n", r"between its rows: asks joint 'small' for 60.* deg at .* s; stay within"),
        (OTHERS + "0,0,0\n1,1,1\n", r"'demand_velocity.large \[deg/s\]' of no joint"),
        ("time [s],demand_velocity.small [deg/s]\n0,0\n1,1\n", r"without 'demand.small \[deg\]'; give both"),
        (CHANGES + "0,0,0\n1,1,1\n", r"without 'demand_velocity.small \[deg/s\]'; give both"),
    ],
)
def test_what_a_joint_can_not_do_is_refused(text: str, expected: str, tmp_path: Path) -> None:
    test_what_is_wrong_is_said_in_one_line(text, expected, tmp_path)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere.csv: can't be read"):
        read_demand(SMALL, tmp_path / "nowhere.csv", 0.005)


@pytest.mark.parametrize("end", ["\n\n", "\n \n", "\n , \n", "\r\n\r\n"])
def test_empty_lines_are_no_rows(end: str, tmp_path: Path) -> None:
    path = tmp_path / "demand.csv"
    path.write_text(HEADER + "0,0\n\n0.01,10" + end, encoding="utf-8", newline="")
    assert len(read_demand(SMALL, path, 0.005).angles) == 3
    path.write_text(HEADER + "0,0\n\n0.01,100" + end, encoding="utf-8", newline="")
    with pytest.raises(InputError, match="line 4"):
        read_demand(SMALL, path, 0.005)


def test_demands_of_days_are_refused_before_they_are_made(tmp_path: Path) -> None:
    path = tmp_path / "demand.csv"
    path.write_text(HEADER + "0,0\n1e6,10\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"1e\+06 s are 2e\+08 control cycles of 5 ms; give 10000 s or less"):
        read_demand(SMALL, path, 0.005)


@pytest.mark.parametrize("velocity", [False, True])
@pytest.mark.parametrize("acceleration", [False, True])
def test_each_signal_is_read_back_as_what_it_is_or_refused(velocity: bool, acceleration: bool, tmp_path: Path) -> None:
    rows, path = np.zeros((3, 1)), tmp_path / "d.csv"
    rates = {"velocity": rows + 0.2 if velocity else None, "acceleration": rows + 0.4 if acceleration else None}
    if acceleration and not velocity:
        with pytest.raises(InputError, match="acceleration: is given without `velocity`; give both"):
            write_demand(SMALL, 0.005 * np.arange(3.0), rows, path, **rates)
        assert not path.exists()
        return
    series = read_demand(SMALL, write_demand(SMALL, 0.005 * np.arange(3.0), rows, path, **rates), 0.005)
    for written, read in zip(rates.values(), series[1:], strict=True):
        assert (written is None) == (read is None)
        if written is not None and read is not None:
            assert read[0] == pytest.approx(written[0], rel=1e-5)
