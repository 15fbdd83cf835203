"""Logs, read back by the official reader."""

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import layflat
from layflat.machine import load
from layflat.rig.recorder import file as growing
from layflat.rig.recorder.bag import BagWriter, LogHeading
from layflat.rig.recorder.file import GrowingFile
from layflat.rig.recorder.repair import RepairSummary, read_records
from layflat.rig.recorder.ring import Event, EventLevel
from tests.rig.recorder.rigrows import BEGIN, CYCLE, HEADING, column, log_of, rows


def test_the_official_reader_finds_topics_times_and_what_the_log_says_of_itself(tmp_path: Path) -> None:
    made = rows(300)
    path = log_of(tmp_path / "a.mcap", made, [Event(0.7, EventLevel.ERROR, "over-pressure")])
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert len(summary.chunk_indexes) == summary.statistics.chunk_count > 0
        topics = {summary.channels[k].topic: n for k, n in summary.statistics.channel_message_counts.items()}
        assert topics == {"/cycle": 300, "/joint_states": 300, "/events": 1}
        assert reader.get_header().profile == "ros2"
        (metadata,) = reader.iter_metadata()
        assert metadata.metadata["layflat_version"] == layflat.__version__
        assert metadata.metadata["start"] == "2023-11-14T22:13:20+00:00"
        assert json.loads(metadata.metadata["notes"]) == {"driver": "simulated"}
        (attachment,) = reader.iter_attachments()
        assert (attachment.name, attachment.data) == ("machine.json", HEADING.machine.encode())
    with path.open("rb") as file:
        states = list(make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages("/joint_states"))
        assert [state.message.log_time for state in states] == [BEGIN + round(k * CYCLE * 1e9) for k in range(300)]
        assert np.array_equal([state.decoded_message.position for state in states], column(made, "measured_angle"))
        file.seek(0)
        (event,) = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages("/events")
    assert (event.decoded_message.msg, event.decoded_message.level) == ("over-pressure", 40)
    assert event.message.log_time == BEGIN + 700_000_000


def test_the_loop_began_at_the_time_of_day_of_its_time_zero() -> None:
    assert abs(HEADING.layout.began(rows(5)[4]) - BEGIN) < 1000


def test_a_machine_heads_its_log() -> None:
    machine = load("paper-arm")
    heading = LogHeading.for_machine(machine, driver="modbus://here")
    assert heading.layout.joints == tuple(machine.joints)
    assert type(machine).model_validate_json(heading.machine) == machine
    assert heading.notes == {"driver": "modbus://here"}


def test_what_was_flushed_is_in_the_file_though_it_was_never_closed(tmp_path: Path) -> None:
    file = GrowingFile(tmp_path / "a.mcap.part")
    bag, made = BagWriter(file, HEADING, BEGIN, chunked=False), rows(12)
    for k in range(0, 12, 4):
        bag.add(made[k : k + 4])
        file.flush()
        found = [kind for kind, _ in read_records(file.path, RepairSummary())]
        assert found.count(5) == 2 * (k + 4)
        assert file.tell() == file.path.stat().st_size
    file.close()


def test_a_disk_that_is_full_for_a_while_costs_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = GrowingFile(tmp_path / "a")
    room = 10

    def write(handle: int, data: bytearray, write=growing.os.write) -> int:  # type: ignore[no-untyped-def, attr-defined]
        nonlocal room
        if not room:
            raise OSError(28, "No space left on device")
        done = write(handle, data[:room])
        room -= done
        return int(done)

    monkeypatch.setattr(growing.os, "write", write)  # type: ignore[attr-defined]
    file.write(b"0123456")
    file.flush()
    assert (file.trouble, file.has_room) == ("", True)
    file.write(b"789abc")
    file.flush()
    assert file.trouble == "No space left on device"
    assert file.path.read_bytes() == b"0123456789"
    monkeypatch.setattr(growing, "MAX_PENDING_BYTES", 3)
    assert not file.has_room
    room = 100
    file.flush()
    assert (file.trouble, file.has_room) == ("", True)
    assert file.path.read_bytes() == b"0123456789abc"
    file.close()


def test_a_file_that_is_there_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("mine")
    with pytest.raises(FileExistsError):
        GrowingFile(tmp_path / "a")
    assert (tmp_path / "a").read_text() == "mine"
    with pytest.raises(OSError, match="exists"):
        GrowingFile(tmp_path / "a" / "b")
