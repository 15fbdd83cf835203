"""Bags of ROS 1 (.bag) and of ROS 2 in SQLite (.db3), and types of messages that MCAP's own package does not read."""

import re
import sqlite3
from collections.abc import Iterator
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any

from layflat import extras
from layflat.errors import InputError, LayflatError
from layflat.identify.logs.messages import Decode, MessageColumns, TopicNames, reason_of, unpacking
from layflat.identify.logs.table import Content

_RULE = "=" * 80 + "\n"


def read_bag_of_ros1(path: Path) -> Content:
    """Read a bag of ROS 1; raise InputError if it can't be read, or rosbags is not installed."""
    extras.require("logs", "rosbags", where=str(path))
    from rosbags.rosbag1 import Reader  # noqa: PLC0415

    columns, names, decoders = MessageColumns(), TopicNames(), dict[int, Decode | str]()
    try:
        with Reader(path) as bag:
            for connection, stamp, data in bag.messages():
                if connection.id not in decoders:
                    text = connection.msgdef.data
                    decoders[connection.id] = attempted(ros1_decoder, connection.msgtype, text)
                columns.add(names[connection.topic], stamp, data, decoders[connection.id])
    except LayflatError:
        raise
    except Exception as error:  # a damaged file can make the reader raise nearly anything
        what = f"can't be read as a bag of ROS 1 ({reason_of(error)})"
        right = "give a whole one: `rosbag reindex` of ROS 1 mends one that was cut short"
        raise InputError(what, where=str(path), right=right) from None
    return columns.content(str(path))


def read_bag_in_sqlite(path: Path) -> Content:
    """Read a bag of ROS 2 in SQLite; raise InputError if it can't be read, or rosbags is not installed."""
    extras.require("logs", "rosbags", where=str(path))
    columns, names, decoders = MessageColumns(), TopicNames(), dict[int, Decode | str]()
    try:
        for number, topic, kind, encoding, definition, stamp, data in _rows(path):
            if number not in decoders:
                decoders[number] = attempted(_sqlite_decoder, kind, encoding, definition)
            columns.add(names[topic], stamp, data, decoders[number])
    except sqlite3.Error as error:
        what = f"can't be read as a bag of ROS 2 in SQLite ({reason_of(error)})"
        raise InputError(what, where=str(path), right="give a whole one, as `ros2 bag record` writes it") from None
    return columns.content(str(path))


def _rows(path: Path) -> Iterator[tuple[int, str, str, str, tuple[str, str] | None, int, bytes]]:
    """Yield topic's number, name, type, encoding, definition (its encoding and text), log time (ns) and message."""
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
    if encoding != "cdr":
        return f"its messages are in {encoding}, which is not read here"
    if definition is not None and definition[0] == "ros2idl":
        return ros2_idl_decoder(kind, definition[1])
    if definition is not None and definition[1]:
        return ros2_decoder(kind, definition[1])
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    usual = get_typestore(Stores.LATEST)
    if kind not in usual.fielddefs:
        return f"the file does not define {kind}, and no usual type has that name: record it anew as MCAP"
    return ros2_decoder(kind, str(usual.generate_msgdef(kind, ros_version=2)[0]))


def attempted(make: Any, *arguments: Any) -> Decode | str:
    """Return a decoder that takes messages compressed one by one, too, or why there is none."""
    try:
        with redirect_stderr(StringIO()):  # one of the parsers prints what it raises
            return unpacking(make(*arguments))
    except LayflatError as error:
        return str(error)
    except Exception as error:  # a definition that makes no sense can make its parser raise nearly anything
        return f"its type can't be read ({reason_of(error)})"


def unsigned(definition: str) -> str:
    """Return a definition of ROS 2 with the words that decoders take differently said plainly: both are bytes 0 to 255.

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

    return _decoder(kind, get_types_from_msg(unsigned(definition), kind), "deserialize_cdr")


def ros2_idl_decoder(kind: str, definition: str) -> Decode:
    """Return a decoder of messages in CDR whose type is defined as .idl."""
    from rosbags.typesys import get_types_from_idl  # noqa: PLC0415

    types: dict[str, Any] = {}
    plain = re.sub(r"\boctet\b", "uint8", definition)  # which rosbags 0.11 reads with a sign
    for part in filter(None, plain.split(_RULE)):
        types |= get_types_from_idl(part.partition("\n")[2] if part.startswith("IDL: ") else part)
    return _decoder(kind, types, "deserialize_cdr")


def _decoder(kind: str, types: dict[str, Any], method: str) -> Decode:
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415
    from rosbags.typesys.msg import normalize_msgtype  # noqa: PLC0415

    store = get_typestore(Stores.EMPTY)
    store.register(types)
    name, read = normalize_msgtype(kind), getattr(store, method)

    def decode(data: bytes) -> Any:
        return _plain(read(data, name), store.fielddefs)

    return of_plain_cdr(decode) if method == "deserialize_cdr" else decode


def of_plain_cdr(decode: Decode) -> Decode:
    """Return a decoder that refuses other kinds of CDR, which align numbers otherwise: they would be read as others."""

    def checked(data: bytes) -> Any:
        if data[:1] != b"\0" or data[1:2] not in {b"\0", b"\1"}:
            raise ValueError(f"its kind of CDR, {data[:2].hex()}, is not read here")
        return decode(data)

    return checked


def _plain(value: Any, definitions: Any) -> Any:
    """Return a message as a table of its fields: its own object has the type's constants among them."""
    if isinstance(value, list):
        return [_plain(item, definitions) for item in value]
    kind = getattr(value, "__msgtype__", None)
    if kind is None:
        return value
    return {name: _plain(getattr(value, name), definitions) for name, _ in definitions[kind][1]}
