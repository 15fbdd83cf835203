"""Operations on numbers and conditions, in the order and with the roundings of the law."""

import ast
import operator
from collections.abc import Callable
from typing import Any

from layflat.export.c_source.c_types import (
    BOOL_TYPE,
    CONDITION_TYPES,
    INT_TYPE,
    REAL_BOOL_TYPE,
    REAL_TYPE,
    Number,
    Type,
    join_types,
)
from layflat.export.c_source.storage import Storage
from layflat.export.c_source.values import (
    Computed,
    Known,
    Level,
    Parts,
    Value,
    is_plain_tuple,
    items_of,
    lane,
    side_by_side,
    width,
)

ARITHMETIC_SIGNS: dict[type, tuple[str, int, Callable[[Any, Any], Any]]] = {
    ast.Add: ("+", Level.SUM, operator.add),
    ast.Sub: ("-", Level.SUM, operator.sub),
    ast.Mult: ("*", Level.PRODUCT, operator.mul),
    ast.Div: ("/", Level.PRODUCT, operator.truediv),
}
FLOORED_HELPERS: dict[type, tuple[str, Callable[[Any, Any], Any]]] = {
    ast.FloorDiv: ("floor_divide", operator.floordiv),
    ast.Mod: ("floor_modulo", operator.mod),
}
LOGIC_SIGNS: dict[type, tuple[str, int, Callable[[Any, Any], Any]]] = {
    **dict.fromkeys((ast.BitAnd, ast.And), ("&&", Level.AND, operator.and_)),
    **dict.fromkeys((ast.BitOr, ast.Or), ("||", Level.OR, operator.or_)),
}
COMPARISON_SIGNS: dict[type, tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Lt: ("<", operator.lt),
    ast.LtE: ("<=", operator.le),
    ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge),
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
    ast.Is: ("is", operator.is_),
    ast.IsNot: ("is not", operator.is_not),
}
MAX_POWER = 16


