from math import floor, sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.jit import composition, kernel, law
from layflat.lanes import (
    Lanes,
    Like,
    abreast,
    anywhere,
    apart,
    each,
    epsilon,
    halves,
    in_lanes,
    join,
    lane_by_lane,
    packed,
    read_lanes,
    read_numbers,
    select,
    unpacked,
    width,
    write_lanes,
    write_numbers,
    write_row,
)
from layflat.registers import host_width

numbers = st.floats(-1e3, 1e3, allow_subnormal=False)
fours = st.tuples(numbers, numbers, numbers, numbers)


class Pair(NamedTuple):
    """Two numbers, as laws take them."""

    x: float
    y: float


@law
def everything(pair: Any, c: Any) -> Any:
    """All that laws may do, of lanes and of numbers."""
    x, y = pair.x, pair.y
    inside = ((x < y) & (x >= -c)) | (y == x)
    ratio = -x / (1.0 + abs(y)) + 2 * y
    return Pair(select(inside, sqrt(abs(x)), ratio), min(max(x, -1.0), y)), select(x > c, 1.0, y - c)


@composition
def lined_up(a: Any, b: Any) -> Any:
    return join(join(Pair(a[0], b[0]), Pair(a[1], b[1])), join(Pair(a[2], b[2]), Pair(a[3], b[3])))


@kernel
def by_lanes(a: Any, b: Any, c: float) -> Any:
    return everything(lined_up(a, b), c)


@kernel
def one_by_one(a: Any, b: Any, c: float) -> Any:
    low, high = halves(lined_up(a, b))
    first, second = halves(low)
    third, fourth = halves(high)
    return everything(first, c), everything(second, c), everything(third, c), everything(fourth, c)


@given(fours, fours, numbers)
def test_each_lane_is_bit_for_bit_the_scalar_law(a: tuple[float, ...], b: tuple[float, ...], c: float) -> None:
    (x, y), z = by_lanes(a, b, c)
    assert (len(x), type(x)) == (4, Lanes)
    assert [((x[i], y[i]), z[i]) for i in range(4)] == list(one_by_one(a, b, c))
    assert [((x[i], y[i]), z[i]) for i in range(4)] == [everything(Pair(a[i], b[i]), c) for i in range(4)]


@given(fours, fours, numbers)
def test_the_interpreter_agrees(a: tuple[float, ...], b: tuple[float, ...], c: float) -> None:
    scalar = getattr(everything, "py_func", getattr(everything, "__wrapped__", everything))
    pair = join(join(Pair(a[0], b[0]), Pair(a[1], b[1])), join(Pair(a[2], b[2]), Pair(a[3], b[3])))
    assert lane_by_lane(scalar)(pair, c) == by_lanes(a, b, c)


@given(fours)
def test_arithmetic_of_lanes_in_the_interpreter(a: tuple[float, ...]) -> None:
    lanes: Any = Lanes(a)
    assert 2.0 * lanes - lanes == lanes
    assert -(1.0 - lanes) == lanes - 1.0
    assert lanes / 2.0 + lanes / 2.0 == lanes
    assert (lanes + lanes) / Lanes([2.0] * 4) == lanes


def test_joining_and_parting() -> None:
    joined = join(Pair(1.0, 2.0), Pair(3.0, 4.0))
    assert joined == Pair(Lanes((1.0, 3.0)), Lanes((2.0, 4.0)))  # type: ignore[arg-type]
    assert halves(join(joined, joined)) == (joined, joined)
    assert halves(joined) == (Pair(1.0, 2.0), Pair(3.0, 4.0))


@kernel
def there_and_back(items: Any) -> Any:
    beside = abreast(items)
    return apart(everything(beside, 0.5), items)


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8])
def test_any_number_of_items_stand_abreast(count: int) -> None:
    items = tuple(Pair(0.3 * i - 1.0, 2.0 - 0.7 * i) for i in range(count))
    assert apart(abreast(items), items) == items
    assert there_and_back(items) == tuple(everything(item, 0.5) for item in items)


def test_lanes_stand_abreast_too() -> None:
    low, high = Lanes((1.0, 2.0)), Lanes((3.0, 4.0))
    assert abreast((low, high)) == Lanes((1.0, 2.0, 3.0, 4.0))
    assert apart(abreast((low, high)), (low, high)) == (low, high)


@law
def weighted(pair: Any, by: float) -> Any:
    return Pair(by * pair.x, pair.y - by)


@kernel
def all_weighted(items: Any, by: float) -> Any:
    return unpacked(each(weighted, packed(items), by), items)


@kernel
def both_weighted(a: Any, b: Any, by: float) -> Any:
    pairs = lined_up(a, b), lined_up(b, a)
    return unpacked(each(weighted, packed(pairs), by), pairs)


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_single_numbers_are_packed_into_one(count: int) -> None:
    items = tuple(Pair(0.3 * i - 1.0, 2.0 - 0.7 * i) for i in range(count))
    assert len(packed(items)) == 1
    assert all_weighted(items, 3.0) == tuple(weighted(item, 3.0) for item in items)


