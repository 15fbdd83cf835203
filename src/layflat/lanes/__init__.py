"""Lanes: several numbers that a law handles as if they were one.

The four hoses of an arm, or the arms of an ensemble, all obey the same laws. A law that is given lanes instead of
numbers is compiled to vector instructions and works on all of them at once, each lane bit for bit what the scalar law
gives. A law needs nothing for this but `select` where it would write `a if condition else b`, and `&` and `|` where
it would write `and` and `or`.

`join` puts two numbers side by side, or two lanes, or two named tuples of them leaf by leaf; `halves` takes them
apart. `abreast` and `apart` do the same with all items of a tuple, however many, `packed` and `unpacked` only where the
items would fill a register together, and `sums_up_to` and `sums_from` add up what is abreast. `write_row` is the way
out of named tuples into arrays; `read_numbers` and `write_numbers` lead from arrays into named tuples and back, which
costs far less than to hand over such tuples from Python. `read_lanes` and `write_lanes` lead from arrays into lanes and
back: an item of a named tuple is a row there, a lane is a column; lanes of a block in single precision are twice as
many. `slots` are lists without a heap, `gather` makes a tuple of what they hold, `total` adds the items of one, and
`each` calls a law for every item of tuples.

All of it compiles for CUDA devices too. A thread there has one lane, so that what `read_lanes` gives are plain numbers;
what is joined lies side by side all the same. numba-cuda takes over whatever is registered from outside numba.

All of this is plain Python, the meaning of each operation. `compiled` teaches it to the compiler when first needed.
"""

import operator
import os
from collections.abc import Callable, Iterator
from functools import cache, wraps
from itertools import count
from typing import Any, ClassVar

WIDEST = 64  # bytes of the widest vector registers there are


def _switched_on(name: str) -> bool:
    return os.environ.get(name, "").strip() not in ("", "0")


@cache
def interpreted() -> bool:
    """Return whether nothing is compiled (NUMBA_DISABLE_JIT)."""
    return _switched_on("NUMBA_DISABLE_JIT")


@cache
def host_width(size: int = 8, most: int = WIDEST) -> int:
    """Lanes of `size` bytes that a vector register of this machine holds, or `most` bytes of it.

    In the simulator of a CUDA device it is one.
    """
    if interpreted() and _switched_on("NUMBA_ENABLE_CUDASIM"):
        return 1
    from llvmlite import binding  # noqa: PLC0415  # part of the compiler, which takes long to load

    features: Any = binding.get_host_cpu_features()  # type: ignore[no-untyped-call]
    return min(WIDEST if features.get("avx512f") else 32, most) // size


class Lanes(tuple[Any, ...]):
    """Numbers side by side; arithmetic is done lane by lane, with other lanes or with one number for all."""

    __slots__ = ()

    def __neg__(self) -> "Lanes":
        return Lanes(-a for a in self)


def _elementwise(operation: Callable[[Any, Any], Any]) -> tuple[Callable[..., Lanes], Callable[..., Lanes]]:
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
    """`yes` where the condition holds, else `no`; both are computed."""
    return yes if condition else no


def anywhere(number: Any) -> bool:
    """Return whether a number is not zero in any lane."""
    return any(number) if isinstance(number, Lanes) else number != 0.0


def join(first: Any, second: Any) -> Any:
    """Lanes of `first`, then those of `second`, leaf by leaf."""
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
    """Lanes of all items of a tuple, one after the other, leaf by leaf: as `join`, for as many as there are."""
    first = items[0]
    if isinstance(first, tuple) and not isinstance(first, Lanes):
        return _rebuild(first, [abreast(leaves_of) for leaves_of in zip(*items, strict=True)])
    parts = [item if isinstance(item, Lanes) else (item,) for item in items]
    lanes = Lanes(number for part in parts for number in part)
    return lanes if len(lanes) > 1 else lanes[0]


