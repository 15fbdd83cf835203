"""Numbers of nested tuples in order: what a machine's parameters go through on the way to a kernel and back."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.lanes import Like, leaves, mapped, read_numbers, write_numbers
from layflat.machine import load, names, parameters


class Pair(NamedTuple):
    """Two of anything."""

    first: Any
    second: Any


numbers = st.floats(-1e6, 1e6)
trees = st.recursive(
    numbers, lambda below: st.builds(Pair, below, below) | st.tuples(below, below, below), max_leaves=12
)


def shape(tree: Any) -> Any:
    """A tree without its numbers."""
    return (type(tree), *map(shape, tree)) if isinstance(tree, tuple) else None


@given(trees)
def test_to_map_keeps_the_tree_and_its_order(tree: Any) -> None:
    doubled = mapped(tree, lambda number: 2.0 * number)
    assert shape(doubled) == shape(tree)
    assert list(leaves(doubled)) == [2.0 * number for number in leaves(tree)]
    assert mapped(tree, lambda number: number) == tree


@given(trees)
def test_what_is_written_is_read_again(tree: Any) -> None:
    row = np.full(len(list(leaves(tree))) + 1, np.nan)
    write_numbers(row, tree)
    assert list(row[:-1]) == list(leaves(tree))
    assert np.isnan(row[-1])
    like = mapped(tree, lambda _: 0.0)
    assert read_numbers(like, row) == read_numbers(Like.from_tuple(tree), row) == tree


@given(trees, trees)
def test_tuples_that_look_alike_have_the_same_like(one: Any, other: Any) -> None:
    assert (Like.from_tuple(one) is Like.from_tuple(other)) == (shape(one) == shape(other))
    assert Like.from_tuple(mapped(one, round)) is Like.from_tuple(mapped(one, lambda number: np.ones(3) * number))


@pytest.mark.parametrize("name", names())
def test_parameters_of_every_machine_are_numbers_all_through(name: str) -> None:
    machine = load(name)
    case: tuple[Any, ...] = (parameters.arm(machine), parameters.surroundings(machine))
    if machine.valve is not None:
        case += (parameters.joints(machine),)
    found = list(leaves(case))
    assert len(found) > 8
    assert all(isinstance(number, (int, float)) and not np.isnan(number) for number in found)
    row = np.array(found, dtype=float)
    assert read_numbers(mapped(case, float), row) == mapped(case, float)
