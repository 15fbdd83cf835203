"""Demands over time as a file: what is written is read back, and what is wrong is said in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import InputError
from layflat.machine import load
from layflat.sim import rollout
from layflat.sim.demand_file import read_demand, write_demand

ARM, SMALL = load("paper-arm"), load("paper-small-joint")
HEADER = "time [s],demand.small [deg]\n"


@given(st.lists(st.tuples(*[st.floats(-1.2, 1.2)] * 2), min_size=2, max_size=30))
def test_what_is_written_is_read_back(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, float]]
) -> None:
    demand = np.array(rows)
    path = tmp_path_factory.mktemp("demand") / "demand.csv"
    write_demand(ARM, 0.005 * np.arange(len(demand), dtype=np.float64), demand, path)
    assert read_demand(ARM, path, 0.005) == pytest.approx(demand, rel=1e-5, abs=1e-7)


def test_a_demand_holds_until_the_next(tmp_path: Path) -> None:
    path = tmp_path / "demand.csv"
    path.write_text(HEADER + "0,0\n0.012,10\n0.02,-5\n", encoding="utf-8")
    assert np.degrees(read_demand(SMALL, path, 0.005)[:, 0]) == pytest.approx([0.0, 0.0, 0.0, 10.0, -5.0])


def test_joints_that_a_file_does_not_name_are_held(tmp_path: Path) -> None:
    path = tmp_path / "small.csv"
    path.write_text(HEADER + "0,0\n0.01,10\n", encoding="utf-8")
    assert np.degrees(read_demand(ARM, path, 0.005)) == pytest.approx(np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 10.0]]))


def test_a_machine_follows_it(tmp_path: Path) -> None:
    path = write_demand(
        SMALL,
        0.5 * np.arange(5, dtype=np.float64),
        np.radians([[0.0], [20.0], [20.0], [20.0], [20.0]]),
        tmp_path / "d.csv",
    )
    rows = read_demand(SMALL, path, 0.005)
    run = rollout(SMALL, rows, duration=len(rows) * 0.005, start=0.0)
    assert np.degrees(run["angle"][-1].item()) == pytest.approx(20.0, abs=0.5)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", r"has other columns; give 'time \[s\]', 'demand.small \[deg\]'"),
        ("time [s],demand.large [deg]\n0,1\n1,2\n", r"column 'demand.large \[deg\]' of no joint .*demand.small"),
        ("time [s]\n0\n1\n", r"has other columns; give .*demand.small"),
        (HEADER + "0,0\n", r"holds 1 rows of numbers; give two or more"),
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


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere.csv: can't be read"):
        read_demand(SMALL, tmp_path / "nowhere.csv", 0.005)
