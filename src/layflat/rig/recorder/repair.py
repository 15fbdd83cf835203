"""From an MCAP file that was cut short, or is to be closed, to a whole one with an index: whole messages are kept.

The official reader gives up at the first record that is not whole, and takes nothing of a chunk that is cut short.
"""

import mmap
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import IO, Any

from layflat.errors import InputError, OutputError
from layflat.files import whole_file
from layflat.rig.recorder.file import synced
from layflat.rig.system import lock

PART, BROKEN = ".part", ".broken"

MAGIC = b"\x89MCAP0\r\n"
MESSAGE, CHUNK, DATA_END = 5, 6, 15
# Other kinds of records that hold data; all that are not named here can be made from these.
OTHERS = {1: "Header", 3: "Schema", 4: "Channel", 9: "Attachment", 12: "Metadata"}

_RECORD, _MESSAGE = struct.Struct("<BQ"), struct.Struct("<HIQQ")

Progress = Callable[[int, int], None]  # is told the bytes that are done, and all there are


@dataclass
class Kept:
    """What a file has given so far."""

    messages: int = 0
    first: int = 0  # log time of the earliest message, ns
    last: int = 0
    place: int = len(MAGIC)  # bytes that are done
    size: int = 0
    lost: int = 0  # bytes that made no whole record
    ended: bool = False  # whether the end of the data was found where it belongs, so that nothing is missing behind it

    def note(self, log_time: int) -> None:
        """A message was kept."""
        self.first = min(self.first, log_time) if self.messages else log_time
        self.last = max(self.last, log_time)
        self.messages += 1

    @property
    def seconds(self) -> float:
        """From the first message to the last."""
        return (self.last - self.first) * 1e-9


def repair(path: Path, progress: Progress | None = None) -> tuple[Path, Kept] | None:
    """Make an MCAP file whole; return it and what it holds, or None for a file that was whole, which is left alone.

    NAME.mcap.part becomes NAME.mcap; any other keeps its name. The original is kept as NAME.mcap.broken.

    Raises:
        InputError: it is not an MCAP file, or still being written.
        OutputError: the whole file can't be written.
    """
    place, looked = path.with_name(path.name.removesuffix(PART)), Kept()
    if check_magic(path) and place == path:
        for _ in records(path, looked):
            pass
        if looked.ended and not looked.lost:
            return None
    try:
        with path.open("rb") as file:
            lock(file.fileno(), shared=True)
    except OSError:
        raise InputError("is being recorded", where=str(path), right="end the loop first") from None
    if place != path and place.exists():
        right = f"it is {path.name} made whole, or another log: move one of them"
        raise OutputError("is there already", where=str(place), right=right)
    with whole_file(place, owned=True) as temporary:
        kept = indexed(path, temporary, progress)
        names = (place.with_name(f"{place.name}{BROKEN}{i or ''}") for i in range(1000))
        path.rename(next(name for name in names if not name.exists()))
    return place, kept


def check_magic(path: Path) -> bool:
    """Whether a file ends as an MCAP file does; raise InputError if it can't be read, or does not even begin as one."""
    right = "give an MCAP file, as `layflat rig` records it"
    try:
        with path.open("rb") as file:
            head, size = file.read(len(MAGIC)), file.seek(0, 2)
            file.seek(max(0, size - len(MAGIC)))
            tail = file.read()
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=str(path), right=right) from None
    if head != MAGIC:
        raise InputError("is not an MCAP file" if head else "is empty", where=str(path), right=right)
    return size >= 2 * len(MAGIC) and tail == MAGIC


def indexed(source: Path, target: Path, progress: Progress | None = None) -> Kept:
    """Write all that is whole in an MCAP file to another one, in compressed chunks with an index, and have it on disk.

    Raise OSError if it can't be written.
    """
    from mcap.exceptions import McapError  # noqa: PLC0415

    kept = Kept()
    with target.open("wb") as out:
        copy = _Copy(out)
        for i, (kind, body) in enumerate(records(source, kept)):
            try:
                if kind == MESSAGE:
                    kept.note(copy.add_message(body))
                else:
                    copy.add(kind, body)
            except (McapError, struct.error, KeyError, UnicodeDecodeError):
                kept.lost += len(body)
            if progress is not None and i % 4096 == 0:
                progress(kept.place, kept.size)
        copy.finish()
    synced(target)
    return kept


