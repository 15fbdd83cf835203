"""MCAP files: messages of ROS 2, of ROS 1 or in JSON as columns, each with the log time of its messages."""

import json
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layflat import extras
from layflat.errors import InputError
from layflat.identify.logs.headers import Header
from layflat.identify.logs.messages import Decode, MessageColumns, TopicNames, reason_of
from layflat.identify.logs.rosbag import attempted, of_plain_cdr, ros1_decoder, ros2_idl_decoder, unsigned
from layflat.identify.logs.table import Column, Content

if TYPE_CHECKING:
    from mcap.records import Channel, Schema

CYCLE = "layflat_msgs/msg/Cycle"  # type of the messages of a rig's recorder
SCHEMA, CHANNEL, MESSAGE = 3, 4, 5  # kinds of records
TIME_TYPES = ("Time", "Duration")


def read_bag(path: Path) -> Content:
    """Read an MCAP file; times are seconds since the first message.

    What can't be decoded is left out with its reason. A log of `layflat rig` has our own names, without topics: its
    cycles alone are read, over their own time. Raise InputError if it is none, is not whole, nothing in it can be
    decoded, or the packages are not installed.
    """
    from layflat.rig.recorder.repair import PART, Kept, check_magic, records  # noqa: PLC0415

    extras.require("logs", "mcap", "mcap_ros2", where=str(path))
    check_magic(path)
    bag, kept = _Bag(), Kept()
    for kind, body in records(path, kept):
        bag.add(kind, body)
        if bag.of_rig:
            return Content(_rig_columns(path), Header("time", "s", None, "time"))
    if not kept.ended or kept.lost or path.name.endswith(PART):
        what = f"{kept.lost} bytes make no whole record" if kept.lost else "it was not finished"
        right = "give a whole MCAP file; `layflat log repair` keeps what is whole of this one"
        raise InputError(f"can't be read as MCAP ({what})", where=str(path), right=right)
    return bag.columns.content(str(path))


class _Bag:
    """Schemas, channels and messages of a file, as they come."""

    def __init__(self) -> None:
        self.columns = MessageColumns()
        self.of_rig = False  # the recorder of a rig has written it
        self._names = TopicNames()
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, tuple[str, Decode | str]] = {}

    def add(self, kind: int, body: bytes) -> None:
        """Take in a record; one that makes no sense is left out with its reason."""
        if kind not in {SCHEMA, CHANNEL, MESSAGE}:
            return
        try:
            self._add(kind, body)
        except Exception as error:  # bytes that make no sense can make readers raise nearly anything
            self.columns.add("records", 0, body, f"some can't be read ({reason_of(error)})")

    def _add(self, kind: int, body: bytes) -> None:
        from mcap import records  # noqa: PLC0415
        from mcap.data_stream import ReadDataStream  # noqa: PLC0415

        stream = ReadDataStream(BytesIO(body))
        if kind == MESSAGE:
            message = records.Message.read(stream, len(body))
            topic, decode = self._channels[message.channel_id]
            self.columns.add(topic, message.log_time, message.data, decode)
        elif kind == SCHEMA:
            schema = records.Schema.read(stream)
            self._schemas[schema.id] = schema
            self.of_rig = self.of_rig or schema.name == CYCLE
        else:
            channel = records.Channel.read(stream)
            self._channels[channel.id] = self._names[channel.topic], attempted(self._decoder, channel)

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

    text = unsigned(schema.data.decode())
    for name in TIME_TYPES:
        if f"builtin_interfaces/{name}\nint32" not in text.replace("/msg/", "/"):
            text = f"{text.rstrip()}\n{'=' * 80}\nMSG: builtin_interfaces/{name}\nint32 sec\nuint32 nanosec\n"
    signed: Any = type(schema)(id=schema.id, data=text.encode(), encoding=schema.encoding, name=schema.name)
    decode = DecoderFactory().decoder_for("cdr", signed)
    assert decode is not None  # it is in CDR, and defined as .msg
    return of_plain_cdr(decode)


def _rig_columns(path: Path) -> dict[str, Column]:
    """Return columns "voltage.large", "supply" and so on."""
    from layflat.rig.recorder.run import read_recording  # noqa: PLC0415

    log = read_recording(path)
    time = log.columns.pop("time")
    columns = {}
    for field, values in log.columns.items():
        names = [field] if values.ndim == 1 else [f"{field}.{joint}" for joint in log.joints]
        for name, column in zip(names, values.reshape(len(time), -1).T, strict=True):
            columns[name] = Column(column, Header(name, "", None, name), time)
    return columns
