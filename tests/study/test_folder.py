import errno
import fcntl
import json
import os
import shutil
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import pytest

from layflat.errors import InputError, OutputError
from layflat.study import Study, read_study, run_study
from layflat.study.folder import ChangedError
from tests.study.studies import SMALL, written

KILLED_AFTER = """
import os, pathlib, signal, sys
from layflat.study import read_study, run_study

after = int(sys.argv[3])

def progress(done, total):
    if after and done >= after:
        os.kill(os.getpid(), signal.SIGKILL)

def replace(self, target, move=pathlib.Path.replace):
    if not after and target.name == "00002.parquet":
        os.kill(os.getpid(), signal.SIGKILL)
    return move(self, target)

pathlib.Path.replace = replace
run_study(read_study(sys.argv[1]), sys.argv[2], chunk=4, threads=1, progress=progress)
"""
"""Runs a study and dies when so many runs are done, or (0) when the third chunk is written but not in its place."""


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return read_study(written(tmp_path))


@pytest.mark.parametrize("after", [0, 10])
def test_a_killed_study_goes_on_where_it_was(tmp_path: Path, study: Study, after: int) -> None:
    undisturbed = run_study(study, tmp_path / "undisturbed", chunk=4)
    out = tmp_path / "killed"
    words = [sys.executable, "-c", KILLED_AFTER, str(tmp_path / "study.toml"), str(out), str(after)]
    assert subprocess.run(words, check=False, timeout=300).returncode == -9
    before = {path.name: path.stat().st_mtime_ns for path in (out / "chunks").glob("[0-9]*")}
    assert sorted(before) == ["00000.parquet", "00001.parquet"]
    assert not (out / "table.parquet").exists()
    assert len(list((out / "chunks").glob(".*"))) == (0 if after else 1)

    told: list[int] = []
    run_study(study, out, chunk=4, progress=lambda done, _: told.append(done))
    assert told[0] == 8
    assert (out / "table.parquet").read_bytes() == undisturbed.read_bytes()
    assert before == {name: (out / "chunks" / name).stat().st_mtime_ns for name in before}
    assert sorted(path.name for path in out.iterdir()) == ["chunks", "study.json", "table.csv", "table.parquet"]
    assert [path.name for path in sorted((out / "chunks").iterdir())] == [f"0000{i}.parquet" for i in range(6)]


def test_a_broken_or_lost_chunk_is_done_again(tmp_path: Path, study: Study) -> None:
    whole = run_study(study, tmp_path / "out", chunk=4)
    before = whole.read_bytes()
    whole.unlink()
    (tmp_path / "out" / "chunks" / "00001.parquet").write_bytes(b"PAR1")
    (tmp_path / "out" / "chunks" / "00004.parquet").unlink()
    told: list[int] = []
    run_study(study, tmp_path / "out", chunk=4, progress=lambda done, _: told.append(done))
    assert told[0] == 16
    assert whole.read_bytes() == before


def test_a_changed_study_is_refused_with_the_difference(tmp_path: Path, study: Study) -> None:
    run_study(study, tmp_path / "out")
    before = (tmp_path / "out" / "study.json").read_bytes()
    text = SMALL.replace('"4 N m"', '"5 N m"').replace('"grid"', '"grid"\nseed = 7').replace(', "3 kg"', "")
    with pytest.raises(ChangedError, match="holds a study that differs from this one") as caught:
        run_study(read_study(written(tmp_path, text)), tmp_path / "out")
    assert caught.value.differences == [
        "study.seed: 0 -> 7",
        "study.vary.joint.small.brake.torque.high: 4.0 N*m -> 5.0 N*m",
        "study.vary.scenario.payload.values.3: 3.0 kg -> (none)",
    ]
    assert (tmp_path / "out" / "study.json").read_bytes() == before


def test_a_changed_machine_is_refused_with_the_difference(tmp_path: Path) -> None:
    machine = 'extends = "paper-small-joint"\n[arm]\npayload = "{} kg"\n'
    text = SMALL.replace("paper-small-joint", "mine.toml")
    (tmp_path / "mine.toml").write_text(machine.format(1), encoding="utf-8")
    run_study(read_study(written(tmp_path, text)), tmp_path / "out")
    (tmp_path / "mine.toml").write_text(machine.format(2), encoding="utf-8")
    with pytest.raises(ChangedError) as caught:
        run_study(read_study(written(tmp_path, text)), tmp_path / "out")
    assert caught.value.differences == ["machine.arm.payload: 1.0 kg -> 2.0 kg"]


