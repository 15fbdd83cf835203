"""Where pictures go: the suffix of a path says what is written there."""

from __future__ import annotations

from pathlib import Path

from layflat.errors import OutputError


def of_kind(path: Path, *suffixes: str) -> str:
    """The suffix of a path, one of those given.

    Raises:
        OutputError: it has another.
    """
    suffix = path.suffix.lower()
    if suffix not in suffixes:
        raise OutputError(
            f"{path.suffix!r} is no kind of file that is written here" if suffix else "has no suffix",
            where=str(path),
            right=f"give a path that ends in {' or '.join(suffixes)}",
        )
    return suffix
