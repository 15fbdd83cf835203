"""What is kept around a fault."""

from pathlib import Path

import numpy as np
import pytest

from layflat.rig.recorder import process
from layflat.rig.recorder.process import TIME_AFTER_FAULT, TIME_BEFORE_FAULT, BlackBox
from layflat.rig.recorder.ring import Event, EventLevel
from layflat.rig.recorder.run import read_recording
from tests.rig.recorder.rigrows import BEGIN, CYCLE, HEADING, LAYOUT, rows

FAULT = LAYOUT.shared["fault"]


def fed(box: BlackBox, faults: dict[int, tuple[int, float]], count: int) -> list[str]:
    """What a box tells when it is fed rows, four at a time, with faults between rows and their number."""
    made, told = rows(count), []
    for first, (last, number) in faults.items():
        made[first:last, FAULT] = number
    for k in range(0, count, 4):
        box.append(made[k : k + 4], [Event(made[k, 0], EventLevel.WARN, "x")] if k in faults else [])
        event = box.work(BEGIN, wait=True)  # rows come at once here
        told += [event.text] if event else []
    return told


def test_a_fault_leaves_its_last_seconds_at_full_rate(tmp_path: Path) -> None:
    told = fed(BlackBox(tmp_path / "run.mcap", HEADING), {4000: (4400, 13.0)}, 5000)
    assert told == ["black box written: run-fault-001.mcap"]
    log = read_recording(tmp_path / "run-fault-001.mcap")
    time = log.columns["time"]
    at = 4000 * CYCLE
    assert np.allclose(np.diff(time), CYCLE)
    assert time[0] <= at - TIME_BEFORE_FAULT + 4 * CYCLE
    assert at + TIME_AFTER_FAULT <= time[-1] <= at + TIME_AFTER_FAULT + 8 * CYCLE
    made = rows(5000)[round(time[0] / CYCLE) :][: len(time)]
    assert np.array_equal(log.columns["supply"], made[:, LAYOUT.shared["supply"]])
    assert log.begin == BEGIN
    assert [(event.level, event.text) for event in log.events] == [(30, "x")]
    assert [path.name for path in tmp_path.iterdir()] == ["run-fault-001.mcap"]


def test_a_fault_that_stays_is_one_and_one_that_gets_worse_later_another(tmp_path: Path) -> None:
    faults = {100: (200, 11.0), 200: (1500, 15.0), 1500: (2600, 17.0)}
    told = fed(BlackBox(tmp_path / "run.mcap", HEADING), faults, 2600)
    assert [text[-16:-5] for text in told] == ["n-fault-001", "n-fault-002"]
    assert read_recording(tmp_path / "run-fault-001.mcap").columns["time"][0] == 0.0


def test_at_the_end_what_is_due_is_written_though_its_time_is_not_over(tmp_path: Path) -> None:
    box = BlackBox(tmp_path / "run.mcap", HEADING)
    assert fed(box, {380: (400, 12.0)}, 400) == []
    assert [event.text for event in box.end(BEGIN)] == ["black box written: run-fault-001.mcap"]
    assert len(read_recording(tmp_path / "run-fault-001.mcap").columns["time"]) == 400
    assert box.end(BEGIN) == []


def test_one_that_can_t_be_written_is_told_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: Path) -> None:
        raise OSError(28, "No space left on device")

    box = BlackBox(tmp_path / "run.mcap", HEADING)
    monkeypatch.setattr(process, "sync_path", full)
    fed(box, {10: (20, 12.0)}, 40)
    (event,) = box.end(BEGIN)
    assert event.level == EventLevel.WARN
    assert "run-fault-001.mcap can't be written" in event.text
    assert list(tmp_path.iterdir()) == []


def test_a_fault_that_is_only_told_leaves_nothing(tmp_path: Path) -> None:
    assert fed(BlackBox(tmp_path / "run.mcap", HEADING), {100: (200, 5.0)}, 2600) == []
    assert list(tmp_path.iterdir()) == []
