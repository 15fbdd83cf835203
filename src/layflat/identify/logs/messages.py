"""Numbers of recorded messages as columns, whatever recorder wrote them and whatever decodes them."""

from array import array
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from layflat.errors import InputError
from layflat.identify.logs.headers import Header, header_of
from layflat.identify.logs.table import Column, Content

MAX_ITEMS = 64  # of an array that becomes columns; longer ones are images and scans
MAX_REASON = 120  # characters of a decoder's own message that are passed on
TIMES = ({"sec", "nanosec"}, {"sec", "nsec"}, {"secs", "nsecs"})  # fields of a time in ROS 2, in JSON, and in ROS 1
ZSTD = b"\x28\xb5\x2f\xfd"  # first bytes of compressed data; no message in CDR or JSON has them
CLOCK = Header("log_time", "s", None, "log_time")

Decode = Callable[[bytes], Any]


class Seconds(float):
    """A time that a message carries."""


@dataclass
class _Samples:
    """Values of one field of a topic, with log time (ns) and number of their messages."""

    topic: str
    unit: str
    stamps: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    values: list[float] = field(default_factory=list)

    def column(self, name: str, first: int) -> Column:
        """Return the column of these samples in the order of their log times, which count from `first`, ns."""
        stamps = np.array([stamp - first for stamp in self.stamps], dtype=np.int64)
        order = np.argsort(stamps, kind="stable")
        since = stamps[order].astype(np.float64) * 1e-9
        values = np.array(self.values, dtype=np.float64)[order]
        return Column(values, header_of(name, self.unit), since, (), self.topic, np.array(self.numbers)[order])


class MessageColumns:
    """Columns "topic.field" of messages that are added one by one, and what of them makes none."""

    def __init__(self) -> None:
        self._samples: dict[str, _Samples] = {}
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
            values = list(flattened(decode(data)))
        except Exception as error:  # bytes that make no sense can make decoders raise nearly anything
            count, reason = self._failures.get(topic, (0, reason_of(error)))
            self._failures[topic] = count + 1, reason
            return
        for name, value in values:
            whole = f"{topic}.{name}" if name else topic
            if isinstance(value, str):
                self._left_out[whole] = value
                continue
            samples = self._samples.setdefault(whole, _Samples(topic, "s" if isinstance(value, Seconds) else ""))
            samples.stamps.append(stamp)
            samples.numbers.append(number)
            samples.values.append(value)

    def content(self, where: str) -> Content:
        """Return the columns, each over its log times from the first message on, and what was left out and why.

        Raise InputError if there is no column.
        """
        left_out = self._reasons()
        if not self._samples:
            shown = "; ".join(f"{name}: {reason}" for name, reason in list(left_out.items())[:3])
            what = f"holds no messages with numbers ({shown})" if shown else "holds no messages"
            right = "give messages of ROS 2 (CDR), of ROS 1 or in JSON" if shown else "give a log of a motion"
            raise InputError(what, where=where, right=right)
        first = min(min(samples.stamps) for samples in self._samples.values())
        columns = {name: samples.column(name, first) for name, samples in self._samples.items()}
        return Content(columns, CLOCK, left_out)

    def _reasons(self) -> dict[str, str]:
        """Return what makes no column, with the reason: topics, or fields of topics."""
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
    """Names of topics without their slash, with a number where that is the name of another one."""

    def __missing__(self, topic: str) -> str:
        plain, taken = topic.lstrip("/"), set(self.values())
        name = next(name for i in range(len(taken) + 1) if (name := f"{plain}_{i + 1}" if i else plain) not in taken)
        self[topic] = name
        return name


def unpacking(decode: Decode | str) -> Decode | str:
    """Return a decoder that takes messages which a recorder compressed one by one, too, as rosbag2's message mode."""
    if isinstance(decode, str):
        return decode

    def unpacked(data: bytes) -> Any:
        if data[:4] != ZSTD:
            return decode(data)
        import zstandard  # noqa: PLC0415

        return decode(zstandard.ZstdDecompressor().decompressobj().decompress(data))

    return unpacked


def flattened(message: Any, prefix: str = "", names: Sequence[str] | None = None) -> Iterator[tuple[str, float | str]]:
    """Yield dotted names and values of all numbers in a message; of what makes no column the reason, as text.

    A time of seconds and nanoseconds is one number, s. Arrays become "field.0" and so on, or go by name where `name` or
    `names` stands beside them, as in sensor_msgs/JointState.

    Args:
        message: as its decoder made it.
        prefix: name of what it is a part of.
        names: of the items, if it is an array.
    """
    if isinstance(message, (list, tuple, array, bytes, bytearray, np.ndarray)):
        if len(message) > MAX_ITEMS:
            yield prefix, f"{len(message)} items, and an array of more than {MAX_ITEMS} is no signal"
            return
        labels = names if names is not None and len(names) == len(message) else range(len(message))
        for label, item in zip(labels, message, strict=True):
            yield from flattened(item, f"{prefix}.{label}" if prefix else str(label))
        return
    parts = _parts(message)
    if parts is None:
        if isinstance(message, (bool, int, float, np.number, np.bool_)):
            yield prefix, float(message)
        elif isinstance(message, str) and _is_number(message):
            yield prefix, f"numbers written as text, such as {message!r}"
    elif set(parts) in TIMES:
        seconds, fraction = (parts[name] for name in sorted(parts, key=lambda name: not name.startswith("sec")))
        yield prefix, Seconds(seconds + 1e-9 * fraction)
    else:
        own = _unique_names(parts)
        for key, value in parts.items():
            yield from flattened(value, f"{prefix}.{key}" if prefix else key, own)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _unique_names(parts: Mapping[str, Any]) -> list[str] | None:
    """Return the names that stand in a message for the items of its arrays; None where there are none, or one twice."""
    names = parts.get("name", parts.get("names"))
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        return None
    return names if len(set(names)) == len(names) else None


def _parts(message: Any) -> dict[str, Any] | None:
    """Return the fields of a message; None for what is not a message."""
    if isinstance(message, dict):
        return {str(name): value for name, value in message.items()}
    if isinstance(message, SimpleNamespace) or hasattr(message, "__slots__"):
        slots = getattr(message, "__slots__", None) or vars(message)
        return {name: getattr(message, name) for name in slots if not name.startswith("_")}
    return None


def reason_of(error: Exception) -> str:
    """Return what an error of a library says, as one short line."""
    return " ".join(str(error).split())[:MAX_REASON] or type(error).__name__
