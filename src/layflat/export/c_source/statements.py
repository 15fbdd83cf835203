"""Statements of laws as statements of C."""

import ast

from layflat.export.c_source.c_types import INT_TYPE
from layflat.export.c_source.lines import Line
from layflat.export.c_source.storage import NO_PLACE, Into
from layflat.export.c_source.values import Computed, Known, Level, Stored, Value
from layflat.export.c_source.variables import Variables
from layflat.export.layout import snake_case


class Statements(Variables):
    """Statements of a function."""

    ended = False  # whether the last statement leaves this block

    def statements(self, nodes: list[ast.stmt]) -> None:
        """Add the lines of statements."""
        for node in nodes:
            if self.ended:
                return
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                continue
            self.node = node
            self.comment_on(node)
            method = getattr(self, f"add_{type(node).__name__.lower()}", None)
            if method is None:
                self.fail(f"{type(node).__name__.lower()!r} has no counterpart in C", "use if, for, while and names")
            method(node)

    def comment_on(self, node: ast.stmt) -> None:
        """Add the comments that stand before a statement, or on it."""
        simple = not isinstance(node, ast.If | ast.For | ast.While)
        last = (node.end_lineno or node.lineno) if simple else node.lineno
        for line in range(node.lineno, last + 1):
            if line in self.source.comments:
                self.lines.append(Line(self.source.comments[line], self.depth, comment=True))

    def add_pass(self, node: ast.Pass) -> None:
        """Add nothing."""

    def add_expr(self, node: ast.Expr) -> None:
        """Add a call whose result is not used."""
        self.value(node.value)

    def add_assign(self, node: ast.Assign) -> None:
        """Add an assignment."""
        for target in node.targets:
            self.assign_all(target, node.value)

    def add_annassign(self, node: ast.AnnAssign) -> None:
        """Add an assignment with a type."""
        if node.value is not None:
            self.assign_all(node.target, node.value)

    def add_augassign(self, node: ast.AugAssign) -> None:
        """Add an operation on a variable."""
        value = self._operation(self.value(node.target), node.op, self.value(node.value))
        self.assign_pairs([(node.target, value)])

    def assign_all(self, target: ast.expr, node: ast.expr) -> None:
        """Assign the value of an expression."""
        if isinstance(target, ast.Tuple) and isinstance(node, ast.Tuple) and len(target.elts) == len(node.elts):
            pairs = []
            for one, part in zip(target.elts, node.elts, strict=True):
                pairs += self.pairs(one, self.value(part, self.places(one)))
            self.assign_pairs(pairs)
        else:
            self.assign_pairs(self.pairs(target, self.value(node, self.places(target))))

    def places(self, target: ast.expr) -> tuple[Into, ...]:
        """Return the places for results by the names that they are assigned to."""
        targets = target.elts if isinstance(target, ast.Tuple) else [target]
        return tuple(self.place_for(one.id) if isinstance(one, ast.Name) else NO_PLACE for one in targets)

    def assign_pairs(self, pairs: list[tuple[ast.expr, Value]]) -> None:
        """Assign values to names and items of slots, all computed before the first is assigned."""
        written = [self.written_variable(target) for target, _ in pairs]
        for k, (target, value) in enumerate(pairs):
            if isinstance(value, Computed) and set(filter(None, written[:k])) & self.texts(value):
                name = self.names.fresh(f"next_{label_of(target)}")
                self.emit(f"const {self.declarator(value.kind, name)} = {value.text};", name)
                pairs[k] = target, Computed(name, value.kind)
        for target, value in pairs:
            if isinstance(target, ast.Name):
                self.bind(target.id, value)
            elif isinstance(target, ast.Subscript):
                place = self.items_at(target)
                self.store(place, value, "" if self.is_parameter(target) else getattr(place, "text", "").split("[")[0])
            else:
                self.fail(f"{ast.unparse(target)!r} is assigned", "assign names, and items of slots")

    def is_parameter(self, target: ast.Subscript) -> bool:
        """Return whether an item of an argument is assigned."""
        return isinstance(target.value, ast.Name) and target.value.id in self.parameters

    def written_variable(self, target: ast.expr) -> str:
        """Return the variable of C that an assignment writes; "" if it declares one."""
        node = target.value if isinstance(target, ast.Subscript) else target
        if not isinstance(node, ast.Name):
            return ""
        bound = (self.scope_of(node.id) or {}).get(node.id)
        if isinstance(target, ast.Name) and node.id not in self.facts.changing:
            return ""
        return bound.text.split("[")[0] if isinstance(bound, Computed | Stored) else ""

    def declare_outliving(self, node: ast.stmt) -> None:
        """Declare the variables that a block assigns and that are read behind it."""
        stored = {one.id for one in ast.walk(node) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)}
        for name in sorted(stored & self.facts.outliving):
            if self.scope_of(name) is None:
                self.scopes[-1][name] = self.declared(name, self.facts.changing[name])

    def inside(self, nodes: list[ast.stmt], bound: dict[str, Value] | None = None) -> None:
        """Add statements in a scope of their own."""
        self.scopes.append(bound or {})
        self.statements(nodes)
        self.scopes.pop()
        self.ended = False

    def add_if(self, node: ast.If) -> None:
        """Add a choice; one that is known is made now."""
        test = self.value(node.test)
        if isinstance(test, Known):
            self.statements(node.body if test.value else node.orelse)
            return
        self.declare_outliving(node)
        with self.block(f"if ({self.condition(test).text})"):
            self.inside(node.body)
        if node.orelse:
            self.lines.pop()
            with self.block("} else"):
                self.inside(node.orelse)

    def add_for(self, node: ast.For) -> None:
        """Add a loop over a range; one with a single round is none."""
        call = node.iter
        is_range = isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range"
        if not is_range or not isinstance(node.target, ast.Name) or node.orelse:
            self.fail(f"for ... in {ast.unparse(call)} has no counterpart in C", "use for i in range(n)")
        assert isinstance(call, ast.Call)
        ends = [self.value(one) for one in call.args]
        if len(ends) > 2:
            self.fail("a range with a step has no counterpart in C", "use range(n) and compute the index")
        first, last = (Known(0), ends[0]) if len(ends) == 1 else ends
        if isinstance(first, Known) and isinstance(last, Known) and last.value - first.value <= 1:
            if last.value > first.value:
                self.bind(node.target.id, first)
                self.statements(node.body)
            return
        self.declare_outliving(node)
        name = node.target.id
        with self.names.counter("" if name == "_" else name) as counter:
            low, high = self.number(first, INT_TYPE).text, self.number(last, INT_TYPE).text
            with self.block(f"for (int {counter} = {low}; {counter} < {high}; {counter}++)"):
                self.inside(node.body, {name: Computed(counter, INT_TYPE)})

    def add_while(self, node: ast.While) -> None:
        """Add a loop with a condition."""
        self.declare_outliving(node)
        if node.orelse:
            self.fail("else of a loop has no counterpart in C", "use if")
        before = len(self.lines)
        head = len(self.lines)
        self.emit("while (true) {")
        self.depth += 1
        test = self.condition(self.value(node.test))
        if len(self.lines) == before + 1:
            self.lines[head] = Line(f"while ({test.text}) {{", self.depth - 1)
        else:
            with self.block(f"if (!{self.paren(test, Level.AND + 10)})"):
                self.emit("break;")
        self.inside(node.body)
        self.depth -= 1
        self.emit("}")

    def add_break(self, node: ast.Break) -> None:  # noqa: ARG002
        """Leave a loop."""
        self.emit("break;")
        self.ended = True

    def add_continue(self, node: ast.Continue) -> None:  # noqa: ARG002
        """Begin the next round of a loop."""
        self.emit("continue;")
        self.ended = True


def label_of(node: ast.AST | None) -> str:
    """Return a name for the value of an expression; "" where it suggests none."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        return node.attr
    if isinstance(node, ast.Subscript):
        return f"{label_of(node.value)}_{label_of(node.slice)}".strip("_")
    if isinstance(node, ast.Call):
        name = label_of(node.func).strip("_")
        return snake_case(name) if name != "each" else label_of(node.args[0]).strip("_")
    return ""
