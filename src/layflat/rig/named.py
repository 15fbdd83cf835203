"""Named tuples of numbers as rows of arrays that stay in place: rows for the compiler, columns by name for Python."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.lanes import leaves


def leaf_names(like: Any, prefix: str = "") -> Iterator[str]:
    """Yield the names of a nested tuple's numbers in order, such as "gate.working"; unnamed items count from 0."""
    for name, item in zip(getattr(like, "_fields", range(len(like))), like, strict=True):
        if isinstance(item, tuple):
            yield from leaf_names(item, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}"


def zero_tuple(kind: Any) -> Any:
    """Return a named tuple of a class with all numbers zero, nested named tuples included."""
    return kind(*(zero_tuple(item) if hasattr(item, "_fields") else 0.0 for item in kind.__annotations__.values()))


def leaf_offsets(like: Any) -> Any:
    """Return the offset of each item of a named tuple in a row of its numbers, as a tuple of the same class."""
    counts = [len(list(leaves(item))) if isinstance(item, tuple) else 1 for item in like]
    return type(like)(*(sum(counts[:i]) for i in range(len(counts))))


def offset_of(like: Any, name: str) -> int:
    """Return the offset of a number, such as "gate.working", in a row of a nested named tuple's numbers."""
    return list(leaf_names(like)).index(name)


class NamedRows:
    """Array of rows, each the numbers of a nested named tuple; all rows are of one class."""

    def __init__(self, rows: list[Any]) -> None:
        self.like = rows[0]
        self.array: Array = np.array([list(leaves(row)) for row in rows], dtype=float)
        self._columns = {name: i for i, name in enumerate(leaf_names(self.like))}

    def __getitem__(self, name: str) -> Array:
        """Return a view of the column of a name, (rows,)."""
        return self.array[:, self._columns[name]]

    def replace(self, part: str, value: Any, row: int | slice = slice(None)) -> None:
        """Write the numbers of a tuple into a part of one row or of all.

        Args:
            part: name of the field of the outer tuple.
            value: tuple of the part's class.
            row: index of the row, or a slice; default: all rows.
        """
        first, numbers = getattr(leaf_offsets(self.like), part), list(leaves(value))
        self.array[row, first : first + len(numbers)] = numbers
