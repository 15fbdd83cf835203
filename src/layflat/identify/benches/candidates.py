"""Many candidates at once: a description with an item a candidate in place of some numbers, and runs of all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from layflat.description import Part
from layflat.description.change import replaced
from layflat.identify.model import Array
from layflat.lanes import mapped
from layflat.parallel import on_all_cores

Described = TypeVar("Described", bound=Part)


def with_columns(described: Described, found: Mapping[str, Any]) -> Described:
    """A description with numbers, or arrays of an item a candidate, at some paths; unchecked, as a search goes far."""
    for path, column in found.items():
        described = replaced(described, path.split("."), column)
    return described


def simulated(
    run: Callable[..., None], count: int, cases: Sequence[tuple[Any, ...]], shapes: Sequence[tuple[int, ...]]
) -> list[Array]:
    """Run every candidate in every case, on all cores.

    Args:
        run: a kernel; it takes the parameters of one candidate, what is given of a case, and room for its results.
        count: of candidates.
        cases: of each its parameters (named tuples of numbers, or of arrays with an item a candidate), then what is
            given of it.
        shapes: of the room of each case.

    Returns:
        Results of each case, (candidates, *shape), not numbers where `run` wrote none.
    """
    rooms = [np.full((count, *shape), np.nan) for shape in shapes]

    def work(job: tuple[int, int]) -> None:
        case, i = job
        parameters, *given = cases[case]
        run(mapped(parameters, lambda leaf: float(leaf[i] if np.ndim(leaf) else leaf)), *given, rooms[case][i])

    on_all_cores(work, [(case, i) for case in range(len(cases)) for i in range(count)])
    return rooms
