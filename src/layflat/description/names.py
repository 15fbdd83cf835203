"""Names in descriptions, which become names of files and keys of paths."""

import re
from collections.abc import Callable
from itertools import count
from typing import Annotated

from pydantic import AfterValidator

from layflat.description.wrong import shown, value_error
from layflat.errors import InputError

MAX_NAME_BYTES = 100  # bytes in UTF-8; file systems take 255, suffixes included

_FILE_PATTERN = re.compile(r"[^\W_][\w +()\[\].,=@-]*(?<![ .])")
_KEY_PATTERN = re.compile(r"[^\W_][\w +()-]*(?<! )")
_RESERVED_PATTERN = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)

_NAME_ADVICE = "begin with a letter or a digit, and use letters, digits, spaces and - _ + ( )"


def problem(name: str, *, key: bool = False) -> str | None:
    """Return the problem of a name that is to be a file's name or, as a `key`, part of a dotted path; None if valid."""
    if not name:
        return "is empty"
    if len(name.encode(errors="replace")) > MAX_NAME_BYTES:
        return f"has more than {MAX_NAME_BYTES} bytes"
    if not name.isprintable() or not (_KEY_PATTERN if key else _FILE_PATTERN).fullmatch(name):
        return "can't be a name"
    return "is reserved by some systems" if _RESERVED_PATTERN.fullmatch(name) else None


def unused_name(name: str, is_used: Callable[[str], bool]) -> str:
    """Return an unused name: the name itself, else NAME-2, NAME-3, and so on."""
    if not is_used(name):
        return name
    return next(other for n in count(2) if not is_used(other := f"{name}-{n}"))


def file_name(name: str, where: str) -> str:
    """Return a name that is valid as a file's name on every system, without a folder.

    Raises:
        InputError: naming `where`: it is not valid.
    """
    flaw = problem(name) if isinstance(name, str) else "is no text"
    if flaw is not None:
        raise InputError(f"{shown(name)} {flaw}", where=where, right=_NAME_ADVICE)
    return name


def _check_name(name: str) -> str:
    """Return a name that is valid as a file's name; raise `value_error` for others."""
    flaw = problem(name)
    if flaw is not None:
        raise value_error(flaw, _NAME_ADVICE, name)
    return name


def _check_key(name: str) -> str:
    """Return a name that is valid as a key in dotted paths; raise `value_error` for others."""
    flaw = problem(name, key=True)
    if flaw is not None:
        raise value_error(flaw, _NAME_ADVICE, name)
    return name


Name = Annotated[str, AfterValidator(_check_name)]  # of a description, and so of the files of its results

Key = Annotated[str, AfterValidator(_check_key)]
"""Name of one of several items in a table, such as a joint; it is part of dotted paths and of options."""
