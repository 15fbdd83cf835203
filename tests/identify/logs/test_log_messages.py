"""Messages of recorders: nothing vanishes without a word, and nothing is taken for something else."""

import json
import sqlite3
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from layflat.errors import InputError
from layflat.identify.logs import find_issues, guess_mapping, read_log, read_table
from layflat.identify.logs.mapping import parse_mapping
from layflat.rig.recorder.repair import repair
from tests.identify.logs.bags import Message, header, write_json, write_ros

CDR = b"\0\1\0\0"


def bag(path: Path, schema: str, messages: list[bytes], **options: Any) -> Path:
    """An MCAP file of one topic "/x", a message every 0.1 s, of a type that is defined by a text."""
    return bag_of(path, {"/x": ("cdr", "ros2msg", schema, messages)}, **options)


def bag_of(path: Path, topics: dict[str, tuple[str, str, str, list[bytes]]], **options: Any) -> Path:
    """An MCAP file: by topic the encodings of messages and of their schema, the schema, and the messages."""
    with path.open("wb") as file:
        writer = Writer(file, **options)
        writer.start("ros2")
        for topic, (encoding, kind, text, messages) in topics.items():
            schema = writer.register_schema(f"p/msg/{topic[1:].title()}", kind, text.encode()) if kind else 0
            channel = writer.register_channel(topic, encoding, schema)
            for i, data in enumerate(messages):
                writer.add_message(channel, i * 10**8, data, i * 10**8)
        writer.finish()
    return path


def values(path: Path) -> dict[str, list[float]]:
    return {name: column.values.tolist() for name, column in read_table(path).columns.items()}


@pytest.mark.parametrize(
    ("definition", "data", "expected"),
    [
        ("uint8[] v", b"\2\0\0\0\xc8\1", {"x.v.0": [200.0], "x.v.1": [1.0]}),
        ("uint8[2] v", b"\xc8\1", {"x.v.0": [200.0], "x.v.1": [1.0]}),
        ("byte[] v", b"\2\0\0\0\xc8\1", {"x.v.0": [200.0], "x.v.1": [1.0]}),
        ("byte[<=4] v", b"\2\0\0\0\xc8\1", {"x.v.0": [200.0], "x.v.1": [1.0]}),
        ("char[2] v", b"\xc8\1", {"x.v.0": [200.0], "x.v.1": [1.0]}),
        ("char[] v", b"\1\0\0\0\xc8", {"x.v.0": [200.0]}),
        ("int8[2] v", b"\xc8\1", {"x.v.0": [-56.0], "x.v.1": [1.0]}),
        ("char v", b"\xc8", {"x.v": [200.0]}),
        ("byte v", b"\xc8", {"x.v": [200.0]}),
        ("bool[2] v", b"\0\1", {"x.v.0": [0.0], "x.v.1": [1.0]}),
        ("uint8[] none", b"\0\0\0\0", {}),
        ("builtin_interfaces/Duration d", struct.pack("<iI", -2, 500_000_000), {"x.d": [-1.5]}),
        ("builtin_interfaces/Time d", struct.pack("<iI", -2, 500_000_000), {"x.d": [-1.5]}),
    ],
)
def test_every_array_of_numbers_has_its_columns(
    tmp_path: Path, definition: str, data: bytes, expected: dict[str, list[float]]
) -> None:
    """With a number behind it, so that none is there alone."""
    path = bag(tmp_path / "x.mcap", f"uint8 n\n{definition}\n", [CDR + b"\7" + aligned(data, definition)])
    assert values(path) == {"x.n": [7.0], **expected}


def aligned(data: bytes, definition: str) -> bytes:
    """A sequence's length and a time stand at a multiple of four."""
    return bytes(3) + data if "[]" in definition or "<=" in definition or "/" in definition else data


def test_bytes_alone_are_numbers(tmp_path: Path) -> None:
    path = bag(tmp_path / "x.mcap", "uint8[2] v\n", [CDR + bytes([i, 255 - i]) for i in range(4)])
    assert values(path) == {"x.v.0": [0.0, 1.0, 2.0, 3.0], "x.v.1": [255.0, 254.0, 253.0, 252.0]}


