"""Repair of an MCAP file that was cut short, or is to be closed: its whole messages go into a new one with an index.

The official reader stops at the first record that is not whole, and reads nothing of a chunk that is cut short.
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
from layflat.rig.recorder.file import sync_path
from layflat.rig.system import lock_file

PART_SUFFIX, BROKEN_SUFFIX = ".part", ".broken"

MCAP_MAGIC = b"\x89MCAP0\r\n"
MESSAGE_OPCODE, CHUNK_OPCODE, DATA_END_OPCODE = 5, 6, 15
# Other records that hold data, by opcode; those not named here can be computed from these.
DATA_RECORD_NAMES = {1: "Header", 3: "Schema", 4: "Channel", 9: "Attachment", 12: "Metadata"}

_RECORD_HEADER, _MESSAGE_HEADER = struct.Struct("<BQ"), struct.Struct("<HIQQ")

Progress = Callable[[int, int], None]  # called with the bytes that are done, and the size of the file


@dataclass
class RepairSummary:
    """Progress and result of reading a file's records."""

    messages: int = 0
    first: int = 0  # log time of the earliest message, ns
    last: int = 0  # log time of the latest message, ns
    bytes_done: int = len(MCAP_MAGIC)  # bytes that are done
    size: int = 0  # bytes of the file
    lost: int = 0  # bytes that belong to no whole record
    ended: bool = False  # whether the record that ends the data was read, so that nothing is missing behind it

    def count_message(self, log_time: int) -> None:
        """Count a message with its log time, ns."""
        self.first = min(self.first, log_time) if self.messages else log_time
        self.last = max(self.last, log_time)
        self.messages += 1

    @property
    def seconds(self) -> float:
        """Return the time from the first message to the last, s."""
        return (self.last - self.first) * 1e-9


def repair(path: Path, progress: Progress | None = None) -> tuple[Path, RepairSummary] | None:
    """Repair an MCAP file.

    NAME.mcap.part becomes NAME.mcap; any other keeps its name. The original is kept as NAME.mcap.broken.

    Returns:
        Path and content of the repaired file; None for a file that was whole, which is left alone.

    Raises:
        InputError: it is not an MCAP file, or still being written.
        OutputError: the whole file can't be written.
    """
    place, checked = path.with_name(path.name.removesuffix(PART_SUFFIX)), RepairSummary()
    if check_magic(path) and place == path:
        for _ in read_records(path, checked):
            pass
        if checked.ended and not checked.lost:
            return None
    try:
        with path.open("rb") as file:
            lock_file(file.fileno(), shared=True)
    except OSError:
        raise InputError("is being recorded", where=str(path), right="end the loop first") from None
    if place != path and place.exists():
        right = f"it is {path.name} made whole, or another log: move one of them"
        raise OutputError("is there already", where=str(place), right=right)
    with whole_file(place, owned=True) as temporary:
        kept = write_indexed(path, temporary, progress)
        names = (place.with_name(f"{place.name}{BROKEN_SUFFIX}{i or ''}") for i in range(1000))
        path.rename(next(name for name in names if not name.exists()))
    return place, kept


def check_magic(path: Path) -> bool:
    """Return whether a file ends as MCAP files do; raise InputError if it can't be read, or does not begin as one."""
    right = "give an MCAP file, as `layflat rig` records it"
    try:
        with path.open("rb") as file:
            head, size = file.read(len(MCAP_MAGIC)), file.seek(0, 2)
            file.seek(max(0, size - len(MCAP_MAGIC)))
            tail = file.read()
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=str(path), right=right) from None
    if head != MCAP_MAGIC:
        raise InputError("is not an MCAP file" if head else "is empty", where=str(path), right=right)
    return size >= 2 * len(MCAP_MAGIC) and tail == MCAP_MAGIC


