"""Names of things, which become names of files and keys of paths."""

import re
from collections.abc import Callable
from itertools import count
from typing import Annotated

from pydantic import AfterValidator

from layflat.description.wrong import shown, wrong
from layflat.errors import InputError

LONGEST = 100  # bytes in UTF-8; file systems take 255, suffixes included

_FILE = re.compile(r"[^\W_][\w +()\[\].,=@-]*(?<![ .])")
_KEY = re.compile(r"[^\W_][\w +()-]*(?<! )")
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)

_RIGHT = "begin with a letter or a digit, and use letters, digits, spaces and - _ + ( )"


def problem(name: str, *, key: bool = False) -> str | None:
    """Return what is wrong with a name that becomes a file's name or, as a `key`, part of a dotted path."""
    if not name:
        return "is empty"
    if len(name.encode(errors="replace")) > LONGEST:
        return f"has more than {LONGEST} bytes"
    if not name.isprintable() or not (_KEY if key else _FILE).fullmatch(name):
        return "can't be a name"
    return "is reserved by some systems" if _RESERVED.fullmatch(name) else None


def unused_name(name: str, is_used: Callable[[str], bool]) -> str:
    """Return a name that is not used yet: the name itself, else NAME-2, NAME-3, and so on."""
    if not is_used(name):
        return name
    return next(other for n in count(2) if not is_used(other := f"{name}-{n}"))


def file_name(name: str, where: str) -> str:
    """Return a name that may become a file's name: in no other folder, on every system.

    Raises:
        InputError: naming `where` it was given.
    """
    found = problem(name) if isinstance(name, str) else "is no text"
    if found is not None:
        raise InputError(f"{shown(name)} {found}", where=where, right=_RIGHT)
    return name


def _checked_name(name: str) -> str:
    found = problem(name)
    if found is not None:
        raise wrong(found, _RIGHT, name)
    return name


def _checked_key(name: str) -> str:
    found = problem(name, key=True)
    if found is not None:
        raise wrong(found, _RIGHT, name)
    return name


Name = Annotated[str, AfterValidator(_checked_name)]  # of something that results are written for, under this name

Key = Annotated[str, AfterValidator(_checked_key)]
"""Of one of several things in a table, such as a joint; it is part of dotted paths and of options."""
