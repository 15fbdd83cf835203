"""From an MCAP file that was cut short, or is to be closed, to a whole one with an index: whole messages are kept."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layflat.errors import InputError, OutputError
from layflat.files import whole_file
from layflat.rig.recorder import scan
from layflat.rig.recorder.file import synced
from layflat.rig.system import lock

if TYPE_CHECKING:
    from mcap.writer import Writer

PART, BROKEN = ".part", ".broken"

_MESSAGE = struct.Struct("<HIQQ")

Progress = Callable[[int, int], None]
"""Is told the bytes that are done, and all there are."""


@dataclass
class Kept:
    """What a file has given.

    Attributes:
        messages: that are kept.
        first: log time of the earliest, ns.
        last: log time of the latest, ns.
        lost: bytes that made no whole record.
        ended: whether the end of the data was there, so that nothing is missing behind it.
    """

    messages: int = 0
    first: int = 0
    last: int = 0
    lost: int = 0
    ended: bool = False

    @property
    def seconds(self) -> float:
        """From the first message to the last."""
        return (self.last - self.first) * 1e-9


def repair(path: Path, progress: Progress | None = None) -> tuple[Path, Kept] | None:
    """Make an MCAP file whole.

    NAME.mcap.part becomes NAME.mcap; any other keeps its name. The original is kept as NAME.mcap.broken.

    Args:
        path: of the file.
        progress: told how far it is.

    Returns:
        The whole file, and what it holds; None for a file that was whole, which is left alone.

    Raises:
        InputError: it is no MCAP file, or still being written.
        OutputError: the whole file can't be written.
    """
    place = path.with_name(path.name.removesuffix(PART))
    if scan.check_magic(path) and place == path and _intact(path):
        return None
    _check_not_written(path)
    if place != path and place.exists():
        right = f"it is {path.name} made whole, or another log: move one of them"
        raise OutputError("is there already", where=str(place), right=right)
    with whole_file(place) as temporary:
        kept = indexed(path, temporary, progress)
        path.rename(_free(place))
    return place, kept


def _intact(path: Path) -> bool:
    """Whether nothing is missing between the beginning and the end of a file's data."""
    scanned = scan.Scanned()
    for _ in scan.records(path, scanned):
        pass
    return scanned.ended and not scanned.lost


def _free(place: Path) -> Path:
    """A name for the original."""
    names = (place.with_name(f"{place.name}{BROKEN}{i or ''}") for i in range(1000))
    return next(name for name in names if not name.exists())


def _check_not_written(path: Path) -> None:
    with path.open("rb") as file:
        try:
            lock(file.fileno(), shared=True)
        except OSError:
            raise InputError("is being recorded", where=str(path), right="end the loop first") from None


def indexed(source: Path, target: Path, progress: Progress | None = None) -> Kept:
    """Write all that is whole in an MCAP file to another one, in compressed chunks with an index, and have it on disk.

    Raises:
        OutputError: it can't be written.
    """
    from mcap.writer import Writer  # noqa: PLC0415

    scanned = scan.Scanned()
    try:
        with target.open("wb") as out:
            copy = _Copy(Writer(out))
            for i, (kind, body) in enumerate(scan.records(source, scanned)):
                copy.take(kind, body)
                if progress is not None and i % 4096 == 0:
                    progress(scanned.place, scanned.size)
            copy.finish()
        synced(target)
    except OSError as error:
        right = "make room, or give another folder"
        raise OutputError(f"can't be written ({error.strerror})", where=str(target.parent), right=right) from None
    copy.kept.lost += scanned.lost
    copy.kept.ended = scanned.ended
    return copy.kept


class _Copy:
    """Records on their way to a new file."""

    def __init__(self, writer: Writer) -> None:
        self.kept = Kept()
        self._writer, self._started = writer, False
        self._schemas: dict[int, int] = {0: 0}
        self._channels: dict[int, int] = {}

    def take(self, kind: int, body: bytes) -> None:
        """Write a record, if it makes sense."""
        from mcap.exceptions import McapError  # noqa: PLC0415

        try:
            if kind == scan.MESSAGE:
                self._message(body)
            else:
                self._other(kind, body)
        except (McapError, struct.error, KeyError, UnicodeDecodeError):
            self.kept.lost += len(body)

    def finish(self) -> None:
        """Write the end."""
        self._start("", "layflat")
        self._writer.finish()

    def _start(self, profile: str, library: str) -> None:
        if not self._started:
            self._writer.start(profile, library)
            self._started = True

    def _message(self, body: bytes) -> None:
        channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(body)
        self._writer.add_message(self._channels[channel], log_time, body[_MESSAGE.size :], publish_time, sequence)
        kept = self.kept
        kept.first = min(kept.first, log_time) if kept.messages else log_time
        kept.last = max(kept.last, log_time)
        kept.messages += 1

    def _other(self, kind: int, body: bytes) -> None:
        from mcap import records  # noqa: PLC0415
        from mcap.data_stream import ReadDataStream  # noqa: PLC0415

        stream = ReadDataStream(BytesIO(body))
        if kind == scan.HEADER:
            header: Any = records.Header.read(stream)
            self._start(header.profile, header.library)
            return
        self._start("", "layflat")
        if kind == scan.SCHEMA:
            schema = records.Schema.read(stream)
            if schema.id not in self._schemas:
                self._schemas[schema.id] = self._writer.register_schema(schema.name, schema.encoding, schema.data)
        elif kind == scan.CHANNEL:
            told = records.Channel.read(stream)
            if told.id not in self._channels:
                self._channels[told.id] = self._writer.register_channel(
                    told.topic, told.message_encoding, self._schemas[told.schema_id], told.metadata
                )
        elif kind == scan.METADATA:
            metadata = records.Metadata.read(stream)
            self._writer.add_metadata(metadata.name, metadata.metadata)
        elif kind == scan.ATTACHMENT:
            one = records.Attachment.read(stream)
            self._writer.add_attachment(one.create_time, one.log_time, one.name, one.media_type, one.data)
