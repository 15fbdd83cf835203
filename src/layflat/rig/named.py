"""Numbers of named tuples in arrays that stay in place: rows for the compiler, columns by name for everything else."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.lanes import leaves


def leaf_names(like: Any, prefix: str = "") -> Iterator[str]:
    """Names of a nested tuple's numbers in order, such as "gate.working"; items without a name count from 0."""
    for name, item in zip(getattr(like, "_fields", range(len(like))), like, strict=True):
        if isinstance(item, tuple):
            yield from leaf_names(item, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}"


def blank(kind: Any) -> Any:
    """A named tuple of a kind, and all named tuples in it, of zeros."""
    return kind(*(blank(item) if hasattr(item, "_fields") else 0.0 for item in kind.__annotations__.values()))


def places(like: Any) -> Any:
    """Where each item of a named tuple begins in a row of its numbers, as a tuple of the same kind."""
    counts = [len(list(leaves(item))) if isinstance(item, tuple) else 1 for item in like]
    return type(like)(*(sum(counts[:i]) for i in range(len(counts))))


class NamedRows:
    """Rows of numbers, each those of a named tuple; made from nested tuples of one kind."""

    def __init__(self, rows: list[Any]) -> None:
        self.like = rows[0]
        self.array: Array = np.array([list(leaves(row)) for row in rows], dtype=float)
        self._columns = {name: i for i, name in enumerate(leaf_names(self.like))}

    def __getitem__(self, name: str) -> Array:
        """The numbers of one name, (rows,); a view."""
        return self.array[:, self._columns[name]]

    def replace(self, part: str, value: Any, row: int | slice = slice(None)) -> None:
        """Put the numbers of a tuple into a part, in one row or all."""
        first, numbers = getattr(places(self.like), part), list(leaves(value))
        self.array[row, first : first + len(numbers)] = numbers