def test_other_laws_or_chunks_are_refused(tmp_path: Path, study: Study) -> None:
    run_study(study, tmp_path / "out")
    with pytest.raises(ChangedError) as caught:
        run_study(study, tmp_path / "out", chunk=8)
    assert caught.value.differences == ["chunk: 4096 -> 8"]
    path = tmp_path / "out" / "study.json"
    held = json.loads(path.read_text(encoding="utf-8"))
    assert held["machine"]["joint"]["small"]["brake"]["torque"] == "2.2 N*m"
    now, held["made_with"]["layflat"] = held["made_with"]["layflat"], "0.0.1"
    path.write_text(json.dumps(held), encoding="utf-8")
    with pytest.raises(ChangedError) as caught:
        run_study(study, tmp_path / "out")
    assert caught.value.differences == [f"made_with.layflat: 0.0.1 -> {now}"]


@pytest.mark.parametrize("name", ["notes.txt", "study.json", "chunks/notes.txt", "table.parquet"])
def test_a_folder_with_foreign_files_is_refused(tmp_path: Path, study: Study, name: str) -> None:
    foreign = tmp_path / "out" / name
    if "/" in name:
        run_study(study, tmp_path / "out")
    foreign.parent.mkdir(parents=True, exist_ok=True)
    foreign.write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match=r"is not a study's|which is none of a study's files"):
        run_study(study, tmp_path / "out")
    assert foreign.read_text(encoding="utf-8") == "mine"


def test_a_place_that_can_not_be_written(tmp_path: Path, study: Study) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    for out in (tmp_path / "file", tmp_path / "file" / "out"):
        with pytest.raises(OutputError, match="can't write here"):
            run_study(study, out)


def test_a_disk_without_room_is_refused_before_any_work(
    tmp_path: Path, study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = namedtuple("usage", "free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(free=1000))
    with pytest.raises(OutputError, match=r"needs 0\.0 MB, and 0\.0 MB are free; make room"):
        run_study(study, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_study_too_large_for_disk_or_memory_is_refused_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    huge = read_study(written(tmp_path, SMALL.replace("points = 6", "points = 2000000000")))
    usage = namedtuple("usage", "free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(free=1e12))
    with pytest.raises(OutputError, match=r"needs [\d,]{7,}\.\d MB, and 1,000,000\.0 MB are free"):
        run_study(huge, tmp_path / "out")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(free=1e18))
    with pytest.raises(InputError, match="8,000,000,000 samples are more than can be held in memory"):
        run_study(huge, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_study_takes_no_more_room_than_it_asks_for(
    tmp_path: Path, study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = namedtuple("usage", "free")
    taken = {}
    for chunk in (1, 24):
        out = tmp_path / f"{chunk}"
        run_study(study, out, chunk=chunk)
        taken[chunk] = sum(path.stat().st_size for path in out.rglob("*.parquet"))
        monkeypatch.setattr(shutil, "disk_usage", lambda _, free=taken[chunk]: usage(free=free))
        with pytest.raises(OutputError, match="are free"):
            run_study(study, tmp_path / "other", chunk=chunk)
        monkeypatch.undo()


def test_a_disk_that_gets_full_gives_one_line(tmp_path: Path, study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    import pyarrow.parquet

    def full(*words: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(pyarrow.parquet, "write_table", full)
    with pytest.raises(OutputError, match=r"can't write here \(No space left on device\)"):
        run_study(study, tmp_path / "out")
    monkeypatch.undo()
    assert run_study(study, tmp_path / "out").exists()


def test_two_do_not_write_in_one_folder(tmp_path: Path, study: Study) -> None:
    (tmp_path / "out").mkdir()
    handle = os.open(tmp_path / "out", os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    try:
        with pytest.raises(OutputError, match="is in use by another run"):
            run_study(study, tmp_path / "out")
    finally:
        os.close(handle)
    assert run_study(study, tmp_path / "out").exists()


def test_without_pyarrow_it_says_how_to_get_it(tmp_path: Path, study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(InputError, match=r"needs pyarrow, can't be imported.*pip install 'layflat\[study\]'"):
        run_study(study, tmp_path / "out")
