"""SIMD lanes: several numbers that a law handles as if they were one.

All laws of a joint's hoses, or of an ensemble's arms, are alike. A law that is given lanes instead of numbers is
compiled to vector instructions and works on all of them at once, each lane bit for bit as the scalar law. It needs
nothing for this but `select` for `a if condition else b`, and `&` and `|` for `and` and `or`.

`join`, `abreast` and `packed` put numbers, or named tuples of them leaf by leaf, side by side; `halves`, `apart` and
`unpacked` undo that. `read_numbers`, `read_lanes` and their counterparts lead from arrays into named tuples and back,
which costs far less than to pass such tuples from Python. `slots` are lists without a heap.

All of it compiles for CUDA devices too, where a thread has one lane: `read_lanes` then returns plain numbers, and
joined items stay side by side. numba-cuda takes over whatever is registered from outside numba.

This module is plain Python, the meaning of each operation; `jit/lanes` teaches it to the compiler when first needed.
"""

import operator
from collections.abc import Callable, Iterator
from functools import cached_property, reduce, wraps
from itertools import count
from typing import Any, ClassVar

from layflat.registers import MAX_REGISTER_BYTES, host_width

__all__ = ["each", "select"]  # in laws of one's own; the rest serves the package


class Lanes(tuple[Any, ...]):
    """Numbers side by side; arithmetic is done lane by lane, with other lanes or with one number for all."""

    __slots__ = ()

    def __neg__(self) -> "Lanes":
        return Lanes(-a for a in self)


def _elementwise(operation: Callable[[Any, Any], Any]) -> tuple[Callable[..., Lanes], Callable[..., Lanes]]:
    """Return a binary operation on lanes, and its reverse; a plain number is repeated in all lanes."""

    def forward(self: Lanes, other: Any) -> Lanes:
        others = other if isinstance(other, Lanes) else (other,) * len(self)
        return Lanes(operation(a, b) for a, b in zip(self, others, strict=True))

    def reverse(self: Lanes, other: Any) -> Lanes:
        return Lanes(operation(other, a) for a in self)

    return forward, reverse


for _name in ("add", "sub", "mul", "truediv"):
    _forward, _reverse = _elementwise(getattr(operator, _name))
    setattr(Lanes, f"__{_name}__", _forward)
    setattr(Lanes, f"__r{_name}__", _reverse)


def epsilon(number: Any) -> float:  # noqa: ARG001  (of which only the precision counts)
    """Return the distance from 1 to the next number in the precision of this one."""
    return 2.0**-52


