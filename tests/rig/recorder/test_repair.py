"""Files cut short at any byte: every whole message is kept, and the result is whole."""

import fcntl
from functools import cache
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import CompressionType, Writer

from layflat.errors import InputError, OutputError
from layflat.rig.recorder.bag import BagWriter
from layflat.rig.recorder.repair import RepairSummary, repair
from layflat.rig.recorder.ring import Event, EventLevel
from tests.rig.recorder.rigrows import BEGIN, HEADING, log_of, rows

Messages = list[tuple[str, int, bytes]]


def grown() -> bytes:
    """A log that is being recorded, record by record."""
    stream = BytesIO()
    bag = BagWriter(stream, HEADING, BEGIN, chunked=False)
    bag.add(rows(8))
    bag.write_event(Event(0.02, EventLevel.WARN, "supply lost"))
    return stream.getvalue()


def packed(compression: CompressionType) -> bytes:
    """A finished log of somebody else's, in small chunks."""
    stream = BytesIO()
    writer = Writer(stream, chunk_size=300, compression=compression)
    writer.start("ros2", "other")
    schema = writer.register_schema("a/msg/B", "ros2msg", b"uint8 x")
    channels = [writer.register_channel(topic, "cdr", schema) for topic in ("/a", "/b")]
    for k in range(40):
        writer.add_message(channels[k % 2], 1000 + k, bytes([k]) * 40, 1000 + k, k)
    writer.finish()
    return stream.getvalue()


FILES = {"grown": grown(), **{kind.name: packed(kind) for kind in CompressionType}}


def ends(data: bytes) -> list[tuple[int, int]]:
    """Where the file's records end, by the official reader, and how many messages there are up to there."""
    stream, count = BytesIO(data), 0
    found: list[tuple[int, int]] = []
    source = StreamReader(stream, emit_chunks=True).records
    while True:
        try:
            record = next(source)
        except Exception:  # the end of a file that is being recorded
            return found
        inside = breakup_chunk(record) if isinstance(record, Chunk) else [record]
        count += sum(isinstance(one, Message) for one in inside)
        found.append((stream.tell(), count))
        if stream.tell() == len(data):
            return found


def messages(path: Path) -> Messages:
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        read = [(c.topic, m.log_time, m.data) for _, c, m in reader.iter_messages(log_time_order=False)]
        assert summary.statistics.message_count == len(read)
        assert not read or len(summary.chunk_indexes) > 0
        return read


@cache
def known(name: str) -> tuple[Messages, list[tuple[int, int]]]:
    """All messages of a file, and where its records end."""
    everything, places = repaired(FILES[name])[0], ends(FILES[name])
    assert len(everything) == places[-1][1]
    return everything, places


def repaired(data: bytes) -> tuple[Messages, RepairSummary]:
    with TemporaryDirectory() as name:
        folder = Path(name)
        cut = folder / "a.mcap.part"
        cut.write_bytes(data)
        done = repair(cut)
        assert done is not None
        assert done[0] == folder / "a.mcap"
        assert (folder / "a.mcap.broken").read_bytes() == data
        assert sorted(path.name for path in folder.glob("*")) == ["a.mcap", "a.mcap.broken"]
        return messages(done[0]), done[1]


TAILS = [b"", bytes(3), bytes(500)]
"""A machine without power leaves zeros behind what was written."""


@settings(max_examples=150)
@given(name=st.sampled_from(sorted(FILES)), share=st.floats(0.0, 1.0), tail=st.sampled_from(TAILS))
def test_every_whole_message_is_kept(name: str, share: float, tail: bytes) -> None:
    data = FILES[name]
    cut = 8 + round(share * (len(data) - 8))
    kept, told = repaired(data[:cut] + tail)
    everything, places = known(name)
    solid = len(data[:cut].rstrip(b"\0")) if tail else cut
    last, least = max((place for place in places if place[0] <= solid), default=(8, 0))
    assert kept == everything[: len(kept)]
    assert told.messages == len(kept) >= least
    if name == "grown":
        assert len(kept) == least
        assert told.lost == cut + len(tail) - last


@given(name=st.sampled_from(sorted(FILES)), share=st.floats(0.0, 1.0, exclude_max=True), byte=st.integers(1, 255))
def test_a_byte_that_is_wrong_never_crashes_nor_changes_what_a_checksum_guards(
    name: str, share: float, byte: int
) -> None:
    data = bytearray(FILES[name])
    data[8 + int(share * (len(data) - 8))] ^= byte
    kept, _ = repaired(bytes(data))
    if name != "grown":
        assert set(kept) <= set(known(name)[0])


def test_a_chunk_that_is_damaged_is_left_out_and_the_others_kept() -> None:
    data = bytearray(FILES["NONE"])
    at = data.index(bytes([20]) * 40)
    data[at] ^= 1
    kept, told = repaired(bytes(data))
    numbers = [time - 1000 for _, time, _ in kept]
    assert 20 not in numbers
    assert {0, 39} < set(numbers)
    assert told.lost > 40


def test_a_whole_file_is_left_alone(tmp_path: Path) -> None:
    path = log_of(tmp_path / "a.mcap", rows(5))
    before = path.read_bytes()
    assert repair(path) is None
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_with_a_hole_inside_is_repaired_under_its_own_name_and_originals_pile_up(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    data = FILES["ZSTD"]
    for broken in ("a.mcap.broken", "a.mcap.broken1"):
        path.write_bytes(data[:200])
        done = repair(path)
        assert done is not None
        assert done[0] == path
        assert (tmp_path / broken).read_bytes() == data[:200]
        assert repair(path) is None


def test_what_can_t_be_repaired_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with pytest.raises(InputError, match="No such file"):
        repair(path)
    path.write_bytes(b"")
    with pytest.raises(InputError, match="is empty"):
        repair(path)
    path.write_bytes(b"time,angle\n0,1\n")
    with pytest.raises(InputError, match="is not an MCAP file"):
        repair(path)
    part = tmp_path / "a.mcap.part"
    part.write_bytes(FILES["grown"])
    with pytest.raises(OutputError, match="is there already"):
        repair(part)
    path.unlink()
    with part.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(InputError, match="is being recorded"):
            repair(part)


def test_progress_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap.part"
    path.write_bytes(FILES["grown"])
    told: list[tuple[int, int]] = []
    repair(path, lambda done, size: told.append((done, size)))
    assert told
    assert all(0 <= done <= size == len(FILES["grown"]) for done, size in told)