class Arithmetic(Storage):
    """Operations in a function."""

    def negated(self, value: Value, op: ast.unaryop) -> Value:
        """Return -x of a number, or not x of a condition."""
        if isinstance(op, ast.Not):
            if isinstance(value, Known):
                return Known(not value.value)
            term = self.condition(value)
            return Computed(f"!{self.paren(term, Level.PRIMARY)}", term.kind, Level.UNARY)
        if not isinstance(op, ast.USub):
            self.fail(f"{type(op).__name__} has no counterpart in C", "use -x, or not x of a condition")
        if isinstance(value, Known):
            text = f"-{self.paren(value, Level.UNARY)}" if value.text else ""
            return Known(-value.value, text, Level.UNARY)
        kind = self.numeric(self.kind_of(value))
        return Computed(f"-{self.paren(self.number(value, kind), Level.UNARY)}", kind, Level.UNARY)

    def numeric(self, kind: Type) -> Number:
        """Return the type of a number in arithmetic; raise KindError for a tuple."""
        if not isinstance(kind, Number):
            self.fail("a tuple is used as a number", "take one of its items")
        return INT_TYPE if kind in CONDITION_TYPES else kind

    def _operation(self, left: Value, op: ast.operator, right: Value) -> Value:
        """Return the value of an operation; numbers side by side one by one, tuples of which + makes one."""
        count = max(width(left), width(right))
        if count > 1:
            pairs = [(lane(left, i), lane(right, i)) for i in range(count)]
            return side_by_side([self._operation(a, op, b) for a, b in pairs])
        if isinstance(op, ast.Add) and is_plain_tuple(left) and is_plain_tuple(right):
            return Parts((*items_of(left), *items_of(right)))
        special: dict[type, Callable[[Value, ast.operator, Value], Value]] = {
            ast.BitAnd: self._logic,
            ast.BitOr: self._logic,
            ast.Pow: self._power,
        }
        special |= dict.fromkeys(FLOORED_HELPERS, self._floored)
        if type(op) in special:
            return special[type(op)](left, op, right)
        if type(op) not in ARITHMETIC_SIGNS:
            self.fail(f"{type(op).__name__} has no counterpart in C", "use + - * / of numbers, & | of conditions")
        sign, level, compute = ARITHMETIC_SIGNS[type(op)]
        if isinstance(left, Known) and isinstance(right, Known):
            return self._folded(left, sign, right, level, compute)
        kind = self.joined([left, right])
        if isinstance(op, ast.Div) and kind == INT_TYPE:
            kind = self.literal
        a, b = self.number(left, kind), self.number(right, kind)
        return Computed(f"{self.paren(a, level)} {sign} {self.paren(b, level + 1)}", kind, level)

    def joined(self, values: list[Value]) -> Number:
        """Return the type of arithmetic with numbers."""
        kind = self.numeric(self.kind_of(values[0]))
        for value in values[1:]:
            kind = join_types(kind, self.numeric(self.kind_of(value)))  # type: ignore[assignment]
        return kind

    def _folded(self, left: Known, sign: str, right: Known, level: int, compute: Callable[[Any, Any], Any]) -> Known:
        """Return an operation with constants, which keeps the names of floats."""
        try:
            value = compute(left.value, right.value)
        except (ArithmeticError, TypeError):
            self.fail(f"{left.value!r} {sign} {right.value!r} has no value", "use numbers that have one")
        if not isinstance(value, float) or not (left.text or right.text):
            return Known(value)
        texts = []
        for one, strength in ((left, level), (right, level + 1)):
            text = one.text if isinstance(one.value, float) and one.text else ""
            texts.append(
                self.paren(one, strength) if text else self.paren(self.number(Known(one.value), REAL_TYPE), strength)
            )
        return Known(value, f"{texts[0]} {sign} {texts[1]}", level)

    def _logic(self, left: Value, op: ast.operator | ast.boolop, right: Value) -> Value:
        """Return the conjunction or disjunction of two conditions."""
        sign, level, compute = LOGIC_SIGNS[type(op)]
        if isinstance(left, Known) and isinstance(right, Known):
            return Known(compute(left.value, right.value))
        terms, kinds = [], [self.kind_of(value) for value in (left, right)]
        kind = REAL_BOOL_TYPE if REAL_BOOL_TYPE in kinds else BOOL_TYPE
        for value, own in zip((left, right), kinds, strict=True):
            if own not in CONDITION_TYPES:
                self.fail("and, or, & and | take conditions", "compare numbers, as in x > 0.0")
            term = self.number(value, kind)
            terms.append(
                self.paren(
                    term, level if term.level == level else Level.PRIMARY if term.level != Level.UNARY else Level.UNARY
                )
            )
        return Computed(f"{terms[0]} {sign} {terms[1]}", kind, level)

    def _power(self, left: Value, op: ast.operator, right: Value) -> Value:  # noqa: ARG002  (as all operations)
        """Return a whole power of a number, by repeated squaring as the compiler does it."""
        if not isinstance(right, Known) or not isinstance(right.value, int) or not 0 < right.value <= MAX_POWER:
            self.fail("powers other than whole ones have no counterpart in C", f"use x ** 2 to x ** {MAX_POWER}")
        if isinstance(left, Known):
            return Known(left.value**right.value)
        kind = self.numeric(self.kind_of(left))
        square, result = self.number(left, kind), None
        for bit in reversed(f"{right.value:b}"):
            square = self.simple(square, "power")
            if bit == "1":
                product = square if result is None else self._operation(result, ast.Mult(), square)
                assert isinstance(product, Computed)
                result = product
            following = self._operation(square, ast.Mult(), square)
            assert isinstance(following, Computed)
            square = following
        assert result is not None
        return result

    def simple(self, value: Computed, name: str) -> Computed:
        """Return a number that may be read twice: the name of a variable or field."""
        if value.level == Level.PRIMARY and "(" not in value.text:
            return value
        name = self.names.fresh(name)
        self.emit(f"const {self.declarator(value.kind, name)} = {value.text};", name)
        return Computed(name, value.kind)

    def _floored(self, left: Value, op: ast.operator, right: Value) -> Value:
        """Return quotient or remainder of integers, rounded down."""
        name, compute = FLOORED_HELPERS[type(op)]
        if isinstance(left, Known) and isinstance(right, Known):
            return Known(compute(left.value, right.value))
        if self.joined([left, right]) != INT_TYPE:
            self.fail("// and % of floats have no counterpart in C", "use x - y * floor(x / y)")
        return Computed(f"{name}({self.number(left, INT_TYPE).text}, {self.number(right, INT_TYPE).text})", INT_TYPE)

    def condition(self, value: Value) -> Computed:
        """Return a condition as C's bool."""
        return self.number(value, REAL_BOOL_TYPE if self.kind_of(value) == REAL_BOOL_TYPE else BOOL_TYPE)

    def _comparison(self, left: Value, op: ast.cmpop, right: Value) -> Value:
        """Return the comparison of two numbers, or lane by lane."""
        if type(op) not in COMPARISON_SIGNS:
            self.fail(f"{type(op).__name__} has no counterpart in C", "compare numbers")
        sign, compute = COMPARISON_SIGNS[type(op)]
        count = max(width(left), width(right))
        if count > 1:
            return side_by_side([self._comparison(lane(left, i), op, lane(right, i)) for i in range(count)])
        if isinstance(left, Known) and isinstance(right, Known):
            return Known(compute(left.value, right.value))
        if sign.startswith("is"):
            return Known(sign == "is not")
        kind = join_types(self.kind_of(left), self.kind_of(right))
        if not isinstance(kind, Number):
            self.fail("tuples are compared", "compare their numbers")
        a, b = self.number(left, kind), self.number(right, kind)
        result = REAL_BOOL_TYPE if kind == REAL_TYPE and self.program.precision == "single" else BOOL_TYPE
        return Computed(
            f"{self.paren(a, Level.COMPARISON + 1)} {sign} {self.paren(b, Level.COMPARISON + 1)}",
            result,
            Level.COMPARISON,
        )

    def _chosen(self, test: Computed, yes: Value, no: Value, kind: Number) -> Computed:
        """Return the choice between two numbers."""
        terms = [self.paren(self.number(one, kind), Level.TERNARY + 1) for one in (yes, no)]
        return Computed(f"{self.paren(test, Level.UNARY)} ? {terms[0]} : {terms[1]}", kind, Level.TERNARY)
