"""The recorder as a process of its own, beside a loop in another: killed, interrupted, without room."""

import os
import resource
import signal
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from random import Random

import numpy as np
import pytest

from layflat.errors import OutputError
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.recorder import file as growing
from layflat.rig.recorder import process
from layflat.rig.recorder.process import LogExistsError, LogRecorder, check_log_path, part_path, start_recorder
from layflat.rig.recorder.repair import repair
from layflat.rig.recorder.ring import Event, EventLevel, RecorderState, Ring
from layflat.rig.recorder.run import read_recording
from tests.rig.recorder.rigrows import BEGIN, CYCLE, HEADING, LAYOUT, column, rows, running_loop, wait_for


@pytest.fixture
def ring() -> Iterator[Ring]:
    made = Ring.create(LAYOUT.width)
    yield made
    made.remove()
    made.close()


def numbers(path: Path) -> list[int]:
    """Numbers of the rows that a log of `running_loop` holds."""
    return [round(k) for k in read_recording(path).columns["supply"]]


def has_grown(part: Path) -> bool:
    """Whether some rows are in a log."""
    return part.exists() and part.stat().st_size > 20_000


def test_a_killed_recorder_has_written_all_but_the_last_instants(ring: Ring, tmp_path: Path) -> None:
    """What is missing came after its last sign of life, which comes every 10 ms where the machine lets it."""
    random, silent = Random(4), []
    with running_loop(ring):
        for k in range(5):
            place = tmp_path / f"{k}.mcap"
            part = part_path(place)
            recorder = start_recorder(ring, place, HEADING)
            wait_for(partial(has_grown, part))
            time.sleep(random.uniform(0.0, 0.3))
            recorder.kill()
            recorder.join()
            silent.append((time.monotonic_ns() - ring.head.recorder_beat) / NS_PER_SECOND)
            written = ring.head.rows.written
            assert repair(part) is not None
            there = numbers(place)
            assert there == list(range(there[0], there[-1] + 1))
            assert (written - 1 - there[-1]) * CYCLE <= silent[-1] + 0.03
    assert sorted(silent)[2] <= 0.05, silent
    assert ring.head.rows.dropped == 0


def test_a_killed_loop_loses_nothing_and_its_log_is_finished(ring: Ring, tmp_path: Path) -> None:
    place = tmp_path / "run.mcap"
    recorder = start_recorder(ring, place, HEADING)
    with running_loop(ring):
        wait_for(lambda: ring.head.rows.written > 60)
    recorder.join(20.0)
    assert recorder.exitcode == 0
    assert ring.recorder is RecorderState.DONE
    assert numbers(place) == list(range(ring.head.rows.written))
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap"]
    assert not ring.path.exists()


def test_a_recorder_outlives_ctrl_c_and_a_disk_that_is_full_for_a_while(ring: Ring, tmp_path: Path) -> None:
    def some_more() -> None:
        since = ring.head.rows.written
        wait_for(lambda: ring.head.rows.written > since + 20)

    place = tmp_path / "run.mcap"
    recorder = start_recorder(ring, place, HEADING)
    assert recorder.pid is not None
    with running_loop(ring):
        wait_for(partial(has_grown, part_path(place)))
        _, most = resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (part_path(place).stat().st_size + 100, most))
        wait_for(lambda: ring.recorder is RecorderState.STUCK)
        assert ring.is_recorder_alive()
        some_more()
        resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (most, most))
        wait_for(lambda: ring.recorder is RecorderState.RECORDING)
        os.kill(recorder.pid, signal.SIGINT)
        some_more()
        assert recorder.is_alive()
    ring.end()
    recorder.join(20.0)
    assert recorder.exitcode == 0
    assert numbers(place) == list(range(ring.head.rows.written))
    told = [(event.level, event.text) for event in read_recording(place).events]
    assert told == [(40, "the log can't be written: File too large"), (30, "the log can be written again")]


@pytest.fixture
def recorder(ring: Ring, tmp_path: Path) -> LogRecorder:
    """One without a process."""
    return LogRecorder(ring, tmp_path / "run.mcap", HEADING)


