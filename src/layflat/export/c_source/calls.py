"""Calls in laws: of laws, of named tuples, of the compiler's functions, and of those for numbers side by side."""

import ast
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from layflat import lanes
from layflat.export.c_source.c_types import (
    BOOL_TYPE,
    CONDITION_TYPES,
    INT_TYPE,
    REAL_TYPE,
    Number,
    Record,
    is_array,
    item_type,
    leaf_count,
)
from layflat.export.c_source.side_by_side import LANES_FUNCTIONS, SideBySide
from layflat.export.c_source.storage import NO_PLACE, Into
from layflat.export.c_source.values import (
    Computed,
    Known,
    Level,
    Parts,
    Stored,
    Value,
    is_plain_tuple,
    item_of,
    items_of,
    lane,
    length,
    side_by_side,
    width,
)
from layflat.jit import ByKind, Law

MAX_TERMS = 4  # of a sum that is written in one expression
KNOWN_FUNCTIONS = (
    "abs, min, max, float, len, sqrt, floor, ceil, copysign, isnan, isinf, isfinite, select, each and other laws"
)
ROUNDING_FUNCTIONS, TEST_FUNCTIONS = (math.floor, math.ceil), (math.isnan, math.isinf, math.isfinite)
C_FUNCTIONS: dict[Any, str] = {
    abs: "fabs",
    **{
        function: function.__name__
        for function in (math.sqrt, math.fabs, math.copysign, *ROUNDING_FUNCTIONS, *TEST_FUNCTIONS)
    },
}
FOLDED_FUNCTIONS = (*C_FUNCTIONS, min, max, float, int, bool)  # functions of constants that are constants