def select(condition: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where the condition holds, else `no`.

    Args:
        condition: boolean, or lanes of booleans.
        yes: number or lanes; computed in any case.
        no: likewise.
    """
    return yes if condition else no


def select_leaves(condition: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where the condition holds, else `no`, leaf by leaf.

    Args:
        condition: boolean, or lanes of booleans.
        yes: nested tuple of as many lanes as the condition has; numbers without lanes.
        no: tuple of the same type.
    """
    if not isinstance(condition, Lanes):
        return yes if condition else no
    if isinstance(yes, Lanes):
        return Lanes(a if holds else b for holds, a, b in zip(condition, yes, no, strict=True))
    return _rebuild(yes, [select_leaves(condition, a, b) for a, b in zip(yes, no, strict=True)])


def anywhere(number: Any) -> bool:
    """Return whether a number is not zero in at least one lane."""
    return any(number) if isinstance(number, Lanes) else number != 0.0


def join(first: Any, second: Any) -> Any:
    """Return the lanes of `first`, then those of `second`, leaf by leaf."""
    if isinstance(first, Lanes):
        return Lanes((*first, *second))
    if isinstance(first, tuple):
        return _rebuild(first, [join(a, b) for a, b in zip(first, second, strict=True)])
    return Lanes((first, second))


def halves(joined: Any) -> tuple[Any, Any]:
    """Return the first and the second half of the lanes, leaf by leaf: undoes `join`."""
    if isinstance(joined, Lanes):
        half = len(joined) // 2
        return (Lanes(joined[:half]), Lanes(joined[half:])) if half > 1 else (joined[0], joined[1])
    pairs = [halves(leaf) for leaf in joined]
    return _rebuild(joined, [pair[0] for pair in pairs]), _rebuild(joined, [pair[1] for pair in pairs])


def abreast(items: tuple[Any, ...]) -> Any:
    """Return the lanes of all items of a tuple, one after the other, leaf by leaf: `join` for any number."""
    first = items[0]
    if isinstance(first, tuple) and not isinstance(first, Lanes):
        return _rebuild(first, [abreast(leaves_of) for leaves_of in zip(*items, strict=True)])
    lanes = Lanes(number for item in items for number in (item if isinstance(item, Lanes) else (item,)))
    return lanes if len(lanes) > 1 else lanes[0]


def apart(lanes: Any, like: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the items that `abreast` put side by side: a tuple with as many as `like`."""
    count = len(like)
    if isinstance(lanes, tuple) and not lanes:
        return (lanes,) * count
    if isinstance(lanes, tuple) and not isinstance(lanes, Lanes):
        parts = zip(*[apart(leaf, like) for leaf in lanes], strict=True)
        return tuple(_rebuild(lanes, list(part)) for part in parts)
    if count == 1:
        return (lanes,)
    size = len(lanes) // count
    return tuple(Lanes(lanes[size * i : size * (i + 1)]) if size > 1 else lanes[i] for i in range(count))


def packed(items: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a tuple of single numbers as one item, all `abreast`, and a tuple of lanes as it is.

    So `each` calls a law once where the items fit into one register.
    """
    return (abreast(items),) if next(_counts(items), 1) == 1 else items


def unpacked(few: tuple[Any, ...], like: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a tuple with as many items as `like`: undoes `packed`."""
    return apart(few[0], like) if len(few) < len(like) else few


def sums_up_to(lanes: Any, like: tuple[Any, ...]) -> Any:
    """Return the running sum, from the first item on, over items that `abreast` put side by side, leaf by leaf.

    Successive additions are log2(`len(like)`): of each item and the one before, then of two before, four and so on.
    """
    return _running_sums(lanes, like, 1)


def sums_from(lanes: Any, like: tuple[Any, ...]) -> Any:
    """Return the running sum, from the last item backwards; see `sums_up_to`."""
    return _running_sums(lanes, like, -1)


def _running_sums(lanes: Any, like: tuple[Any, ...], direction: int) -> Any:
    """Return sums of lanes up to each, or from it on with direction -1; tuples leaf by leaf."""
    if isinstance(lanes, tuple) and not isinstance(lanes, Lanes):
        return _rebuild(lanes, [_running_sums(leaf, like, direction) for leaf in lanes])
    items, step = list(apart(lanes, like))[::direction], 1
    while step < len(items):
        items, step = items[:step] + [a + b for a, b in zip(items[step:], items, strict=False)], 2 * step
    return abreast(tuple(items[::direction]))


def write_row(rows: Any, i: int, j: int, values: tuple[float, ...]) -> None:
    """Write a named tuple of floats into rows[i, j, :].

    Args:
        rows: array of three axes.
        i: first index.
        j: second index.
        values: the tuple.
    """
    rows[i, j] = values


class Like:
    """Structure of a nested tuple of floats, without the floats, for kernels that read these from arrays.

    From Python a kernel would take the tuple number by number, in machine code that may be a third as long as its own.
    Tuples of equal structure share one instance, so that the compiler types it once.
    """

    _known: ClassVar[dict[Any, "Like"]] = {}

    def __init__(self, value: Any, max_bytes: int) -> None:
        self.value, self.max_bytes = value, max_bytes

    @cached_property
    def text(self) -> str:
        """Classes of the tuples in it and maximum size of lanes: equal texts mean equal structures."""
        return f"{_structure_text(self.value)}:{self.max_bytes}"

    @classmethod
    def from_tuple(cls, value: Any, max_bytes: int = MAX_REGISTER_BYTES) -> "Like":
        """Return the structure of a tuple, with the maximum size in bytes of lanes that are read for it."""
        key = _structure_key(value), max_bytes
        if key not in cls._known:
            cls._known[key] = cls(mapped(value, lambda _: 0.0), max_bytes)
        return cls._known[key]


def _structure_key(value: Any) -> Any:
    return (type(value), *map(_structure_key, value)) if isinstance(value, tuple) else None


def _structure_text(value: Any) -> str:
    """Return the classes of nested tuples as a text, with a dot for each leaf."""
    if not isinstance(value, tuple):
        return "."
    kind = "" if type(value) is tuple else f"{type(value).__module__}.{type(value).__qualname__}"
    return f"{kind}({''.join(map(_structure_text, value))})"


def read_numbers(like: Any, numbers: Any) -> Any:
    """Return a tuple with the structure of `like` (nested, of floats, or a `Like`) and the numbers as its leaves."""
    # Python's own floats; of a law that is not compiled a leaf may be anything, in a list.
    values = iter(numbers if isinstance(numbers, list) else map(float, numbers))
    return _filled(like, lambda: next(values))


def write_numbers(numbers: Any, values: Any) -> None:
    """Write the leaves of a tuple (nested, of floats) into numbers[0], numbers[1] and so on."""
    for place, value in enumerate(leaves(values)):
        numbers[place] = value


def leaves(value: Any) -> Iterator[Any]:
    """Yield the numbers, or lanes, of a nested tuple in order."""
    if isinstance(value, tuple) and not isinstance(value, Lanes):
        for item in value:
            yield from leaves(item)
    else:
        yield value


def width(number: Any, block: Any = None) -> int:
    """Return the number of lanes of a number, or that `read_lanes` reads of a `block`; fixed in a compiled kernel."""
    if block is not None:
        return host_width(block.itemsize, number.max_bytes if isinstance(number, Like) else MAX_REGISTER_BYTES)
    return len(number) if isinstance(number, Lanes) else 1


def read_lanes(like: Any, block: Any, beside: Any = None) -> Any:
    """Return a tuple of the structure of `like`, its leaves the lanes block[0, :], block[1, :] and so on.

    Args:
        like: a nested tuple, or a `Like`, which may limit the number of lanes.
        block: array (leaves, lanes); operations on its lanes have the precision of its numbers.
        beside: a number with as many lanes as are to be read; default: as many as a register holds.
    """
    rows, lanes = count(), width(like, block) if beside is None else width(beside)

    def next_lanes() -> Any:
        row = block[next(rows)]
        return Lanes(float(row[lane]) for lane in range(lanes)) if lanes > 1 else float(row[0])

    return _filled(like, next_lanes)


def in_lanes(value: Any, like: Any) -> Any:
    """Return a value with every number in it broadcast to as many lanes as `like` has; lanes in it stay."""
    if isinstance(value, Lanes):
        return value
    if isinstance(value, tuple):
        return _rebuild(value, [in_lanes(item, like) for item in value])
    return Lanes([value] * len(like)) if isinstance(like, Lanes) else float(value)


def write_lanes(block: Any, values: Any) -> None:
    """Write lanes, or the leaves of a tuple of them, into block[0, :], block[1, :] and so on."""
    for row, lanes in enumerate(leaves(values)):
        block[row, :] = lanes


def lane_by_lane(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that calls a scalar law once per lane and joins the results, numbers or tuples, into lanes.

    Numbers among the arguments go to every call. Without lanes it calls the law once.
    """

    @wraps(function)
    def called(*args: Any) -> Any:
        counts = set(_counts(args))
        if not counts:
            return function(*args)
        (lanes,) = counts
        return _transpose([function(*_lane(args, i)) for i in range(lanes)])

    return called


def mapped(value: Any, function: Callable[[Any], Any]) -> Any:
    """Return a nested tuple with a function applied to all its leaves."""
    return _rebuild(value, [mapped(item, function) for item in value]) if isinstance(value, tuple) else function(value)


def slots(items: Any, value: Any = None) -> Any:
    """Return a list of the items; or one of the same length, filled with a value."""
    return list(items) if value is None else [value] * len(items)


def gather(like: Any, items: Any) -> Any:
    """Return a tuple of the first items of slots or of an array, as many as `like` (a tuple, or slots) has."""
    return tuple(items[i] for i in range(len(like)))


def total(numbers: tuple[Any, ...]) -> Any:
    """Return the sum of a tuple's items, added in order."""
    return reduce(operator.add, numbers)


def zero_if_finite(value: Any) -> Any:
    """Return zero if all numbers of a nested tuple are finite, else nan; for each lane."""
    return total(tuple(number - number for number in leaves(value)))


def each(law: Callable[..., Any], *args: Any) -> Any:
    """Return the tuple of a law's results for the first items of some tuples, the second ones and so on.

    Arguments that are no plain tuples are passed to every call. For a law with several results (a plain tuple), it is a
    tuple of each: `memory, voltage = each(step, ...)`.
    """
    count = next(len(arg) for arg in args if type(arg) is tuple)
    results = [law(*(arg[i] if type(arg) is tuple else arg for arg in args)) for i in range(count)]
    return tuple(zip(*results, strict=True)) if type(results[0]) is tuple else tuple(results)


def _rebuild(like: Any, items: list[Any]) -> Any:
    return type(like)(*items) if hasattr(like, "_fields") else tuple(items)


def _filled(like: Any, next_leaf: Callable[[], Any]) -> Any:
    part = like.value if isinstance(like, Like) else like
    return _rebuild(part, [_filled(item, next_leaf) for item in part]) if isinstance(part, tuple) else next_leaf()


def _counts(value: Any) -> Iterator[int]:
    """Yield the number of lanes of every leaf."""
    if isinstance(value, Lanes):
        yield len(value)
    elif isinstance(value, tuple):
        for item in value:
            yield from _counts(item)


def _lane(value: Any, i: int) -> Any:
    if isinstance(value, Lanes):
        return value[i]
    return _rebuild(value, [_lane(item, i) for item in value]) if isinstance(value, tuple) else value


def _transpose(results: list[Any]) -> Any:
    if isinstance(results[0], tuple):
        return _rebuild(results[0], [_transpose(list(items)) for items in zip(*results, strict=True)])
    return Lanes(results)
