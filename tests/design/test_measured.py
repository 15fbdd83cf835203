"""Measured tables: read as they are meant, or refused with file, line and column."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from layflat.design import design_joint, read_characteristic, table1
from layflat.errors import InputError
from layflat.machine import load

TABLE = table1().columns
TURNED = "angle_deg,torque_Nm\n" + "".join(
    f"{b:.9g},{T:.9g}\n" for b, T in zip(TABLE["b_deg"], TABLE["T_Nm"], strict=True)
)
PULLED = "travel_mm,force_N\n" + "".join(
    f"{s * 1e3:.9g},{F:.9g}\n" for s, F in zip(TABLE["move_m"], TABLE["force_N"], strict=True)
)


def written(folder: Path, text: str) -> Path:
    path = folder / "test.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_table_of_eq1_gives_the_cam_of_eq1(tmp_path: Path) -> None:
    machine = load("paper-arm")
    measured = read_characteristic(written(tmp_path, TURNED), pressure=4e5, roller_radius=0.026)
    assert measured.fit_error < 1e-3
    exact, own = design_joint(machine, "large"), design_joint(machine, "large", measured=measured)
    assert own.mean_torque == pytest.approx(exact.mean_torque, rel=2e-3)
    np.testing.assert_allclose(own.with_cam().lever, exact.with_cam().lever, rtol=5e-3)


def test_force_over_travel_is_the_same_curve(tmp_path: Path) -> None:
    turned = read_characteristic(written(tmp_path, TURNED), pressure=4e5, roller_radius=0.026)
    pulled = read_characteristic(written(tmp_path, PULLED), pressure=4e5)
    # The table turned degrees into metres with pi = 3.14.
    np.testing.assert_allclose(pulled.force, turned.force, rtol=1e-6)
    np.testing.assert_allclose(pulled.travel, turned.travel * 3.14 / np.pi, rtol=1e-7)


def test_pressure_may_stand_in_a_column_and_comments_anywhere(tmp_path: Path) -> None:
    lines = TURNED.splitlines()
    text = "\n".join(["# a bench test", lines[0] + ",pressure_bar", "", *(line + ", 4" for line in lines[1:])])
    plain = read_characteristic(written(tmp_path, TURNED), pressure=4e5, roller_radius=0.026)
    own = read_characteristic(written(tmp_path, text), roller_radius=0.026)
    np.testing.assert_allclose(own.force, plain.force, rtol=1e-12)


def test_noise_does_not_make_the_cam_hollow(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).normal(0.0, 0.5, TABLE["T_Nm"].size)
    rows = "".join(f"{b},{T}\n" for b, T in zip(TABLE["b_deg"], TABLE["T_Nm"] + noise, strict=True))
    measured = read_characteristic(
        written(tmp_path, "angle_deg,torque_Nm\n" + rows), pressure=4e5, roller_radius=0.026, degree=2
    )
    assert design_joint(load("paper-arm"), "large", measured=measured).with_cam().convex


def changed(line: int, text: str) -> str:
    lines = TURNED.splitlines()
    lines[line] = text
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (changed(3, "26.64,nan"), r"test\.csv, line 4: torque_Nm: 'nan' is not finite"),
        (changed(3, "26.64,inf"), r"line 4: torque_Nm: 'inf' is not finite"),
        (changed(3, "26.64,98;4"), r"line 4: torque_Nm: '98;4' is not a number"),
        (changed(3, "26.64"), r"line 4: 1 values; give 2: angle_deg, torque_Nm"),
        (changed(3, "26.64,98,4"), r"line 4: 3 values"),
        (changed(3, "10,98"), r"line 4: angle_deg: 10 does not rise above the line before"),
        (changed(3, "26.64,-98"), r"line 4: torque_Nm: -98 is not positive"),
        (changed(0, "degrees,torque_Nm"), r"no column angle_deg or angle_rad.*columns here are degrees, torque_Nm"),
        (changed(0, "angle_deg,force_N"), r"angle_deg beside force_N"),
        (changed(0, "angle_deg,angle_deg"), r"line 1: column 'angle_deg' appears twice"),
        ("angle_deg,torque_Nm\n0,1\n1,1\n", r"2 rows of data; give a header and at least 5"),
        ("", r"0 rows of data"),
        (TURNED.replace("13.32", '"13.32'), r"is not CSV"),
    ],
)
def test_a_broken_table_is_refused_in_one_line(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        read_characteristic(written(tmp_path, text), pressure=4e5, roller_radius=0.026)
    assert "\n" not in str(caught.value)


def test_two_columns_that_say_the_same_are_refused(tmp_path: Path) -> None:
    text = "angle_deg,angle_rad,torque_Nm\n" + "".join(f"{k},{k},1\n" for k in range(6))
    with pytest.raises(InputError, match="columns angle_deg, angle_rad give the same quantity"):
        read_characteristic(written(tmp_path, text), pressure=4e5, roller_radius=0.026)


@pytest.mark.parametrize("pressure", [None, 0.0, -1.0, float("nan")])
def test_pressure_is_needed(tmp_path: Path, pressure: float | None) -> None:
    with pytest.raises(InputError, match="pressure"):
        read_characteristic(written(tmp_path, TURNED), pressure=pressure, roller_radius=0.026)


def test_a_pressure_of_zero_in_a_column_names_its_line(tmp_path: Path) -> None:
    lines = TURNED.splitlines()
    text = "\n".join([lines[0] + ",pressure_bar", *(line + ",0" for line in lines[1:])])
    with pytest.raises(InputError, match="line 2: pressure_bar: 0 bar; give the gauge pressure"):
        read_characteristic(written(tmp_path, text), roller_radius=0.026)


@pytest.mark.parametrize("radius", [None, 0.0, -0.01])
def test_a_table_of_angles_needs_the_rollers_radius(tmp_path: Path, radius: float | None) -> None:
    with pytest.raises(InputError, match="roller radius"):
        read_characteristic(written(tmp_path, TURNED), pressure=4e5, roller_radius=radius)


def test_a_degree_below_1_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="degree of the polynomial: 0 is below 1"):
        read_characteristic(written(tmp_path, TURNED), pressure=4e5, roller_radius=0.026, degree=0)


def test_a_missing_file_and_a_binary_one_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.csv: can't be read"):
        read_characteristic(tmp_path / "none.csv", pressure=4e5)
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(InputError, match="not a text file in UTF-8"):
        read_characteristic(tmp_path / "binary.csv", pressure=4e5)