@pytest.mark.parametrize(
    ("content", "columns", "words"),
    [
        ({"p": [[1, 2], [3, 4]]}, {"a.p.0.0": 1.0, "a.p.0.1": 2.0, "a.p.1.0": 3.0, "a.p.1.1": 4.0}, {}),
        ([{"v": 1}, {"v": 2}], {"a.0.v": 1.0, "a.1.v": 2.0}, {}),
        ([1, [2]], {"a.0": 1.0, "a.1.0": 2.0}, {}),
        ({"v": "12.5", "w": 1, "s": "ok"}, {"a.w": 1.0}, {"a.v": "numbers written as text, such as '12.5'"}),
        ({"p": [0] * 65, "w": 1}, {"a.w": 1.0}, {"a.p": "65 items, and an array of more than 64 is no signal"}),
        ({"t": {"sec": 2, "nsec": 500_000_000}}, {"a.t": 2.5}, {}),
    ],
)
def test_json_of_any_shape(tmp_path: Path, content: Any, columns: dict[str, float], words: dict[str, str]) -> None:
    table = read_table(write_json(tmp_path / "x.mcap", [("/a", 0.1 * i, content) for i in range(2)]))
    assert {name: column.values[1] for name, column in table.columns.items()} == columns
    assert table.words == words


def test_another_kind_of_cdr_is_not_read_as_this_one(tmp_path: Path) -> None:
    """CDR of version 2 aligns numbers of eight bytes at multiples of four."""
    messages = [b"\0\7\0\0" + struct.pack("<IdI", 1, 2.0, 3) + bytes(8)]
    path = bag(tmp_path / "x.mcap", "uint32 a\nfloat64 v\nuint32 b\n", messages)
    with pytest.raises(InputError, match="its kind of CDR, 0007, is not read here"):
        read_table(path)


def test_log_times_of_any_size(tmp_path: Path) -> None:
    with (tmp_path / "x.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/x", "json", 0)
        for i in range(3):
            writer.add_message(channel, 2**63 + i * 10**8, b"1", 0)
        writer.finish()
    stamps = read_table(tmp_path / "x.mcap").columns["x"].stamps
    assert stamps is not None
    assert stamps.tolist() == [0.0, 0.1, 0.2]