def test_a_disk_that_stays_full_leaves_what_is_there_for_repair(
    ring: Ring, recorder: LogRecorder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    made = rows(30)
    for row in made[:20]:
        ring.push(row)
    recorder.drain()
    with monkeypatch.context() as patch:
        patch.setattr(growing.os, "write", full)  # type: ignore[attr-defined]
        patch.setattr(process, "FULL_DISK_TIMEOUT", 0.05)
        for row in made[20:]:
            ring.push(row)
        ring.end()
        recorder.run()
    assert ring.recorder is RecorderState.UNFINISHED
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap.part"]
    repair(tmp_path / "run.mcap.part")
    assert np.array_equal(read_recording(tmp_path / "run.mcap").columns["demand"], column(made[:20], "demand"))


def test_when_memory_runs_out_on_a_full_disk_cycles_are_left_out_and_counted(
    ring: Ring, recorder: LogRecorder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    made = rows(40)
    with monkeypatch.context() as patch:
        patch.setattr(growing.os, "write", full)  # type: ignore[attr-defined]
        patch.setattr(growing, "MAX_PENDING_BYTES", 10_000)
        for row in made[:30]:
            ring.push(row)
            recorder.drain()
    for row in made[30:]:
        ring.push(row)
    ring.end()
    recorder.run()
    log = read_recording(tmp_path / "run.mcap")
    kept = np.rint(log.columns["time"] / CYCLE).astype(int)
    assert kept[0] == 0
    assert kept[-10:].tolist() == list(range(30, 40))
    (told,) = [event for event in log.events if "missing" in event.text]
    assert told.text == f"{40 - len(kept)} cycles are missing: the disk was full"
    assert 0 < 40 - len(kept) < 30


def test_events_come_with_the_rows_and_what_did_not_fit_is_told(
    recorder: LogRecorder, ring: Ring, tmp_path: Path
) -> None:
    for row in np.repeat(rows(1), 5000, axis=0):
        ring.push(row)
    ring.put_event(Event(0.0, EventLevel.ERROR, "over-pressure"))
    ring.end()
    recorder.run()
    log = read_recording(tmp_path / "run.mcap")
    assert abs(log.begin - BEGIN) < 1000
    assert [event.text for event in log.events] == [
        "over-pressure",
        "904 cycles or events are missing: the recorder did not keep up",
    ]


def test_a_loop_that_never_began_leaves_no_log(recorder: LogRecorder, ring: Ring, tmp_path: Path) -> None:
    ring.end()
    recorder.run()
    assert ring.recorder is RecorderState.DONE
    assert list(tmp_path.iterdir()) == []


def test_a_log_takes_the_place_of_no_other(tmp_path: Path) -> None:
    check_log_path(tmp_path / "new" / "run.mcap")
    (tmp_path / "run.mcap.part").touch()
    with pytest.raises(OutputError, match=r"run\.mcap\.part: is there already; `layflat log repair"):
        check_log_path(tmp_path / "run.mcap")
    (tmp_path / "run.mcap").touch()
    with pytest.raises(OutputError, match=r"run\.mcap: is there already; give another name"):
        check_log_path(tmp_path / "run.mcap")
    with pytest.raises(OutputError, match="can't write here"):
        check_log_path(tmp_path / "run.mcap" / "run.mcap")


def test_of_two_that_begin_at_once_one_has_the_log(ring: Ring, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "check_log_path", lambda _: None)  # both have looked before either began
    monkeypatch.setattr(process, "start_process", lambda *_: None)
    start_recorder(ring, tmp_path / "run.mcap", HEADING)
    with pytest.raises(LogExistsError, match="is recorded by another run"):
        start_recorder(ring, tmp_path / "run.mcap", HEADING)


def test_recording_takes_little_of_a_core(recorder: LogRecorder, ring: Ring) -> None:
    """At 200 Hz and 100 looks a second, two rows a look."""
    made = rows(2000)
    since = time.process_time()
    for k in range(0, 2000, 2):
        ring.push(made[k])
        ring.push(made[k + 1])
        recorder.drain()
    share = (time.process_time() - since) / (2000 * CYCLE)
    ring.end()
    recorder.run()
    assert share < 0.2, share
