"""`layflat bode` as a person uses it."""

from pathlib import Path

import pytest

from tests.cli.commands import layflat, refused

pytest.importorskip("control")


def test_responses_and_margins_are_drawn_and_printed(tmp_path: Path) -> None:
    done = layflat("bode", "paper-small-joint", "--joints", "held", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert "gain error (%)" in done.stdout
    rows = (tmp_path / "paper-small-joint-bode.csv").read_text().splitlines()
    assert rows[0].startswith("frequency (Hz),joint,output,unit,model gain")
    assert rows[1].startswith("0.5,small,small_differential_pressure,Pa per V,")
    assert (tmp_path / "paper-small-joint-bode.png").stat().st_size > 10_000


def test_a_joint_that_sticks_and_slips_is_drawn_without_the_plant(tmp_path: Path) -> None:
    falling = (
        '[joint.small.friction]\nkind = "stribeck"\nstatic_ratio = 1.4\nvelocity = "0.1 rad/s"\ndrag = "0.5 N m"\n'
    )
    (tmp_path / "mine.toml").write_text(f'extends = "paper-small-joint"\nname = "mine"\n{falling}')
    done = layflat("bode", "mine.toml", "--out", str(tmp_path), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "the plant is not measured" in done.stdout
    assert "does not settle" in done.stdout


def test_joints_have_states_and_pressures_of_their_own(tmp_path: Path) -> None:
    options = ("--joints", "small=sliding", "--pressures", "large=4 bar:3.9 bar")
    done = layflat("bode", "paper-arm-tracking", *options, "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    rows = (tmp_path / "paper-arm-tracking-bode.csv").read_text().splitlines()
    assert rows[1].startswith("0.5,large,large_differential_pressure,")
    assert rows[-1].startswith("20,small,small_velocity,")


def test_a_law_that_leaves_a_joint_to_friction_closes_no_loop(tmp_path: Path) -> None:
    done = layflat("bode", "single-joint-lift", "--joints", "held", "--out", str(tmp_path))
    assert "no loop" in done.stdout


def test_wrong_options_are_named(tmp_path: Path) -> None:
    assert "--joints: 'slidng' is no state of a joint" in refused(
        "bode", "paper-arm", "--joints", "slidng", cwd=tmp_path
    )
    assert "--pressures: '3 bar' is no pair" in refused("bode", "paper-arm", "--pressures", "3 bar", cwd=tmp_path)
    assert "--speed: '0 deg/s' is no speed" in refused("bode", "paper-arm", "--speed", "0 deg/s", cwd=tmp_path)
    assert "paper-arm" in refused("bode", "paper-amr", cwd=tmp_path)
