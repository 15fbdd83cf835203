"""Functions for numbers side by side, each number by itself, and for slots."""

import ast
from collections.abc import Callable
from typing import Any

from layflat import lanes
from layflat.export.c_source.c_types import (
    INT_TYPE,
    REAL_BOOL_TYPE,
    REAL_TYPE,
    Items,
    Number,
    Record,
    is_array,
    item_type,
)
from layflat.export.c_source.expressions import Expressions
from layflat.export.c_source.storage import Into
from layflat.export.c_source.values import (
    Computed,
    Known,
    Parts,
    Stored,
    Value,
    item_of,
    items_of,
    lane,
    length,
    side_by_side,
    type_of,
    width,
)

MAX_TERMS = 4  # of a sum that is written in one expression


class SideBySide(Expressions):
    """Numbers side by side in a function."""

    def select(self, args: list[Value], into: tuple[Into, ...]) -> Value:
        """Return `lanes.select`."""
        count = max(map(width, args))
        if count > 1:
            return side_by_side([self.select([lane(arg, i) for arg in args], into) for i in range(count)])
        test, yes, no = args
        kind = self.joined([yes, no])
        kind = self.literal if kind == INT_TYPE else kind
        kind = REAL_TYPE if self.kind_of(test) == REAL_BOOL_TYPE else kind
        if isinstance(test, Known):
            return self.number(yes if test.value else no, kind)
        return self._chosen(self.condition(test), yes, no, kind)

    def total(self, args: list[Value], into: tuple[Into, ...]) -> Value:
        """Return `lanes.total`: the sum of a tuple's items, in order."""
        value = args[0]
        count, kind = length(value), self.kind_of(value)
        if isinstance(value, Stored) and is_array(kind) and count > MAX_TERMS and isinstance(item_type(kind), Number):
            name = self.names.fresh(into[0].name or "sum")
            self.emit(f"{self.declarator(item_type(kind), name)} = {value.text}[0];", name)
            with self.names.counter() as i, self.block(f"for (int {i} = 1; {i} < {count}; {i}++)", name):
                self.emit(f"{name} = {name} + {value.text}[{i}];", name)
            return Computed(name, item_type(kind))
        result = item_of(value, 0)
        for at in range(1, count):
            result = self._operation(result, ast.Add(), item_of(value, at))
        return result

    def epsilon(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return `lanes.epsilon` of the number's precision."""
        single = self.program.precision == "single" and self.kind_of(lane(args[0], 0)) == REAL_TYPE
        return Known(2.0**-23 if single else 2.0**-52)

    def anywhere(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return `lanes.anywhere`."""
        value = args[0]
        result = self._comparison(lane(value, 0), ast.NotEq(), Known(0.0))
        for i in range(1, width(value)):
            term = self._comparison(lane(value, i), ast.NotEq(), Known(0.0))
            result = self._operation(result, ast.BitOr(), term)
        return result

    def zero_if_finite(self, args: list[Value], into: tuple[Into, ...]) -> Value:
        """Return `lanes.zero_if_finite`, as a sum over all numbers of a tuple."""
        terms = Parts(tuple(self._operation(leaf, ast.Sub(), leaf) for leaf in self.leaves(args[0])))
        return self.total([terms], into)

    def leaves(self, value: Value) -> list[Value]:
        """Return all numbers of a nested tuple."""
        kind = type_of(value, self.literal)
        if isinstance(kind, Number):
            return [self.simple(value, "value")] if isinstance(value, Computed) else [value]
        return [leaf for item in items_of(self.hold_parts(value, "value")) for leaf in self.leaves(item)]

    def in_lanes(self, args: list[Value], into: tuple[Into, ...]) -> Value:
        """Return `lanes.in_lanes`: the numbers of a tuple in the type of another number."""
        value, like = args
        if width(value) > 1:
            return value
        kind = self.kind_of(value)
        if not isinstance(kind, Number):
            items = tuple(self.in_lanes([item, like], into) for item in items_of(self.hold_parts(value, "value")))
            return Parts(items, kind.cls if isinstance(kind, Record) else None)
        alike = [self.number(value, self.numeric(self.kind_of(lane(like, i)))) for i in range(width(like))]
        return side_by_side(list(alike))

    def join(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return `lanes.join`."""
        return side_by_side([lane(arg, i) for arg in args for i in range(width(arg))])

    def halves(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return `lanes.halves`."""
        half = width(args[0]) // 2
        numbers = [lane(args[0], i) for i in range(2 * half)]
        return Parts((side_by_side(numbers[:half]), side_by_side(numbers[half:])))

    def abreast(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return `lanes.abreast`."""
        return side_by_side([lane(item, i) for item in items_of(args[0]) for i in range(width(item))])

    def apart(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return `lanes.apart`."""
        value, count = args[0], length(args[1])
        size = width(value) // count
        numbers = [lane(value, i) for i in range(size * count)]
        return Parts(tuple(side_by_side(numbers[size * i : size * (i + 1)]) for i in range(count)))

    def first_argument(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return the first argument as it is: items need not be packed where each number is computed by itself."""
        return args[0]

    def running_sums(self, args: list[Value], direction: int) -> Value:
        """Return `lanes.sums_up_to` (1) or `lanes.sums_from` (-1), leaf by leaf."""
        value, like = self.hold_parts(args[0], "term"), args[1]
        kind = self.kind_of(lane(value, 0))
        if not isinstance(kind, Number):
            items = []
            for i in range(len(items_of(lane(value, 0)))):
                leaf = side_by_side([item_of(lane(value, j), i) for j in range(width(value))])
                items.append(self.running_sums([leaf, like], direction))
            return Parts(tuple(items), kind.cls if isinstance(kind, Record) else None)
        parts, step = items_of(self.apart(args, ()))[::direction], 1
        while step < len(parts):
            sums = [self._operation(a, ast.Add(), b) for a, b in zip(parts[step:], parts, strict=False)]
            held = [self.simple(one, "sum") if isinstance(one, Computed) else one for one in sums]
            parts, step = parts[:step] + held, 2 * step
        return side_by_side([lane(part, i) for part in parts[::direction] for i in range(width(part))])

    def sums_up_to(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return `lanes.sums_up_to`."""
        return self.running_sums(args, 1)

    def sums_from(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return `lanes.sums_from`."""
        return self.running_sums(args, -1)

    def slots(self, args: list[Value], into: tuple[Into, ...]) -> Value:
        """Return `lanes.slots` filled with a value."""
        like, value = args
        kind = Items((self.kind_of(value),) * length(like))
        if not is_array(kind):
            return Parts((value,) * length(like))
        if length(like) == 1 or isinstance(value, Parts | Known):
            return Parts((value,) * length(like))
        place = self.variable(into[0], kind, "slots")
        with self.counting(length(like), place.text) as i:
            self.store(item_of(place, i), value, place.text)
        return place

    def gather(self, args: list[Value], into: tuple[Into, ...]) -> Value:  # noqa: ARG002
        """Return `lanes.gather`: the first items, as many as a tuple has."""
        like, value = args
        count = length(like)
        return value if length(value) == count else Parts(tuple(items_of(value)[:count]))


LANES_FUNCTIONS: dict[Any, Callable[..., Value]] = {
    lanes.select: SideBySide.select,
    lanes.total: SideBySide.total,
    lanes.epsilon: SideBySide.epsilon,
    lanes.anywhere: SideBySide.anywhere,
    lanes.zero_if_finite: SideBySide.zero_if_finite,
    lanes.in_lanes: SideBySide.in_lanes,
    lanes.join: SideBySide.join,
    lanes.halves: SideBySide.halves,
    lanes.abreast: SideBySide.abreast,
    lanes.apart: SideBySide.apart,
    lanes.packed: SideBySide.first_argument,
    lanes.unpacked: SideBySide.first_argument,
    lanes.sums_up_to: SideBySide.sums_up_to,
    lanes.sums_from: SideBySide.sums_from,
    lanes.slots: SideBySide.slots,
    lanes.gather: SideBySide.gather,
}
"""Functions of `lanes` as methods, of arguments and places for results."""
