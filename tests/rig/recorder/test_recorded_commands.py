"""`layflat log info|repair|plot|export` as a person uses them."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from layflat.cli import app
from layflat.errors import InputError
from layflat.rig.recorder.ring import Event, EventLevel
from tests.rig.recorder.rigrows import LAYOUT, log_of, rows


def layflat(*words: str | Path) -> str:
    done = CliRunner().invoke(app, ["log", *map(str, words)])
    if isinstance(done.exception, InputError):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.fixture
def log(tmp_path: Path) -> Path:
    made = abs(rows(400)) * 1e-4
    made[:, :2] = rows(400)[:, :2]
    made = made[[k for k in range(400) if k not in {100, 101}]]
    events = [Event(0.0, EventLevel.INFO, "ready"), Event(1.0, EventLevel.ERROR, "over-pressure")]
    log_of(tmp_path / "run-fault-001.mcap", made[:5])
    return log_of(tmp_path / "run.mcap", made, events)


def test_info_tells_when_how_long_how_even_and_what_went_wrong(log: Path) -> None:
    told = layflat("info", log)
    assert "2023-11-14T22:13:20+00:00" in told
    assert "398 over 1.995 s, one every 5 ms, 2 missing" in told
    assert "arm: large, small" in told
    assert "run-fault-001.mcap" in told
    assert "over-pressure" in told
    assert max(map(len, told.splitlines())) <= 100


def test_a_log_is_drawn_and_exported(log: Path) -> None:
    assert layflat("plot", log) == f"wrote {log.with_suffix('.png')}\n"
    assert log.with_suffix(".png").read_bytes()[:4] == b"\x89PNG"
    for name in ("run.nc", "run.parquet"):
        assert layflat("export", log, log.with_name(name)) == f"wrote {log.with_name(name)}\n"
        assert log.with_name(name).stat().st_size > 1000


def test_a_log_that_was_cut_is_told_repaired_and_read(log: Path) -> None:
    part = log.with_name("cut.mcap.part")
    log_of(part, rows(100), chunked=False)
    part.write_bytes(part.read_bytes()[:-5])
    for command in (("info", part), ("plot", part), ("export", part, log.with_name("cut.nc"))):
        with pytest.raises(InputError, match=r"was not finished; `layflat log repair .*cut.mcap.part`"):
            layflat(*command)
    told = layflat("repair", part)
    whole = log.with_name("cut.mcap")
    assert told.startswith(f"wrote {whole}: kept 199 messages over 0.495 s, lost ")
    assert log.with_name("cut.mcap.broken").exists()
    assert "100 over 0.495 s" in layflat("info", whole)
    assert layflat("repair", whole) == f"{whole}: is complete, nothing to repair\n"


def test_files_that_are_none_and_formats_that_are_none_are_refused(log: Path, tmp_path: Path) -> None:
    (tmp_path / "text.mcap").write_text("time,angle\n")
    for command in ("info", "repair", "plot"):
        with pytest.raises(InputError, match="is not an MCAP file; give an MCAP file"):
            layflat(command, tmp_path / "text.mcap")
        with pytest.raises(InputError, match="No such file"):
            layflat(command, tmp_path / "none.mcap")
    with pytest.raises(InputError, match=r"'\.csv' is not a format; use \.nc or \.parquet"):
        layflat("export", tmp_path / "text.mcap", tmp_path / "run.csv")
    with pytest.raises(InputError, match="can't write here"):
        layflat("plot", log, "--out", log / "run.png")


def test_a_late_cycle_is_none_that_is_missing(tmp_path: Path) -> None:
    made = rows(100)
    made[:, LAYOUT.shared["lateness"]] = 0.0
    made[40, LAYOUT.shared["lateness"]] = 0.004
    made[40, 0] += 0.004
    assert "0 missing" in layflat("info", log_of(tmp_path / "late.mcap", made))
    gap = np.delete(made, [60, 61, 62], axis=0)
    assert "3 missing" in layflat("info", log_of(tmp_path / "gap.mcap", gap))


def test_a_log_that_was_exported_is_told_of_too(tmp_path: Path) -> None:
    log = log_of(tmp_path / "run.mcap", rows(100), [Event(0.1, EventLevel.ERROR, "following error")])
    layflat("export", log, tmp_path / "run.nc")
    assert "following error" in layflat("info", tmp_path / "run.nc")
    with pytest.raises(InputError, match="can't be read as a run"):
        layflat("info", tmp_path / "none.nc")