class _Copy:
    """A new file; its writer gives schemas and channels numbers of its own."""

    def __init__(self, out: IO[bytes]) -> None:
        from mcap.writer import Writer  # noqa: PLC0415

        self._writer, self._started = Writer(out), False
        self._schemas: dict[int, int] = {0: 0}
        self._channels: dict[int, int] = {}

    def add_message(self, body: bytes) -> int:
        """Write a message; returns its log time, ns."""
        channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(body)
        self._writer.add_message(self._channels[channel], log_time, body[_MESSAGE.size :], publish_time, sequence)
        return int(log_time)

    def add(self, kind: int, body: bytes) -> None:
        """Write any other record, if it holds data; errors of all kinds where it makes no sense."""
        from mcap import records  # noqa: PLC0415
        from mcap.data_stream import ReadDataStream  # noqa: PLC0415

        if kind not in OTHERS:
            return
        writer, name = self._writer, OTHERS[kind]
        one: Any = getattr(records, name).read(ReadDataStream(BytesIO(body)))
        if name == "Header":
            self._start(one.profile, one.library)
            return
        self._start()
        if name == "Schema" and one.id not in self._schemas:
            self._schemas[one.id] = writer.register_schema(one.name, one.encoding, one.data)
        elif name == "Channel" and one.id not in self._channels:
            schema = self._schemas[one.schema_id]
            self._channels[one.id] = writer.register_channel(one.topic, one.message_encoding, schema, one.metadata)
        elif name == "Metadata":
            writer.add_metadata(one.name, one.metadata)
        elif name == "Attachment":
            writer.add_attachment(one.create_time, one.log_time, one.name, one.media_type, one.data)

    def finish(self) -> None:
        """Write the end."""
        self._start()
        self._writer.finish()

    def _start(self, profile: str = "", library: str = "layflat") -> None:
        if not self._started:
            self._writer.start(profile, library)
            self._started = True


def records(path: Path, kept: Kept) -> Iterator[tuple[int, bytes]]:
    """Kind and content of the records outside and inside of chunks, in the file's order, up to the end of its data.

    A machine that loses power may leave zeros in place of what was written last: a record that runs into zeros, which
    go on behind it to the end of the file, is not whole. How far it is, and what is lost, is told to `kept`.
    """
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        kept.size = len(data)
        for kind, body, end in _framed(data, kept.place):
            cut = end > kept.size
            if kind == DATA_END and not cut:
                kept.ended = True
                return
            if kind == CHUNK:
                yield from _in_chunk(body, cut, kept)
            elif kind == 0 or cut or (data[end - 1 : end + 1] == b"\0\0" and not any(data[end:])):
                break
            else:
                yield kind, body
            kept.place = min(end, kept.size)
        kept.lost += kept.size - kept.place


def _framed(data: mmap.mmap | bytes, place: int) -> Iterator[tuple[int, bytes, int]]:
    """Kind, content and end of one record after the other; the content of the last is cut where the data end."""
    while place + _RECORD.size <= len(data):
        kind, length = _RECORD.unpack_from(data, place)
        begin, place = place + _RECORD.size, place + _RECORD.size + length
        yield kind, data[begin:place], place


def _in_chunk(body: bytes, cut: bool, kept: Kept) -> Iterator[tuple[int, bytes]]:
    """Records of a chunk; of one that is cut short, as many as can be unpacked."""
    import lz4.frame  # noqa: PLC0415
    import zstandard  # noqa: PLC0415
    from mcap.data_stream import ReadDataStream  # noqa: PLC0415
    from mcap.exceptions import McapError  # noqa: PLC0415
    from mcap.records import Chunk  # noqa: PLC0415

    unpack = {
        "": bytes,
        "lz4": lambda data: lz4.frame.LZ4FrameDecompressor().decompress(data),
        "zstd": lambda data: zstandard.ZstdDecompressor().decompressobj().decompress(data),
    }
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(body)))
        inside = unpack[chunk.compression](chunk.data)
        if not cut and chunk.uncompressed_crc not in {0, zlib.crc32(inside)}:
            raise ValueError("another checksum")
    except (McapError, zstandard.ZstdError, RuntimeError, ValueError, KeyError, struct.error):
        kept.lost += len(body)
        return
    place = 0
    for kind, content, end in _framed(inside, place):
        if end > len(inside):
            break
        yield kind, content
        place = end
    kept.lost += len(inside) - place