@given(fours, fours, numbers)
def test_lanes_are_packed_as_they_are(a: tuple[float, ...], b: tuple[float, ...], by: float) -> None:
    pairs = lined_up(a, b), lined_up(b, a)
    assert packed(pairs) == pairs
    assert both_weighted(a, b, by) == tuple(weighted(pair, by) for pair in pairs)


@kernel
def any_left(a: Any, b: Any) -> Any:
    pair = lined_up(a, b)
    return anywhere(pair.x), anywhere(pair.x - pair.y), anywhere(a[0])


@given(st.tuples(*[st.sampled_from([0.0, -0.0, 1.5])] * 4))
def test_what_is_in_any_lane_is_anywhere(a: tuple[float, ...]) -> None:
    assert any_left(a, a) == (any(a), False, a[0] != 0.0)
    assert (anywhere(lined_up(a, a).x), anywhere(a[0])) == (any(a), a[0] != 0.0)


def test_lanes_of_unequal_number_do_not_mix() -> None:
    with pytest.raises(ValueError, match="unpack"):
        lane_by_lane(max)(Lanes((1.0, 2.0)), Lanes((1.0, 2.0, 3.0, 4.0)))


@kernel
def filled(rows: Any, pair: Any) -> None:
    for i in range(2):
        for j in range(3):
            write_row(rows, i, j, Pair(pair.x + i, pair.y + j))


def test_rows_are_written_from_tuples() -> None:
    rows = np.zeros((2, 3, 2))
    filled(rows, Pair(10.0, 20.0))
    assert rows[1, 2].tolist() == [11.0, 22.0]
    assert rows[:, :, 0].tolist() == [[10.0] * 3, [11.0] * 3]


class Nested(NamedTuple):
    """A tuple in a tuple."""

    pair: Pair
    z: float


@kernel
def through_lanes(block: Any, out: Any, kept: Any) -> None:
    both = read_lanes(Nested(Pair(0.0, 0.0), 0.0), block)
    together = [both, both]
    together[1] = Nested(Pair(both.pair.x + both.z, both.pair.y), floor(both.z))
    write_lanes(out, together[1])
    write_lanes(kept, in_lanes(Pair(7.0, 0.5), both.z))


@pytest.mark.parametrize("number", [np.float64, np.float32])
def test_lanes_are_read_from_and_written_to_columns(number: Any) -> None:
    lanes = host_width(np.dtype(number).itemsize)
    block = np.arange(3.0 * 2 * lanes).reshape(3, -1).astype(number) / 4
    out, kept = np.zeros((3, lanes), number), np.zeros((2, lanes), number)
    part = block[:, lanes - 1 : 2 * lanes - 1]
    through_lanes(part, out, kept)
    assert np.array_equal(out, [part[0] + part[2], part[1], np.floor(part[2])])
    assert kept.tolist() == [[7.0] * lanes, [0.5] * lanes]


@kernel
def all_sorts(block: Any, out: Any) -> Any:
    x, y = read_lanes(Pair(0.0, 0.0), block)
    first, second = halves(join(x, y))
    near = select((first < 0.1) & (second > 0.0), select(x > y, 1.0, 3.0), 1 / 3)
    write_lanes(out, Pair(near * sqrt(abs(first)) + min(second, 2.0), floor(x) / -y))
    return width(x), epsilon(x)


@pytest.mark.parametrize("number", [np.float64, np.float32])
def test_a_block_in_single_precision_is_computed_in_it(number: Any) -> None:
    lanes = host_width(np.dtype(number).itemsize)
    block = np.random.default_rng(1).uniform(0.05, 3.0, (2, lanes)).astype(number)
    out = np.zeros((2, lanes), number)
    assert all_sorts(block, out) == (lanes, np.finfo(number).eps)
    x, y = block
    one, near = number(1.0), np.where((x < number(0.1)) & (y > 0.0), np.where(x > y, 1.0, 3.0), 1 / 3).astype(number)
    wanted = [near * np.sqrt(np.abs(x)) + np.minimum(y, 2.0 * one), np.floor(x) / -y]
    assert np.array_equal(out, wanted)


def test_the_interpreter_reads_and_writes_alike() -> None:
    lanes = host_width()
    block, out = np.arange(3.0 * lanes).reshape(3, -1), np.zeros((3, lanes))
    read = read_lanes(Nested(Pair(0.0, 0.0), 0.0), block)
    assert isinstance(read, Nested)
    write_lanes(out, read)
    assert np.array_equal(out, block)
    assert in_lanes(Pair(1.0, read.z), read.z) == Pair(Lanes([1.0] * lanes), read.z)  # type: ignore[arg-type]


