"""Encodings of text files: by byte order mark, by declaration, UTF-8, and Windows' own where it is none of these."""

import codecs
import re
from pathlib import Path
from typing import BinaryIO

from layflat.errors import InputError

_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"),
          (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))  # fmt: skip
_DECLARED = re.compile(
    rb"(?:coding|charset)\s*[:=]\s*[\"']?((?:utf|iso|latin|cp|windows|mac|ascii|us-ascii|gb|big5|shift|sjis|euc|koi)[-\w.]*)",
    re.IGNORECASE,
)
GARBAGE = 0.01  # fraction of control characters above which a file is binary; a serial port leaves a few
_BLOCK = 1 << 20  # bytes read at once
_HEAD = 4096  # bytes in which an encoding may be declared
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\r\f\v\x1a\x1b"))
WINDOWS = "cp1252"
FOREIGN = (
    (b"\x1f\x8b", "is compressed by gzip", "unpack it first: gunzip"),
    (b"pk\x03\x04", "is a workbook of a spreadsheet, or an archive", "save its sheet as CSV, or unpack it"),
    (b"\xd0\xcf\x11\xe0", "is a workbook of an old spreadsheet", "save its sheet as CSV"),
    (b'{"', "holds JSON", "write it as CSV: a header, and a row a sample"),
    (b"[{", "holds JSON", "write it as CSV: a header, and a row a sample"),
    (b"<html", "holds a page of HTML", "write its table as CSV"),
    (b"<!doctype", "holds a page of HTML", "write its table as CSV"),
    (b"<?xml", "holds XML", "write its table as CSV"),
)
"""Beginnings of files that hold no table of text, in small letters, with the message and the advice."""
RIGHT = "give a table of text, or a file that ends in .parquet, .nc or .mcap"


def encoding_of(path: Path) -> tuple[str, str]:
    """Return the encoding of a text file, and a note where it had to be guessed.

    Raises:
        InputError: it is not a text file, or one that holds no table.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
        for begins, what, right in FOREIGN:
            if head.lstrip().lower().startswith(begins):
                raise InputError(what, where=str(path), right=right)
        marked = next((name for mark, name in _MARKS if head.startswith(mark)), "") or _without_mark(head)
        if not marked and sum(byte in _CONTROLS for byte in head) > GARBAGE * len(head):
            raise InputError("is not a text file", where=str(path), right=RIGHT)
        declared = _DECLARED.search(b"\n".join(head.splitlines()[:3]))
        named = declared[1].decode() if declared else ""
        for encoding in filter(None, (marked, named, "utf-8")):
            if _decodes(file, encoding):
                return encoding, ""
    return WINDOWS, "is not UTF-8, and is read as Windows-1252: check names and units that are not ASCII"


def _without_mark(head: bytes) -> str:
    """Return the kind of UTF-16 of a text whose every other byte is null."""
    even, odd = head[0::2].count(0), head[1::2].count(0)
    half = max(len(head) // 2, 1)
    return "utf-16-le" if odd > 0.8 * half and not even else "utf-16-be" if even > 0.8 * half and not odd else ""


def _decodes(file: BinaryIO, encoding: str) -> bool:
    file.seek(0)
    try:
        decoder = codecs.getincrementaldecoder(encoding)()
        while block := file.read(_BLOCK):
            decoder.decode(block)
        decoder.decode(b"", final=True)
    except (UnicodeError, LookupError):
        return False
    return True
