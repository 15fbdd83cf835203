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


def test_margins_are_printed_where_the_plant_is_too_fast_to_be_measured(tmp_path: Path) -> None:
    done = layflat("bode", "paper-small-joint", "--speed", "5 deg/s", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert "the plant is not measured" in done.stdout
    assert "phase margin" in done.stdout


def test_wrong_options_are_named(tmp_path: Path) -> None:
    assert "--joints: 'slidng' is no state of a joint" in refused(
        "bode", "paper-arm", "--joints", "slidng", cwd=tmp_path
    )
    assert "--speed: '0 deg/s' is no speed" in refused("bode", "paper-arm", "--speed", "0 deg/s", cwd=tmp_path)
    assert "paper-arm" in refused("bode", "paper-amr", cwd=tmp_path)