def write_indexed(source: Path, target: Path, progress: Progress | None = None) -> RepairSummary:
    """Copy the whole records of an MCAP file to another one, in compressed chunks with an index, and sync it to disk.

    Invalid records are left out; the summary that is returned counts their bytes as lost.

    Args:
        source: file that may be cut short.
        target: file that is written.
        progress: called now and then with the bytes that are done, and the size of the source.

    Raises:
        OSError: the target can't be written.
    """
    from mcap.exceptions import McapError  # noqa: PLC0415

    kept = RepairSummary()
    with target.open("wb") as out:
        copy = _Copy(out)
        for i, (kind, body) in enumerate(read_records(source, kept)):
            try:
                if kind == MESSAGE_OPCODE:
                    kept.count_message(copy.add_message(body))
                else:
                    copy.add(kind, body)
            except (McapError, struct.error, KeyError, UnicodeDecodeError):
                kept.lost += len(body)
            if progress is not None and i % 4096 == 0:
                progress(kept.bytes_done, kept.size)
        copy.finish()
    sync_path(target)
    return kept


class _Copy:
    """Copy of a file, in which schemas and channels get new numbers."""

    def __init__(self, out: IO[bytes]) -> None:
        from mcap.writer import Writer  # noqa: PLC0415

        self._writer, self._started = Writer(out), False
        self._schemas: dict[int, int] = {0: 0}
        self._channels: dict[int, int] = {}

    def add_message(self, body: bytes) -> int:
        """Write a message and return its log time, ns."""
        channel, sequence, log_time, publish_time = _MESSAGE_HEADER.unpack_from(body)
        self._writer.add_message(
            self._channels[channel], log_time, body[_MESSAGE_HEADER.size :], publish_time, sequence
        )
        return int(log_time)

    def add(self, kind: int, body: bytes) -> None:
        """Write any other record, if it holds data; raise errors of many kinds where it is invalid."""
        from mcap import records  # noqa: PLC0415
        from mcap.data_stream import ReadDataStream  # noqa: PLC0415

        if kind not in DATA_RECORD_NAMES:
            return
        writer, name = self._writer, DATA_RECORD_NAMES[kind]
        record: Any = getattr(records, name).read(ReadDataStream(BytesIO(body)))
        if name == "Header":
            self._start(record.profile, record.library)
            return
        self._start()
        if name == "Schema" and record.id not in self._schemas:
            self._schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
        elif name == "Channel" and record.id not in self._channels:
            schema = self._schemas[record.schema_id]
            self._channels[record.id] = writer.register_channel(
                record.topic, record.message_encoding, schema, record.metadata
            )
        elif name == "Metadata":
            writer.add_metadata(record.name, record.metadata)
        elif name == "Attachment":
            writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)

    def finish(self) -> None:
        """Write the end."""
        self._start()
        self._writer.finish()

    def _start(self, profile: str = "", library: str = "layflat") -> None:
        """Write the header, unless that has been done."""
        if not self._started:
            self._writer.start(profile, library)
            self._started = True


def read_records(path: Path, kept: RepairSummary) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and content of the records outside and inside of chunks, in the file's order, up to its data's end.

    A computer that loses power may leave zeros in place of the last data: a record that ends in zeros which go on to
    the end of the file is not whole. Progress and lost bytes are written to `kept`.
    """
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        kept.size = len(data)
        for kind, body, end in _split_records(data, kept.bytes_done):
            cut = end > kept.size
            if kind == DATA_END_OPCODE and not cut:
                kept.ended = True
                return
            if kind == CHUNK_OPCODE:
                yield from _read_chunk(body, cut, kept)
            elif kind == 0 or cut or (data[end - 1 : end + 1] == b"\0\0" and not any(data[end:])):
                break
            else:
                yield kind, body
            kept.bytes_done = min(end, kept.size)
        kept.lost += kept.size - kept.bytes_done


def _split_records(data: mmap.mmap | bytes, place: int) -> Iterator[tuple[int, bytes, int]]:
    """Yield opcode, content and end of one record after the other; the last content is cut where the data end."""
    while place + _RECORD_HEADER.size <= len(data):
        kind, length = _RECORD_HEADER.unpack_from(data, place)
        begin, place = place + _RECORD_HEADER.size, place + _RECORD_HEADER.size + length
        yield kind, data[begin:place], place


def _read_chunk(body: bytes, cut: bool, kept: RepairSummary) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and content of a chunk's records; of one that is `cut` short, as many as can be decompressed.

    Bytes that can't be read, or all of a chunk with a wrong checksum, are counted in `kept.lost`.
    """
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
    for kind, content, end in _split_records(inside, place):
        if end > len(inside):
            break
        yield kind, content
        place = end
    kept.lost += len(inside) - place
