"""Recorded messages: MCAP files (of ROS 2, of ROS 1 or in JSON), bags of ROS 1 (.bag) and of ROS 2 in SQLite (.db3).

Each signal is a column with the log time of its messages.
"""

import json
import re
import sqlite3
from collections.abc import Iterator
from contextlib import redirect_stderr
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layflat import extras
from layflat.errors import InputError, LayflatError
from layflat.identify.logs.messages import Decode, MessageColumns, TopicNames, decompress_messages, error_reason
from layflat.identify.logs.table import FileContent, Header, LogColumn

if TYPE_CHECKING:
    from mcap.records import Channel, Schema


_DEFINITION_SEPARATOR = "=" * 80 + "\n"


def read_ros1_bag(path: Path) -> FileContent:
    """Read a bag of ROS 1; raise InputError if it can't be read, or rosbags is not installed."""
    extras.require("logs", "rosbags", where=str(path))
    from rosbags.rosbag1 import Reader  # noqa: PLC0415

    columns, names, decoders = MessageColumns(), TopicNames(), dict[int, Decode | str]()
    try:
        with Reader(path) as bag:
            for connection, stamp, data in bag.messages():
                if connection.id not in decoders:
                    text = connection.msgdef.data
                    decoders[connection.id] = make_decoder(ros1_decoder, connection.msgtype, text)
                columns.add(names[connection.topic], stamp, data, decoders[connection.id])
    except LayflatError:
        raise
    except Exception as error:  # a damaged file can make the reader raise nearly anything
        problem = f"can't be read as a bag of ROS 1 ({error_reason(error)})"
        right = "give a whole one: `rosbag reindex` of ROS 1 mends one that was cut short"
        raise InputError(problem, where=str(path), right=right) from None
    return columns.content(str(path))


def read_sqlite_bag(path: Path) -> FileContent:
    """Read a bag of ROS 2 in SQLite; raise InputError if it can't be read, or rosbags is not installed."""
    extras.require("logs", "rosbags", where=str(path))
    columns, names, decoders = MessageColumns(), TopicNames(), dict[int, Decode | str]()
    try:
        for number, topic, kind, encoding, definition, stamp, data in _sqlite_messages(path):
            if number not in decoders:
                decoders[number] = make_decoder(_sqlite_decoder, kind, encoding, definition)
            columns.add(names[topic], stamp, data, decoders[number])
    except sqlite3.Error as error:
        problem = f"can't be read as a bag of ROS 2 in SQLite ({error_reason(error)})"
        raise InputError(problem, where=str(path), right="give a whole one, as `ros2 bag record` writes it") from None
    return columns.content(str(path))


def _sqlite_messages(path: Path) -> Iterator[tuple[int, str, str, str, tuple[str, str] | None, int, bytes]]:
    """Yield of each message, by log time: topic's number, name, type, encoding, definition; log time (ns), bytes.

    A definition is its encoding and text, None where the file has none. Raises InputError if the file is no such bag.
    """
    uri = f"{path.resolve().as_uri()}?mode=ro"
    if not path.with_name(f"{path.name}-wal").exists():
        uri += "&immutable=1"  # so that nothing is written beside it
    database = sqlite3.connect(uri, uri=True)
    try:
        tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        if not {"topics", "messages"} <= tables:
            right = "give one that `ros2 bag record` wrote"
            raise InputError("is an SQLite file, but no bag of ROS 2", where=str(path), right=right)
        definitions = {}
        if "message_definitions" in tables:
            select = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            definitions = {kind: (encoding, text) for kind, encoding, text in database.execute(select)}
        topics = {
            number: (name, kind, encoding, definitions.get(kind))
            for number, name, kind, encoding in database.execute(
                "SELECT id, name, type, serialization_format FROM topics"
            )
        }
        select = "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp"
        for number, stamp, data in database.execute(select):
            yield number, *topics[number], stamp, data
    finally:
        database.close()


def _sqlite_decoder(kind: str, encoding: str, definition: tuple[str, str] | None) -> Decode | str:
    """Return the decoder of a topic of a SQLite bag, or why there is none."""
    if encoding != "cdr":
        return f"its messages are in {encoding}, which is not read here"
    if definition is not None and definition[0] == "ros2idl":
        return ros2_idl_decoder(kind, definition[1])
    if definition is not None and definition[1]:
        return ros2_decoder(kind, definition[1])
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    latest_types = get_typestore(Stores.LATEST)
    if kind not in latest_types.fielddefs:
        return f"the file does not define {kind}, and no usual type has that name: record it anew as MCAP"
    return ros2_decoder(kind, str(latest_types.generate_msgdef(kind, ros_version=2)[0]))