class Calls(SideBySide):
    """Values of the calls in a function."""

    def value_of_call(self, node: ast.Call, into: tuple[Into, ...]) -> Value:
        """Return the result of a call."""
        called = self.value(node.func)
        if not isinstance(called, Known):
            self.fail(f"{ast.unparse(node.func)!r} is no function", "call a law")
        function = called.value
        if any(keyword.arg is None for keyword in node.keywords):
            self.fail("** in a call has no counterpart in C", "name each argument")
        if function is lanes.slots and len(node.args) == 1:
            items = self.value(node.args[0], into)
            return (
                replace(items, borrowed=True) if isinstance(items, Stored) and items.text not in self.unbound else items
            )
        args = list(self.all_values(node.args, argument_names(function)))
        named = {str(keyword.arg): self.value(keyword.value) for keyword in node.keywords}
        return self.call(function, args, named, into)

    def call(self, function: Any, args: list[Value], named: dict[str, Value], into: tuple[Into, ...]) -> Value:
        """Return the result of a function of any sort.

        Args:
            function: the function.
            args: its arguments in order.
            named: its arguments by name.
            into: places for the results.
        """
        if isinstance(function, type) and hasattr(function, "_fields"):
            return self.named_tuple(function, args, named)
        if isinstance(function, ByKind | Law):
            return self.call_law(function, args, named, into)
        if named:
            self.fail("a keyword in this call has no counterpart in C", "give the arguments in order")
        if function is lanes.each:
            return self.each(args, into)
        method: Callable[..., Value] | None = LANES_FUNCTIONS.get(function)
        if method is not None:
            return method(self, args, into)
        count = max((width(arg) for arg in args), default=1)
        if count > 1:
            calls = [self.call(function, [lane(arg, i) for arg in args], {}, (NO_PLACE,)) for i in range(count)]
            return side_by_side(calls)
        return self.plain_call(function, args)

    def named_tuple(self, cls: Any, args: list[Value], named: dict[str, Value]) -> Value:
        """Return a named tuple in parts."""
        fields = dict(zip(cls._fields, args, strict=False)) | named
        fields |= {name: Known(value) for name, value in cls._field_defaults.items() if name not in fields}
        if len(args) > len(cls._fields) or set(fields) != set(cls._fields):
            self.fail(f"{cls.__name__} has other fields", f"give {', '.join(cls._fields)}")
        items = tuple(fields[name] for name in cls._fields)
        if all(isinstance(item, Known) for item in items):
            return Known(cls(*(item.value for item in items if isinstance(item, Known))))
        return Parts(items, cls)

    # The compiler's functions

    def plain_call(self, function: Any, args: list[Value]) -> Value:
        """Return the result of a function of Python's for numbers."""
        if function is len:
            return Known(self.checked_length(args[0]))
        if function in FOLDED_FUNCTIONS and all(isinstance(arg, Known) for arg in args):
            return Known(function(*(arg.value for arg in args if isinstance(arg, Known))))
        if function in (min, max):
            return self.extreme("min" if function is min else "max", args)
        if function in (float, bool):
            return self.number(args[0], self.float_kind(args[0]) if function is float else BOOL_TYPE)
        if function is abs and self.kind_of(args[0]) in (INT_TYPE, *CONDITION_TYPES):
            self.fail("abs of an integer has no counterpart in C", "use a float")
        if function not in C_FUNCTIONS:
            name = getattr(function, "__name__", repr(function))
            self.fail(f"{name!r} has no counterpart in C", f"use {KNOWN_FUNCTIONS}")
        if function in TEST_FUNCTIONS:
            return Computed(f"({self._function(C_FUNCTIONS[function], args, suffix=False).text} != 0)", BOOL_TYPE)
        result = self._function(C_FUNCTIONS[function], args)
        # An integer has no negative zero; numbers of single precision stay floats.
        whole = function in ROUNDING_FUNCTIONS and not (self.program.precision == "single" and result.kind == REAL_TYPE)
        return Computed(f"{result.text} + {self.zero(result.kind)}", result.kind, Level.SUM) if whole else result

    def checked_length(self, value: Value) -> int:
        """Return the number of items of a tuple; raise KindError if it is none."""
        try:
            return length(value)
        except TypeError:
            self.fail("len of a value that is no tuple", "use len of a tuple")

    def float_kind(self, value: Value) -> Number:
        """Return the type of a number as a float."""
        kind = self.numeric(self.kind_of(value))
        return self.literal if kind == INT_TYPE else kind

    def _function(self, name: str, args: list[Value], *, suffix: bool = True) -> Computed:
        """Return the call of a function of C's library."""
        kind = self.joined(args)
        kind = self.literal if kind == INT_TYPE else kind
        end = "f" if suffix and self.c_type(kind) == "float" else ""
        return Computed(f"{name}{end}({', '.join(self.number(arg, kind).text for arg in args)})", kind)

    def extreme(self, name: str, args: list[Value]) -> Value:
        """Return the min or max of numbers: the first of equal ones, and where one is NaN, as Python has it."""
        if len(args) == 1 and is_plain_tuple(args[0]):
            args = items_of(args[0])
        kind = self.joined(args)
        helper = f"{name}_{'int' if kind == INT_TYPE else 'real' if kind == REAL_TYPE else 'double'}"
        result = self.number(args[0], kind).text
        for arg in args[1:]:
            result = f"{helper}({result}, {self.number(arg, kind).text})"
        return Computed(result, kind)

    # Laws

    def call_law(self, law: Any, args: list[Value], named: dict[str, Value], into: tuple[Into, ...]) -> Value:
        """Return the result of a law; numbers side by side are computed one by one, except in compositions.

        Args:
            law: the law, or a choice between laws.
            args: its arguments in order.
            named: its arguments by name.
            into: places for the results.
        """
        while isinstance(law, ByKind):
            if not args:
                self.fail("a choice between laws lacks its first argument", "give the parameters of a kind first")
            kind = self.kind_of(lane(args[0], 0))
            if not isinstance(kind, Record) or kind.cls not in law.kinds:
                self.fail("a choice between laws knows none for its first argument", "register a kind with its class")
            law = law.kinds[kind.cls]
        if not isinstance(law, Law):
            self.fail(f"{getattr(law, '__name__', law)!r} is plain Python", "decorate it with layflat.jit.law")
        count = max((width(arg) for arg in args), default=1)
        if count > 1 and is_lane_by_lane(law):
            calls = [
                self.call_law(law, [lane(arg, i) for arg in args], named, self.of_lane(into, i)) for i in range(count)
            ]
            return side_by_side(calls)
        return self.program.call(self, law.py_func, args, named, into)  # type: ignore[no-any-return]

    def of_lane(self, into: tuple[Into, ...], i: int) -> tuple[Into, ...]:
        """Return the places for results of one of several numbers side by side."""
        return tuple(Into(f"{one.name}_{i + 1}" if one.name else "") for one in into)

    def each(self, args: list[Value], into: tuple[Into, ...]) -> Value:
        """Return the results of a law for the items of tuples: computed in a loop, or one after the other."""
        law, given = args[0].value if isinstance(args[0], Known) else None, args[1:]
        counts = {length(arg) for arg in given if is_plain_tuple(arg)}
        if not counts or len(counts) > 1:
            self.fail("each takes tuples with as many items", "give it tuples of one length")
        (count,) = counts
        held = [self.held_for_loop(arg) for arg in given]
        alike = all(
            not is_plain_tuple(arg) or (isinstance(arg, Stored) and is_array(arg.kind) and not arg.grouped)
            for arg in held
        )
        if count > 1 and alike and all(width(arg) == 1 for arg in held):
            looped = self.program.looped_call(self, law, held, count, into)
            if looped is not None:
                return looped  # type: ignore[no-any-return]
        results = []
        for i in range(count):
            items = [item_of(arg, i) if is_plain_tuple(arg) else arg for arg in held]
            results.append(self.call_law(law, items, {}, self.of_lane(into, i) if count > 1 else into))
        if is_plain_tuple(results[0]):
            return Parts(tuple(Parts(tuple(items)) for items in zip(*map(items_of, results), strict=True)))
        return Parts(tuple(results))

    def held_for_loop(self, arg: Value) -> Value:
        """Return an argument of a loop: tuples of equal items in memory, unless they are few."""
        if isinstance(arg, Computed) and not isinstance(arg.kind, Number):
            return self.hold_parts(arg, "item")
        if not isinstance(arg, Parts | Known) or not is_plain_tuple(arg) or length(arg) < 2:
            return arg
        kind = self.kind_of(arg)
        if not is_array(kind) or not leaf_count(kind) or not isinstance(item_type(kind), Number):
            return arg
        return self.hold(arg, "items")


def argument_names(function: Any) -> tuple[str, ...]:
    """Return the names of the arguments of a law or of the fields of a named tuple; none of another function."""
    if isinstance(function, type):
        return tuple(getattr(function, "_fields", ()))
    while isinstance(function, ByKind):
        function = next(iter(function.kinds.values()), None)
    code = function.py_func.__code__ if isinstance(function, Law) else None
    return code.co_varnames[: code.co_argcount] if code is not None else ()


def is_lane_by_lane(law: Law) -> bool:
    """Return whether a law is scalar, so that numbers side by side are computed one by one."""
    return getattr(law._called, "__wrapped__", None) is law.py_func
