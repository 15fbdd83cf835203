"""Expressions of laws as expressions of C, in the order and with the roundings of the law."""

import ast
from collections.abc import Iterator

from layflat.export.c_source.arithmetic import Arithmetic
from layflat.export.c_source.c_types import INT_TYPE, Number, is_array, join_types
from layflat.export.c_source.storage import NO_PLACE, Into
from layflat.export.c_source.values import (
    Computed,
    Known,
    Parts,
    Stored,
    Value,
    field_of,
    item_of,
    items_of,
    lane,
    length,
    side_by_side,
    width,
)


class Expressions(Arithmetic):
    """Values of the expressions in a function."""

    def value(self, node: ast.expr, into: tuple[Into, ...] = (NO_PLACE,)) -> Value:
        """Return the value of an expression, after adding the lines that it needs first.

        Args:
            node: the expression.
            into: places for its results, if a function or a loop has to fill them.
        """
        self.node = node
        method = getattr(self, f"value_of_{type(node).__name__.lower()}", None)
        if method is None:
            self.fail(f"{ast.unparse(node)!r} has no counterpart in C", "use arithmetic, tuples and calls of laws")
        if isinstance(node, ast.Call | ast.IfExp):
            return method(node, into)  # type: ignore[no-any-return]
        return method(node)  # type: ignore[no-any-return]

    def read(self, name: str) -> Value:
        """Return the value of a name."""
        raise NotImplementedError

    def value_of_constant(self, node: ast.Constant) -> Value:
        """Return a literal."""
        return Known(node.value)

    def value_of_name(self, node: ast.Name) -> Value:
        """Return the value of a name."""
        return self.read(node.id)

    def value_of_attribute(self, node: ast.Attribute) -> Value:
        """Return a field of a named tuple, or an attribute of a module or class."""
        value = self.value(node.value)
        try:
            return field_of(self.hold_parts(value, node.attr), node.attr)
        except AttributeError:
            self.fail(f"{ast.unparse(node)!r} is no field of a named tuple", "read a field that it has")

    def hold_parts(self, value: Value, name: str) -> Value:
        """Return a value of which parts are read: results of functions, also those abreast, go into variables."""
        if isinstance(value, Parts) and value.abreast:
            return side_by_side([self.hold_parts(item, name) for item in value.items])
        if isinstance(value, Computed) and not isinstance(value.kind, Number) and not value.text.isidentifier():
            return self.hold(value, self.program.struct_variable(value.kind, name))
        return value

    def value_of_tuple(self, node: ast.Tuple) -> Value:
        """Return a tuple in parts."""
        items = list(self.all_values(node.elts))
        if all(isinstance(item, Known) for item in items):
            return Known(tuple(item.value for item in items if isinstance(item, Known)))
        return Parts(tuple(items))

    def all_values(self, nodes: list[ast.expr], names: tuple[str, ...] = ()) -> Iterator[Value]:
        """Yield the values of expressions, and of the items of those with a star.

        Args:
            nodes: the expressions.
            names: names for variables that hold them, if need be.
        """
        for i, node in enumerate(nodes):
            if isinstance(node, ast.Starred):
                yield from items_of(self.hold_parts(self.value(node.value), "item"))
            else:
                yield self.value(node, (Into(names[i] if i < len(names) else ""),))

    def value_of_subscript(self, node: ast.Subscript) -> Value:
        """Return an item of a tuple, or some."""
        value = self.hold_parts(self.value(node.value), "item")
        if isinstance(node.slice, ast.Slice):
            ends = [None if end is None else self.known_int(end) for end in (node.slice.lower, node.slice.upper)]
            return Parts(tuple(items_of(value)[slice(*ends)]))
        return self.item(value, self.value(node.slice))

    def item(self, value: Value, index: Value) -> Value:
        """Return an item of a tuple at an index."""
        if isinstance(index, Known):
            if not isinstance(index.value, int) or not -length(value) <= index.value < length(value):
                self.fail(f"there is no item {index.value!r}", "use an index within the tuple")
            return item_of(value, index.value)
        held = value if isinstance(value, Stored) else self.hold(value, "items")
        if held.grouped or not is_array(held.kind):
            self.fail("items of several types are indexed by a variable", "use a number as the index")
        return item_of(held, self.number(index, INT_TYPE).text)

    def known_int(self, node: ast.expr) -> int:
        """Return the value of an integer that has to be known; raise KindError if it is not."""
        value = self.value(node)
        if not isinstance(value, Known) or not isinstance(value.value, int):
            self.fail(f"{ast.unparse(node)!r} is not known before the law runs", "use a number, or len of a tuple")
        return value.value

    def value_of_unaryop(self, node: ast.UnaryOp) -> Value:
        """Return a negated value."""
        value = self.value(node.operand)
        if isinstance(node.op, ast.UAdd):
            return value
        if width(value) > 1:
            return side_by_side([self.negated(lane(value, i), node.op) for i in range(width(value))])
        return self.negated(value, node.op)

    def value_of_binop(self, node: ast.BinOp) -> Value:
        """Return the value of an operation with two operands."""
        return self._operation(self.value(node.left), node.op, self.value(node.right))

    def value_of_boolop(self, node: ast.BoolOp) -> Value:
        """Return a conjunction or disjunction; both sides of it may be computed, since laws have no effects."""
        value = self.value(node.values[0])
        for term in node.values[1:]:
            if isinstance(value, Known):
                if bool(value.value) != isinstance(node.op, ast.And):
                    return value
                value = self.value(term)
            else:
                value = self._logic(value, node.op, self.value(term))
        return value

    def value_of_compare(self, node: ast.Compare) -> Value:
        """Return a comparison; of a chain, the conjunction."""
        values = [self.value(one) for one in (node.left, *node.comparators)]
        if len(values) > 2:
            values = [self.simple(one, "compared") if isinstance(one, Computed) else one for one in values]
        result: Value | None = None
        for left, op, right in zip(values, node.ops, values[1:], strict=False):
            term = self._comparison(left, op, right)
            result = term if result is None else self._logic(result, ast.And(), term)
        assert result is not None
        return result

    def value_of_ifexp(self, node: ast.IfExp, into: tuple[Into, ...]) -> Value:
        """Return one of two values by a condition, of which only the chosen one is computed."""
        test = self.value(node.test)
        if isinstance(test, Known):
            return self.value(node.body if test.value else node.orelse, into)
        before = len(self.lines)
        yes, no = self.value(node.body), self.value(node.orelse)
        kinds = self.kind_of(yes), self.kind_of(no)
        kind = join_types(*kinds)
        if kind is None:
            self.fail("both values of a condition differ in their types", "give both the same type")
        if isinstance(kind, Number) and len(self.lines) == before:
            return self._chosen(self.condition(test), yes, no, kind)
        del self.lines[before:]
        place = self.variable(into[0], kind, "chosen") if not isinstance(kind, Number) else None
        if place is None:
            name = self.names.fresh(into[0].name or "chosen")
            self.emit(f"{self.declarator(kind, name)};", name)
        target: Value = place if place is not None else Computed(name, kind)
        with self.block(f"if ({self.condition(test).text})"):
            self.store(target, self.value(node.body, (Into("", place),)))
        self.lines.pop()
        with self.block("} else"):
            self.store(target, self.value(node.orelse, (Into("", place),)))
        return target