def make_decoder(make: Any, *arguments: Any) -> Decode | str:
    """Return the decoder that `make` returns, also for messages compressed one by one; or why there is none."""
    try:
        with redirect_stderr(StringIO()):  # one of the parsers prints what it raises
            return decompress_messages(make(*arguments))
    except LayflatError as error:
        return str(error)
    except Exception as error:  # a definition that makes no sense can make its parser raise nearly anything
        return f"its type can't be read ({error_reason(error)})"


def define_bytes_unsigned(definition: str) -> str:
    """Return a definition of ROS 2 with `uint8` for `char` and `byte`, which decoders read differently.

    rosidl_adapter maps `char` to uint8 and `byte` to octet; mcap-ros2-support 0.6 reads the first with a sign, rosbags
    0.11 the second.
    """
    return re.sub(r"^(\s*)(?:char|byte)(?=[\s\[])", r"\1uint8", definition, flags=re.MULTILINE)


def ros1_decoder(kind: str, definition: str) -> Decode:
    """Return a decoder of messages of ROS 1."""
    from rosbags.typesys import get_types_from_msg  # noqa: PLC0415

    return _decoder(kind, get_types_from_msg(definition, kind), "deserialize_ros1")


def ros2_decoder(kind: str, definition: str) -> Decode:
    """Return a decoder of messages in CDR whose type is defined as .msg."""
    from rosbags.typesys import get_types_from_msg  # noqa: PLC0415

    return _decoder(kind, get_types_from_msg(define_bytes_unsigned(definition), kind), "deserialize_cdr")


def ros2_idl_decoder(kind: str, definition: str) -> Decode:
    """Return a decoder of messages in CDR whose type is defined as .idl."""
    from rosbags.typesys import get_types_from_idl  # noqa: PLC0415

    types: dict[str, Any] = {}
    plain = re.sub(r"\boctet\b", "uint8", definition)  # which rosbags 0.11 reads with a sign
    for part in filter(None, plain.split(_DEFINITION_SEPARATOR)):
        types |= get_types_from_idl(part.partition("\n")[2] if part.startswith("IDL: ") else part)
    return _decoder(kind, types, "deserialize_cdr")


def _decoder(kind: str, types: dict[str, Any], method: str) -> Decode:
    """Return a decoder of messages of a type, by the types of its definition and a method such as "deserialize_cdr"."""
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415
    from rosbags.typesys.msg import normalize_msgtype  # noqa: PLC0415

    store = get_typestore(Stores.EMPTY)
    store.register(types)
    name, read = normalize_msgtype(kind), getattr(store, method)

    def decode(data: bytes) -> Any:
        return _field_table(read(data, name), store.fielddefs)

    return check_plain_cdr(decode) if method == "deserialize_cdr" else decode


def check_plain_cdr(decode: Decode) -> Decode:
    """Return a decoder that raises ValueError for all but plain CDR: other encodings align numbers differently."""

    def checked(data: bytes) -> Any:
        if data[:1] != b"\0" or data[1:2] not in {b"\0", b"\1"}:
            raise ValueError(f"its kind of CDR, {data[:2].hex()}, is not read here")
        return decode(data)

    return checked


def _field_table(value: Any, definitions: Any) -> Any:
    """Return a message as a table of its fields, without the constants that its object has among them."""
    if isinstance(value, list):
        return [_field_table(item, definitions) for item in value]
    kind = getattr(value, "__msgtype__", None)
    if kind is None:
        return value
    return {name: _field_table(getattr(value, name), definitions) for name, _ in definitions[kind][1]}


CYCLE_TYPE = "layflat_msgs/msg/Cycle"  # type of the messages of a rig's recorder
SCHEMA_RECORD, CHANNEL_RECORD, MESSAGE_RECORD = 3, 4, 5  # opcodes of MCAP records
TIME_TYPES = ("Time", "Duration")


def read_mcap(path: Path) -> FileContent:
    """Read an MCAP file; times are seconds since the first message.

    Topics that can't be decoded are left out with the reason. Of a log of `layflat rig` only the control cycles are
    read, over their own time, under layflat's names without topics.

    Raises:
        InputError: it is no MCAP file, is cut off, holds nothing that can be decoded, or a package is not installed.
    """
    from layflat.rig.recorder.repair import PART_SUFFIX, RepairSummary, check_magic, read_records  # noqa: PLC0415

    extras.require("logs", "mcap", "mcap_ros2", where=str(path))
    check_magic(path)
    bag, kept = _BagColumns(), RepairSummary()
    for kind, body in read_records(path, kept):
        bag.add(kind, body)
        if bag.of_rig:
            return FileContent(_rig_columns(path), Header("time", "s", None, "time"))
    if not kept.ended or kept.lost or path.name.endswith(PART_SUFFIX):
        problem = f"{kept.lost} bytes make no whole record" if kept.lost else "it was not finished"
        right = "give a whole MCAP file; `layflat log repair` keeps what is whole of this one"
        raise InputError(f"can't be read as MCAP ({problem})", where=str(path), right=right)
    return bag.columns.content(str(path))


