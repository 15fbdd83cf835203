"""Columns of the numbers in recorded messages, for all recorders and decoders."""

from array import array
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from layflat.errors import InputError
from layflat.identify.logs.table import FileContent, Header, LogColumn, parse_header

MAX_ITEMS = 64  # of an array that is read as columns; longer ones are images and scans
MAX_REASON = 120  # characters of a library's message that are passed on
TIME_FIELDS = ({"sec", "nanosec"}, {"sec", "nsec"}, {"secs", "nsecs"})  # of a time in ROS 2, in JSON, and in ROS 1
ZSTD = b"\x28\xb5\x2f\xfd"  # first bytes of data compressed by zstd; no message in CDR or JSON has them
LOG_TIME = Header("log_time", "s", None, "log_time")

Decode = Callable[[bytes], Any]


class MessageTime(float):
    """Time in a message, s."""


@dataclass
class _FieldSamples:
    """Values of one field of a topic, with log time (ns) and number of their messages."""

    topic: str
    unit: str
    stamps: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    values: list[float] = field(default_factory=list)

    def column(self, name: str, first: int) -> LogColumn:
        """Return the column of these samples in order of log time, in s since `first` (ns)."""
        stamps = np.array([stamp - first for stamp in self.stamps], dtype=np.int64)
        order = np.argsort(stamps, kind="stable")
        since = stamps[order].astype(np.float64) * 1e-9
        values = np.array(self.values, dtype=np.float64)[order]
        return LogColumn(values, parse_header(name, self.unit), since, (), self.topic, np.array(self.numbers)[order])


class MessageColumns:
    """Columns "topic.field" of messages that are added one by one, and the reasons for what is left out."""

    def __init__(self) -> None:
        self._samples: dict[str, _FieldSamples] = {}
        self._messages: Counter[str] = Counter()
        self._failures: dict[str, tuple[int, str]] = {}
        self._left_out: dict[str, str] = {}

    def add(self, topic: str, stamp: int, data: bytes, decode: Decode | str) -> None:
        """Add the numbers of a message; one that can't be decoded is counted, and hides no other.

        Args:
            topic: name of its topic.
            stamp: log time, ns.
            data: the message as recorded.
            decode: its decoder, or why there is none.
        """
        number = self._messages[topic]
        self._messages[topic] += 1
        if isinstance(decode, str):
            self._left_out[topic] = decode
            return
        try:
            values = list(flatten_message(decode(data)))
        except Exception as error:  # damaged bytes can make decoders raise any error
            count, reason = self._failures.get(topic, (0, error_reason(error)))
            self._failures[topic] = count + 1, reason
            return
        for name, value in values:
            whole = f"{topic}.{name}" if name else topic
            if isinstance(value, str):
                self._left_out[whole] = value
                continue
            samples = self._samples.setdefault(
                whole, _FieldSamples(topic, "s" if isinstance(value, MessageTime) else "")
            )
            samples.stamps.append(stamp)
            samples.numbers.append(number)
            samples.values.append(value)

    def content(self, where: str) -> FileContent:
        """Return the columns, each over its log times since the first message, and what is left out and why.

        Raise InputError if there is no column.
        """
        left_out = self._reasons()
        if not self._samples:
            shown = "; ".join(f"{name}: {reason}" for name, reason in list(left_out.items())[:3])
            problem = f"holds no messages with numbers ({shown})" if shown else "holds no messages"
            right = "give messages of ROS 2 (CDR), of ROS 1 or in JSON" if shown else "give a log of a motion"
            raise InputError(problem, where=where, right=right)
        first = min(min(samples.stamps) for samples in self._samples.values())
        columns = {name: samples.column(name, first) for name, samples in self._samples.items()}
        return FileContent(columns, LOG_TIME, left_out)

    def _reasons(self) -> dict[str, str]:
        """Return the reasons by topic, or field of a topic, for what is left out."""
        reasons = {
            topic: f"{count} of {self._messages[topic]} messages can't be decoded ({reason})"
            for topic, (count, reason) in self._failures.items()
        } | self._left_out
        filled = {samples.topic for samples in self._samples.values()}
        for topic in self._messages:
            if topic not in filled and not any(name == topic or name.startswith(f"{topic}.") for name in reasons):
                reasons[topic] = "its messages hold no numbers"
        return reasons