def test_types_defined_as_idl(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    text = "module p { module msg { struct X { double v; octet b; int8 i; }; }; };\n"
    for head in ("", "=" * 80 + "\nIDL: p/msg/X\n"):
        path = bag_of(
            tmp_path / "x.mcap", {"/x": ("cdr", "ros2idl", head + text, [CDR + struct.pack("<dBb", 1.5, 200, -3)])}
        )
        assert values(path) == {"x.v": [1.5], "x.b": [200.0], "x.i": [-3.0]}


def test_names_that_stand_twice_are_no_names(tmp_path: Path) -> None:
    path = write_json(tmp_path / "x.mcap", [("/a", 0.1 * i, {"name": ["q", "q"], "p": [i, 10 * i]}) for i in range(3)])
    assert values(path) == {"a.p.0": [0.0, 1.0, 2.0], "a.p.1": [0.0, 10.0, 20.0]}


def test_topics_that_differ_by_their_slash_stay_apart(tmp_path: Path) -> None:
    path = write_json(tmp_path / "x.mcap", [("/a", 0.0, 1.0), ("a", 0.1, 2.0), ("/a", 0.2, 3.0)])
    assert sorted(values(path).values()) == [[1.0, 3.0], [2.0]]


def test_what_can_not_be_decoded_hides_nothing(tmp_path: Path) -> None:
    good = [struct.pack("<d", float(i)) for i in range(5)]
    path = bag_of(
        tmp_path / "x.mcap",
        {
            "/good": ("cdr", "ros2msg", "float64 v\n", [CDR + data for data in good]),
            "/bad": ("cdr", "ros2msg", "float64 v\n", [CDR + good[1], CDR + b"\0", CDR + good[2]]),
            "/words": ("cdr", "ros2msg", "wstring v\n", [CDR + b"\1\0\0\0a\0"]),
            "/proto": ("protobuf", "protobuf", "", [b"\0"]),
            "/nothing": ("cdr", "", "", [b"\0"]),
            "/odd": ("cdr", "ros2msg", "float65 v\n", [CDR]),
            "/text": ("json", "jsonschema", "{}", [b'"twelve"']),
            "/image": ("json", "jsonschema", "{}", [json.dumps({"data": [0] * 100, "width": 10}).encode()]),
        },
    )
    table = read_table(path)
    assert {name: column.values.tolist() for name, column in table.columns.items()} == {
        "good.v": [0.0, 1.0, 2.0, 3.0, 4.0], "bad.v": [1.0, 2.0], "image.width": [10.0],
    }  # fmt: skip
    assert set(table.words) == {"bad", "words", "proto", "nothing", "odd", "text", "image.data"}
    assert table.words["bad"].startswith("1 of 3 messages can't be decoded (")
    assert table.words["words"].startswith("1 of 1 messages can't be decoded (wstring")
    assert table.words["proto"] == "its messages are in protobuf with schemas in protobuf, which is not read here"
    assert table.words["text"] == "its messages hold no numbers"
    assert table.words["image.data"] == "100 items, and an array of more than 64 is no signal"
    good_alone = {"column": [{"from": "good.v", "signal": "force", "unit": "N"}]}
    notes = [
        issue for issue in find_issues(read_log(path, parse_mapping(good_alone))) if "make no column" in issue.text
    ]
    assert len(notes) == 1
    assert "1 of 3 messages can't be decoded" in notes[0].text


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_files_of_all_makes_are_read(tmp_path: Path, compression: CompressionType, chunked: bool) -> None:
    """With any compression, with chunks and an index, or with neither; empty topics are none."""
    messages = [CDR + struct.pack("<d", float(i)) for i in range(50)]
    topics = {"/x": ("cdr", "ros2msg", "float64 v\n", messages), "/empty": ("cdr", "ros2msg", "float64 w\n", [])}
    path = bag_of(tmp_path / "x.mcap", topics, compression=compression, use_chunking=chunked, chunk_size=300)
    assert values(path) == {"x.v": [float(i) for i in range(50)]}


def test_messages_compressed_one_by_one_are_unpacked(tmp_path: Path) -> None:
    """As `ros2 bag record --compression-mode message` writes them; and no advice goes in a circle."""
    packed = [zstandard.compress(CDR + struct.pack("<d", float(i))) for i in range(5)]
    path = bag(tmp_path / "x.mcap", "float64 v\n", packed)
    assert values(path) == {"x.v": [0.0, 1.0, 2.0, 3.0, 4.0]}
    assert repair(path) is None


def test_what_log_repair_calls_whole_is_never_sent_there(tmp_path: Path) -> None:
    """Flipped bits anywhere: read whole, or refused with `log repair`, which then mends it."""
    whole = bag(
        tmp_path / "x.mcap", "float64 v\n", [CDR + struct.pack("<d", float(i)) for i in range(40)], chunk_size=200
    )
    content, random, sent = whole.read_bytes(), np.random.default_rng(0), list[tuple[Path, str]]()
    for i in range(150):
        flipped = bytearray(content)
        flipped[random.integers(8, len(content) - 8)] ^= 1 << int(random.integers(8))
        damaged = tmp_path / f"{i}.mcap"
        damaged.write_bytes(flipped)
        try:
            table = read_table(damaged)
        except InputError as error:
            sent.append((damaged, str(error)))
            continue
        assert table.words or set(table.columns["x.v"].values) <= set(np.arange(40.0)), i
    mended = [repair(damaged) is not None for damaged, line in sent if "log repair" in line]
    assert len(mended) > 10
    assert all(mended)


def log_of(path: Path, clock: str | None, *columns: str, unit: str = "s") -> Any:
    entries = [{"from": name, "signal": signal, "unit": "N" if signal == "force" else "m"}
               for name, signal in zip(columns, ("force", "position"), strict=False)]  # fmt: skip
    time = {"time": {"column": clock, "unit": unit}} if clock else {}
    return read_log(path, parse_mapping({**time, "column": entries}))


def stamped(path: Path, late: Callable[[int], float], *more: Message) -> Path:
    """Messages with stamps every 0.1 s that were logged later, and out of order."""
    messages: list[Message] = [
        ("/p", 0.1 * i + late(i), "sensor_msgs/msg/FluidPressure",
         {"header": header(1000 + 0.1 * i), "fluid_pressure": float(i), "variance": 0.0})
        for i in range(30)
    ]  # fmt: skip
    return write_ros(path, sorted([*messages, *more], key=lambda one: one[1]), 5 * 10**9)


def test_the_clock_in_messages_is_a_clock(tmp_path: Path) -> None:
    path = stamped(tmp_path / "x.mcap", lambda i: 0.03 * (i % 3))
    assert log_of(path, None, "p.fluid_pressure").attrs["log_start"] == 0.0
    for clock in ("header.stamp", "p.header.stamp"):
        log = log_of(path, clock, "p.fluid_pressure")
        assert log["time"].values == pytest.approx(0.1 * np.arange(30), abs=1e-6)
        assert log["force"].values == pytest.approx(np.arange(30.0))
        assert log.attrs["log_start"] == pytest.approx(1000.0)


def test_a_clock_in_messages_is_that_of_their_topic(tmp_path: Path) -> None:
    other: Message = ("/valves", 1.0, "rig_msgs/msg/Volts", {"data": [1.0, 2.0], "on": True, "label": ""})
    content = {"header": header(1000.25), "name": ["a"], "position": [0.7], "velocity": [], "effort": []}
    state: Message = ("/s", 0.5, "sensor_msgs/msg/JointState", content)
    later: Message = (*state[:1], 0.9, state[2], {**content, "header": header(1000.35), "position": [0.9]})
    path = stamped(tmp_path / "x.mcap", lambda _: 0.0, other, state, later)
    log = log_of(path, "header.stamp", "p.fluid_pressure", "s.position.a")
    assert log["position"].values[3] == pytest.approx(0.8, abs=1e-6)
    for clock, column, expected in (
        ("header.stamp", "valves.data.0", "'valves.data.0' carry no 'header.stamp'; leave that column out, or go by"),
        ("p.header.stamp", "s.position.a", "carry no 'p.header.stamp'; name the field alone, as \"header.stamp\""),
        ("no.stamp", "p.variance", "no clock 'no.stamp' in x.mcap; use 'log_time', which all samples have"),
    ):
        with pytest.raises(InputError) as caught:
            log_of(path, clock, "p.fluid_pressure", column)
        assert expected in str(caught.value)
    with pytest.raises(InputError, match=r"'header.stamp' is in s; give unit"):
        log_of(path, "header.stamp", "p.fluid_pressure", unit="ms")


def test_a_guess_tells_what_of_a_bag_it_leaves_out(tmp_path: Path) -> None:
    topics = {
        "/angle": ("json", "jsonschema", "{}", [json.dumps({"angle": 0.1 * i}).encode() for i in range(5)]),
        "/camera": ("protobuf", "protobuf", "", [b""]),
    }
    guess = guess_mapping(bag_of(tmp_path / "x.mcap", topics))
    assert "protobuf" in guess.ignored["camera"]


def sqlite_bag(path: Path, kind: str, messages: list[bytes], definition: str = "") -> Path:
    """A bag as rosbag2 keeps it in SQLite, with definitions of its types where there is one."""
    database = sqlite3.connect(path)
    database.execute("CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT)")
    database.execute("CREATE TABLE messages(id INTEGER, topic_id INTEGER, timestamp INTEGER, data BLOB)")
    database.execute("INSERT INTO topics VALUES(1, '/x', ?, 'cdr')", (kind,))
    rows = [(i, 1, i * 10**8, data) for i, data in enumerate(messages)]
    database.executemany("INSERT INTO messages VALUES(?, ?, ?, ?)", rows)
    if definition:
        database.execute(
            "CREATE TABLE message_definitions(topic_type TEXT, encoding TEXT, encoded_message_definition TEXT)"
        )
        database.execute("INSERT INTO message_definitions VALUES(?, 'ros2msg', ?)", (kind, definition))
    database.commit()
    database.close()
    return path


def test_bags_in_sqlite(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    floats = [CDR + struct.pack("<d", float(i)) for i in range(4)]
    assert values(sqlite_bag(tmp_path / "a.db3", "std_msgs/msg/Float64", floats)) == {"x.data": [0.0, 1.0, 2.0, 3.0]}
    bytes_ = [CDR + bytes([200, i]) for i in range(4)]
    own = sqlite_bag(tmp_path / "b.db3", "p/msg/Own", bytes_, "byte b\nchar c\nuint8 LIMIT=7\n")
    assert values(own) == {"x.b": [200.0] * 4, "x.c": [0.0, 1.0, 2.0, 3.0]}
    packed = [zstandard.compress(data) for data in floats]
    assert values(sqlite_bag(tmp_path / "c.db3", "std_msgs/msg/Float64", packed))["x.data"][3] == 3.0
    unknown = sqlite_bag(tmp_path / "d.db3", "p/msg/Nobody", floats)
    with pytest.raises(InputError, match="the file does not define p/msg/Nobody"):
        read_table(unknown)


def test_what_stands_in_the_write_ahead_log_of_a_bag_is_read(tmp_path: Path) -> None:
    """A recorder that was killed leaves its last messages there, and rosbags 0.11 leaves them out."""
    pytest.importorskip("rosbags")
    path = sqlite_bag(tmp_path / "a.db3", "std_msgs/msg/Float64", [CDR + struct.pack("<d", 0.0)])
    code = (
        f"import os, sqlite3; bag = sqlite3.connect({str(path)!r}); bag.execute('PRAGMA journal_mode=WAL');"
        f"bag.execute('INSERT INTO messages VALUES(1, 1, 100000000, ?)', ({CDR + struct.pack('<d', 7.0)!r},));"
        "bag.commit(); os._exit(1)"
    )
    subprocess.run([sys.executable, "-c", code], check=False)
    assert path.with_name("a.db3-wal").stat().st_size > 0
    assert values(path) == {"x.data": [0.0, 7.0]}


def test_an_sqlite_file_that_is_no_bag(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    database = sqlite3.connect(tmp_path / "x.db3")
    database.execute("CREATE TABLE t(a)")
    database.close()
    with pytest.raises(InputError, match="is an SQLite file, but no bag of ROS 2"):
        read_table(tmp_path / "x.db3")


def test_bags_of_ros1(tmp_path: Path) -> None:
    rosbag1 = pytest.importorskip("rosbags.rosbag1")
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    state, head = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    time = store.types["builtin_interfaces/msg/Time"]
    with rosbag1.Writer(tmp_path / "x.bag") as writer:
        connection = writer.add_connection("/s", "sensor_msgs/msg/JointState", typestore=store)
        for i in range(5):
            nothing = np.zeros(0)
            message = state(head(i, time(100 + i, 0), ""), ["elbow"], np.array([0.1 * i]), nothing, nothing)
            data = store.serialize_ros1(message, "sensor_msgs/msg/JointState")
            writer.write(connection, (100 + i) * 10**9, data)
    read = values(tmp_path / "x.bag")
    assert read["s.position.elbow"] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert read["s.header.stamp"] == [100.0, 101.0, 102.0, 103.0, 104.0]
    log = log_of(tmp_path / "x.bag", "header.stamp", "s.position.elbow")
    assert log["time"].values == pytest.approx(np.arange(5.0))
    whole = (tmp_path / "x.bag").read_bytes()
    (tmp_path / "cut.bag").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="can't be read as a bag of ROS 1"):
        read_table(tmp_path / "cut.bag")


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        (
            "x.mcap.zstd",
            zstandard.compress(b"\x89MCAP0\r\n"),
            "is compressed as a whole; unpack it first: `zstd -d x.mcap.zstd`",
        ),
        ("x.db3", b"no", "needs rosbags|can't be read as a bag of ROS 2 in SQLite"),
        ("x.bag", b"no", "needs rosbags|can't be read as a bag of ROS 1"),
        ("x.mcap", b"", "is empty; give an MCAP file"),
    ],
)
def test_what_is_no_bag_is_told_in_one_line(tmp_path: Path, name: str, content: bytes, expected: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=expected) as caught:
        read_table(tmp_path / name)
    assert "\n" not in str(caught.value)


def test_a_folder_of_a_bag_names_what_is_inside(tmp_path: Path) -> None:
    folder = tmp_path / "rosbag2"
    folder.mkdir()
    (folder / "rosbag2_0.mcap").write_bytes(b"")
    with pytest.raises(InputError, match=r"give the recording inside: .*rosbag2_0.mcap"):
        read_table(folder)
