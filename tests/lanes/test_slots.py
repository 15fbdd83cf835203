from typing import Any, NamedTuple

import numpy as np
import pytest

from layflat.jit import composition, kernel
from layflat.lanes import in_lanes, read_lanes, slots, width, write_lanes
from layflat.registers import host_width


class Pair(NamedTuple):
    """Two numbers."""

    x: float
    y: float


@composition
def swap(places: Any) -> None:
    """Exchange two items in place, in a function of its own."""
    places[0], places[1] = places[1], places[0]


@kernel
def turned(pairs: Any, times: int) -> Any:
    items, counts = slots(pairs), slots(pairs, 0.0)
    for k in range(times):
        for j in range(len(items)):
            items[j] = Pair(items[j].y, items[j].x + k)
            counts[j] = counts[j] + j
        swap(items)
    return items[0], items[1], counts[0], counts[1]


@pytest.mark.parametrize("times", [0, 1, 5])
def test_they_are_lists_of_fixed_length(times: int) -> None:
    pairs = (Pair(1.0, 2.0), Pair(3.0, 4.0))
    items = list(pairs)
    for k in range(times):
        items = [Pair(item.y, item.x + k) for item in reversed(items)]
    assert turned(pairs, times) == (*items, 0.0, float(times))
    assert slots(pairs, 7.0) == [7.0, 7.0]


@kernel
def through_slots(block: Any, out: Any) -> int:
    row = read_lanes(Pair(0.0, 0.0), block)
    places = slots((0.0, 0.0, 0.0), in_lanes(Pair(1.0, 2.0), row.x))
    places[1] = row
    for j in range(len(places)):
        write_lanes(out[2 * j : 2 * j + 2], places[j])
    return width(row.x)


def test_they_hold_lanes() -> None:
    lanes = host_width()
    block, out = np.arange(2.0 * lanes).reshape(2, lanes), np.zeros((6, lanes))
    assert through_slots(block, out) == lanes
    assert np.array_equal(out[2:4], block)
    assert out[[0, 1, 4, 5], 0].tolist() == [1.0, 2.0, 1.0, 2.0]


def test_teaching_the_compiler_leaves_the_names_of_the_room_alone() -> None:
    import layflat.jit.lanes

    public = {name: value for name, value in vars(layflat.lanes).items() if callable(value) and name[0] != "_"}
    own = {name for name, value in public.items() if value.__module__ == "layflat.lanes"}
    assert {"each", "gather", "join", "halves", "leaves", "read_numbers", "select", "slots", "total", "width"} <= own