class TopicNames(dict[str, str]):
    """Names of topics without their slash, by topic, with a number where two would be equal."""

    def __missing__(self, topic: str) -> str:
        """Return a name for a new topic, and keep it."""
        plain, used = topic.lstrip("/"), set(self.values())
        name = next(name for i in range(len(used) + 1) if (name := f"{plain}_{i + 1}" if i else plain) not in used)
        self[topic] = name
        return name


def decompress_messages(decode: Decode | str) -> Decode | str:
    """Return the decoder, extended to messages compressed one by one, as in rosbag2's message mode; a reason as is."""
    if isinstance(decode, str):
        return decode

    def unpacked(data: bytes) -> Any:
        """Return the decoded message, decompressed first if it is compressed by zstd."""
        if data[:4] != ZSTD:
            return decode(data)
        import zstandard  # noqa: PLC0415

        return decode(zstandard.ZstdDecompressor().decompressobj().decompress(data))

    return unpacked


def flatten_message(
    message: Any, prefix: str = "", names: Sequence[str] | None = None
) -> Iterator[tuple[str, float | str]]:
    """Yield dotted names and values of all numbers in a message; for long arrays and numbers as text, a reason.

    Other content is passed over.

    A time of seconds and nanoseconds is one number, s. Items of arrays are "field.0" and so on, or have the names in
    the field `name` or `names` of the message, as in sensor_msgs/JointState.

    Args:
        message: message from its decoder, or a part of one.
        prefix: dotted name of the part.
        names: names of the items, if the part is an array.
    """
    if isinstance(message, (list, tuple, array, bytes, bytearray, np.ndarray)):
        if len(message) > MAX_ITEMS:
            yield prefix, f"{len(message)} items, and an array of more than {MAX_ITEMS} is no signal"
            return
        labels = names if names is not None and len(names) == len(message) else range(len(message))
        for label, item in zip(labels, message, strict=True):
            yield from flatten_message(item, f"{prefix}.{label}" if prefix else str(label))
        return
    fields = _message_fields(message)
    if fields is None:
        if isinstance(message, (bool, int, float, np.number, np.bool_)):
            yield prefix, float(message)
        elif isinstance(message, str) and _is_number(message):
            yield prefix, f"numbers written as text, such as {message!r}"
    elif set(fields) in TIME_FIELDS:
        seconds, fraction = (fields[name] for name in sorted(fields, key=lambda name: not name.startswith("sec")))
        yield prefix, MessageTime(seconds + 1e-9 * fraction)
    else:
        item_names = _unique_names(fields)
        for key, value in fields.items():
            yield from flatten_message(value, f"{prefix}.{key}" if prefix else key, item_names)


def _is_number(text: str) -> bool:
    """Return whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _unique_names(fields: Mapping[str, Any]) -> list[str] | None:
    """Return the names in a message for the items of its arrays; None without any, or with one twice."""
    names = fields.get("name", fields.get("names"))
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        return None
    return names if len(set(names)) == len(names) else None


def _message_fields(message: Any) -> dict[str, Any] | None:
    """Return the fields of a message by name; None for anything else."""
    if isinstance(message, dict):
        return {str(name): value for name, value in message.items()}
    if isinstance(message, SimpleNamespace) or hasattr(message, "__slots__"):
        slots = getattr(message, "__slots__", None) or vars(message)
        return {name: getattr(message, name) for name in slots if not name.startswith("_")}
    return None


def error_reason(error: Exception) -> str:
    """Return the message of a library's error as one short line."""
    return " ".join(str(error).split())[:MAX_REASON] or type(error).__name__