class _BagColumns:
    """Columns of an MCAP file, from its schemas, channels and messages in the order of the file."""

    def __init__(self) -> None:
        self.columns = MessageColumns()
        self.of_rig = False  # written by the recorder of a rig
        self._names = TopicNames()
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, tuple[str, Decode | str]] = {}

    def add(self, kind: int, body: bytes) -> None:
        """Add a record; one that can't be read is left out with the reason."""
        if kind not in {SCHEMA_RECORD, CHANNEL_RECORD, MESSAGE_RECORD}:
            return
        try:
            self._add_record(kind, body)
        except Exception as error:  # bytes that make no sense can make readers raise nearly anything
            self.columns.add("records", 0, body, f"some can't be read ({error_reason(error)})")

    def _add_record(self, kind: int, body: bytes) -> None:
        """Add a record of an MCAP file: the numbers of a message, or a schema or channel that later messages need."""
        from mcap import records  # noqa: PLC0415
        from mcap.data_stream import ReadDataStream  # noqa: PLC0415

        stream = ReadDataStream(BytesIO(body))
        if kind == MESSAGE_RECORD:
            message = records.Message.read(stream, len(body))
            topic, decode = self._channels[message.channel_id]
            self.columns.add(topic, message.log_time, message.data, decode)
        elif kind == SCHEMA_RECORD:
            schema = records.Schema.read(stream)
            self._schemas[schema.id] = schema
            self.of_rig = self.of_rig or schema.name == CYCLE_TYPE
        else:
            channel = records.Channel.read(stream)
            self._channels[channel.id] = self._names[channel.topic], make_decoder(self._decoder, channel)

    def _decoder(self, channel: "Channel") -> Decode | str:
        """Return a channel's decoder, or why there is none."""
        encoding, schema = channel.message_encoding, self._schemas.get(channel.schema_id)
        kind = schema.encoding if schema is not None else ""
        if encoding == "json":
            return json.loads
        if schema is not None and (encoding, kind) == ("cdr", "ros2msg"):
            return _ros2_decoder(schema)
        make = {("cdr", "ros2idl"): ros2_idl_decoder, ("ros1", "ros1msg"): ros1_decoder}.get((encoding, kind))
        if schema is not None and make is not None:
            extras.require("logs", "rosbags")
            return make(schema.name, schema.data.decode())
        if encoding == "cdr" and schema is None:
            return "the file does not define the type of its messages"
        named = " with schemas in ".join(filter(None, (encoding, kind))) or "an encoding that it does not name"
        return f"its messages are in {named}, which is not read here"


def _ros2_decoder(schema: "Schema") -> Decode:
    """Return a decoder of messages in CDR; times without a definition of their own have signed seconds, as ROS says."""
    from mcap_ros2.decoder import DecoderFactory  # noqa: PLC0415

    text = define_bytes_unsigned(schema.data.decode())
    for name in TIME_TYPES:
        if f"builtin_interfaces/{name}\nint32" not in text.replace("/msg/", "/"):
            text = f"{text.rstrip()}\n{'=' * 80}\nMSG: builtin_interfaces/{name}\nint32 sec\nuint32 nanosec\n"
    signed: Any = type(schema)(id=schema.id, data=text.encode(), encoding=schema.encoding, name=schema.name)
    decode = DecoderFactory().decoder_for("cdr", signed)
    assert decode is not None  # it is in CDR, and defined as .msg
    return check_plain_cdr(decode)


def _rig_columns(path: Path) -> dict[str, LogColumn]:
    """Return the columns of a rig's log: "voltage.large", "supply" and so on."""
    from layflat.rig.recorder.run import read_recording  # noqa: PLC0415

    log = read_recording(path)
    time = log.columns.pop("time")
    columns = {}
    for field, values in log.columns.items():
        names = [field] if values.ndim == 1 else [f"{field}.{joint}" for joint in log.joints]
        for name, column in zip(names, values.reshape(len(time), -1).T, strict=True):
            columns[name] = LogColumn(column, Header(name, "", None, name), time)
    return columns