def apart(lanes: Any, like: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the items that `abreast` put side by side: a tuple with as many as `like`."""
    count = len(like)
    if isinstance(lanes, tuple) and not isinstance(lanes, Lanes):
        parts = zip(*[apart(leaf, like) for leaf in lanes], strict=True)
        return tuple(_rebuild(lanes, list(part)) for part in parts)
    if count == 1:
        return (lanes,)
    size = len(lanes) // count
    pieces = [Lanes(lanes[size * i : size * (i + 1)]) for i in range(count)]
    return tuple(piece if size > 1 else piece[0] for piece in pieces)


def packed(items: tuple[Any, ...]) -> tuple[Any, ...]:
    """A tuple with as few items as registers take: single numbers all `abreast`, lanes as they are.

    So a law that is called with `each` of what is packed is called no more often than need be.
    """
    return (abreast(items),) if next(_counts(items), 1) == 1 else items


def unpacked(few: tuple[Any, ...], like: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a tuple with as many items as `like`: undoes `packed`."""
    return apart(few[0], like) if len(few) < len(like) else few


def sums_up_to(lanes: Any, like: tuple[Any, ...]) -> Any:
    """Return the running sum, from the first item on, over items that `abreast` put side by side, leaf by leaf.

    It takes as many additions one after the other as `len(like)` can be halved: first each item and the one before,
    then that and what is two before, four before and so on.
    """
    return _summed(lanes, like, 1)


def sums_from(lanes: Any, like: tuple[Any, ...]) -> Any:
    """Return the running sum, from the last item backwards; see `sums_up_to`."""
    return _summed(lanes, like, -1)


def _summed(lanes: Any, like: tuple[Any, ...], way: int) -> Any:
    if isinstance(lanes, tuple) and not isinstance(lanes, Lanes):
        return _rebuild(lanes, [_summed(leaf, like, way) for leaf in lanes])
    items, step = list(apart(lanes, like))[::way], 1
    while step < len(items):
        items, step = items[:step] + [a + b for a, b in zip(items[step:], items, strict=False)], 2 * step
    return abreast(tuple(items[::way]))


def write_row(rows: Any, i: int, j: int, values: tuple[float, ...]) -> None:
    """Write a named tuple of floats into rows[i, j, :]."""
    rows[i, j] = values


class Like:
    """Structure of a nested tuple of floats, without the floats, for kernels that read these from arrays.

    From Python a kernel would take the tuple number by number, in machine code that may be a third as long as its own.
    Tuples that look alike have one and the same, so that the compiler looks once.
    """

    _known: ClassVar[dict[Any, "Like"]] = {}

    def __init__(self, value: Any, most: int) -> None:
        self.value, self.most = value, most

    @classmethod
    def of(cls, value: Any, most: int = WIDEST) -> "Like":
        """Return the structure of a tuple, with the largest size in bytes of lanes that are read for it."""
        key = _looks(value), most
        if key not in cls._known:
            cls._known[key] = cls(mapped(value, lambda _: 0.0), most)
        return cls._known[key]


def _looks(value: Any) -> Any:
    return (type(value), *map(_looks, value)) if isinstance(value, tuple) else None


def read_numbers(like: Any, numbers: Any) -> Any:
    """A tuple like `like` (nested, of floats), its leaves in order from numbers[0], numbers[1]; or that of a `Like`."""
    places = count()

    def read(part: Any) -> Any:
        if isinstance(part, tuple):
            return _rebuild(part, [read(item) for item in part])
        return float(numbers[next(places)])

    return read(like.value if isinstance(like, Like) else like)


def write_numbers(numbers: Any, values: Any) -> None:
    """Write the leaves of a tuple (nested, of floats) into numbers[0], numbers[1] and so on."""
    for place, value in enumerate(leaves(values)):
        numbers[place] = value


def leaves(value: Any) -> Iterator[Any]:
    """Numbers of a nested tuple in order, or lanes of them."""
    if isinstance(value, tuple) and not isinstance(value, Lanes):
        for item in value:
            yield from leaves(item)
    else:
        yield value


def width(number: Any, block: Any = None) -> int:
    """Return the number of lanes of a number, or of a block as it is read; known when a kernel is compiled."""
    if block is not None:
        return host_width(block.itemsize, number.most if isinstance(number, Like) else WIDEST)
    return len(number) if isinstance(number, Lanes) else 1


def read_lanes(like: Any, block: Any, beside: Any = None) -> Any:
    """A tuple like `like`, as `read_numbers` gives, its leaves in order from block[0, :], block[1, :] and so on.

    Lanes are as many as a number has that is given to be `beside`, else as many as a register holds, or a `Like` says.
    They have the precision of the block's numbers; all that is done with them, and with others, is done in that.
    """
    rows, lanes = count(), width(like, block) if beside is None else width(beside)

    def read(part: Any) -> Any:
        if isinstance(part, tuple):
            return _rebuild(part, [read(item) for item in part])
        row = block[next(rows)]
        return Lanes(float(row[lane]) for lane in range(lanes)) if lanes > 1 else float(row[0])

    return read(like.value if isinstance(like, Like) else like)


def in_lanes(value: Any, like: Any) -> Any:
    """The value with every number in it spread over as many lanes as `like` has."""
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
    """A scalar law that can be given lanes: it is called once per lane."""

    @wraps(function)
    def called(*args: Any) -> Any:
        if not any(isinstance(arg, tuple) for arg in args):
            return function(*args)
        counts = set(_counts(args))
        if not counts:
            return function(*args)
        (lanes,) = counts
        return _transpose([function(*_lane(args, i)) for i in range(lanes)])

    return called


def mapped(value: Any, function: Callable[[Any], Any]) -> Any:
    """A nested tuple with a function applied to all its leaves."""
    if isinstance(value, tuple):
        return _rebuild(value, [mapped(item, function) for item in value])
    return function(value)


def slots(items: Any, value: Any = None) -> Any:
    """A list of the items; or, given a value, one with that value in the place of each."""
    return list(items) if value is None else [value] * len(items)


def gather(like: Any, items: Any) -> Any:
    """A tuple of the first items of slots or of an array, as many as `like` (a tuple, or slots) has."""
    return tuple(items[i] for i in range(len(like)))


def total(numbers: tuple[Any, ...]) -> Any:
    """The sum of a tuple's items, one after the other."""
    first, *others = numbers
    for number in others:
        first = first + number
    return first


def zero_if_finite(value: Any) -> Any:
    """Return zero if all numbers of a nested tuple are finite, else not a number; of lanes for each lane."""
    numbers = list(leaves(value))
    return total(tuple(number - number for number in numbers))


def each(law: Callable[..., Any], *args: Any) -> Any:
    """A law called with the first items of some tuples, with the second ones and so on: the tuple of what it returns.

    What is not a plain tuple is given to every call as it is. Of a law that returns several things (a plain tuple), a
    tuple of each: `memory, voltage = each(step, ...)`.
    """
    count = next(len(arg) for arg in args if type(arg) is tuple)
    found = [law(*(arg[i] if type(arg) is tuple else arg for arg in args)) for i in range(count)]
    return tuple(zip(*found, strict=True)) if type(found[0]) is tuple else tuple(found)


def _rebuild(like: Any, items: list[Any]) -> Any:
    return type(like)(*items) if hasattr(like, "_fields") else tuple(items)


def _counts(value: Any) -> Iterator[int]:
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