@kernel
def doubled_numbers(numbers: Any, out: Any) -> Any:
    for row in range(len(numbers)):
        nested = read_numbers(Nested(Pair(0.0, 0.0), 0.0), numbers[row])
        write_numbers(out[row], Nested(Pair(2.0 * nested.pair.x, nested.pair.y), nested.z + nested.pair.x))
    return nested


@given(st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=4))
def test_tuples_are_read_from_and_written_to_numbers(rows: list[tuple[float, float, float]]) -> None:
    out = np.zeros((len(rows), 4))
    last = doubled_numbers(np.array(rows), out)
    assert last == Nested(Pair(*rows[-1][:2]), rows[-1][2])
    assert out.tolist() == [[2.0 * x, y, z + x, 0.0] for x, y, z in rows]


def test_numbers_may_stand_anywhere_in_memory() -> None:
    wide, out = np.arange(24.0).reshape(2, 12), np.zeros((6, 2)).T
    doubled_numbers(wide[:, ::4], out)
    assert out[:, :3].tolist() == [[0.0, 4.0, 8.0], [24.0, 16.0, 32.0]]


def test_the_interpreter_reads_and_writes_numbers_alike() -> None:
    nested, out = read_numbers(Nested(Pair(0.0, 0.0), 0.0), np.array([1.0, 2.0, 3.0])), np.zeros(3)
    assert nested == Nested(Pair(1.0, 2.0), 3.0)
    assert type(nested.pair) is Pair
    write_numbers(out, nested)
    assert out.tolist() == [1.0, 2.0, 3.0]


@kernel
def read_like(like: Any, numbers: Any, block: Any) -> Any:
    own = read_numbers(like, numbers)
    return own, read_lanes(like, block)


def test_what_a_tuple_looks_like_is_enough_to_read_numbers_and_lanes() -> None:
    block = np.arange(3.0 * host_width()).reshape(3, -1)
    for like in (Nested(Pair(8, 9.0), 7.0), Nested(Pair(1.0, 2), True), (1.0, Pair(2.0, 3.0))):
        own, lanes = read_like(Like.from_tuple(like), block[:, 1].copy(), block)
        assert own == read_numbers(like, block[:, 1])
        assert lanes == read_lanes(like, block)
        assert type(own) is type(lanes) is type(like)
        assert type(own[0]) is type(like[0] if isinstance(like[0], tuple) else 1.0)


@kernel
def read_narrow(like: Any, block: Any, out: Any) -> Any:
    own = read_lanes(like, block)
    beside = read_lanes((0.0, 0.0), block[1:], own.x)
    write_lanes(out, beside)
    return width(like, block), width(own.y), width(beside[1]), width(1.0)


@pytest.mark.compiled
@pytest.mark.parametrize("number", [np.float64, np.float32])
@pytest.mark.parametrize("most", [16, 32, 64])
def test_lanes_take_as_many_bytes_as_are_said_and_others_as_many_beside_them(most: int, number: Any) -> None:
    size = np.dtype(number).itemsize
    lanes = host_width(size, most)
    assert lanes == min(host_width(size), most // size)
    block = np.random.default_rng(1).uniform(0.05, 3.0, (3, host_width(size))).astype(number)
    out = np.zeros((2, host_width(size)), number)
    assert read_narrow(Like.from_tuple(Pair(0.0, 0.0), most), block, out) == (lanes, lanes, lanes, 1)
    assert np.array_equal(out[:, :lanes], block[1:, :lanes])
    assert not out[:, lanes:].any()


@kernel
def one_lane_weighted(like: Any, block: Any, out: Any) -> Any:
    low = read_lanes(like, block)
    high = read_lanes(like, block[1:])
    first, second = unpacked(each(weighted, packed((low, high)), low.x), (low, high))
    write_lanes(out, first)
    write_lanes(out[2:], second)


@pytest.mark.compiled
def test_one_lane_in_single_precision_is_packed_as_it_is() -> None:
    block, out = np.array([[3.0], [0.5], [2.0]], np.float32), np.zeros((4, 1), np.float32)
    one_lane_weighted(Like.from_tuple(Pair(0.0, 0.0), max_bytes=block.itemsize), block, out)
    assert out.ravel().tolist() == [9.0, -2.5, 1.5, -1.0]


@pytest.mark.compiled
def test_a_kernel_is_compiled_once_for_tuples_that_look_alike() -> None:
    compiled = len(read_like.dispatcher.overloads)  # type: ignore[attr-defined]
    block = np.zeros((2, host_width()))
    for like in (Pair(1.0, 2.0), Pair(3, True), Pair(np.ones(3), 1.0)):  # type: ignore[arg-type]
        read_like(Like.from_tuple(like), block[:, 0].copy(), block)
    assert len(read_like.dispatcher.overloads) == compiled + 1  # type: ignore[attr-defined]


def test_tuples_without_numbers_come_apart_too() -> None:
    class Nothing(NamedTuple):
        """Part of a state that has no numbers."""

    items = tuple((float(i), Nothing()) for i in range(3))
    assert apart(abreast(items), items) == items
