"""Text of a program of C: its constants, structs and functions, in the order of the modules that they come from."""

import inspect
import sys
from collections.abc import Iterable, Iterator
from typing import Any

from layflat.export.c_source.c_types import INT_TYPE, Number, Record, Type, is_array, item_type, leaf_count, parts_of
from layflat.export.c_source.function import CFunction
from layflat.export.c_source.lines import INDENT_TEXT, block_comment, broken, read_names, render
from layflat.export.c_source.program import Program
from layflat.export.c_source.values import c_field
from layflat.export.layout import Struct
from layflat.export.numbers import c_number

COMMENT_COLUMN = 56  # at which comments behind constants begin, at least
MAX_COLUMNS = 120

HELPER_TEXTS = {
    "min_{name}": """/* Return the lesser of two numbers: the first of equal ones, and the first where one is NAN. */
static {real} min_{name}({real} first, {real} second)
{{
    return (second < first) ? second : first;
}}""",
    "max_{name}": """/* Return the greater of two numbers: the first of equal ones, and the first where one is NAN. */
static {real} max_{name}({real} first, {real} second)
{{
    return (second > first) ? second : first;
}}""",
    "floor_divide": """/* Return the quotient of two integers, rounded down. */
static int floor_divide(int dividend, int divisor)
{{
    const int quotient = dividend / divisor;
    return ((dividend % divisor != 0) && ((dividend < 0) != (divisor < 0))) ? quotient - 1 : quotient;
}}""",
    "floor_modulo": """/* Return the remainder of the quotient of two integers, rounded down. */
static int floor_modulo(int dividend, int divisor)
{{
    const int remainder = dividend % divisor;
    return ((remainder != 0) && ((remainder < 0) != (divisor < 0))) ? remainder + divisor : remainder;
}}""",
}


def reachable(program: Program, names: Iterable[str]) -> list[CFunction]:
    """Return the functions that some call, directly or not, each after those that it calls.

    Args:
        program: the program.
        names: names of functions.
    """
    by_name = {function.name: function for function in program.functions.values()}
    wanted, waiting = set[str](), [name for name in names if name in by_name]
    while waiting:
        name = waiting.pop()
        if name not in wanted:
            wanted.add(name)
            waiting += by_name[name].called
    return [function for name, function in by_name.items() if name in wanted]


def words_of(function: CFunction) -> set[str]:
    """Return the names of variables and functions in a function's lines."""
    return {word for line in function.lines if not line.comment for word in read_names(line.text)}


def by_module(functions: list[CFunction]) -> dict[str, list[CFunction]]:
    """Return functions by the modules of their laws, a module after those that its functions call."""
    modules = {function.name: function.module for function in functions}
    groups: dict[str, list[CFunction]] = {}
    for function in functions:
        groups.setdefault(function.module, []).append(function)
    needs = {
        module: {modules[other] for one in members for other in one.called} - {module}
        for module, members in groups.items()
    }
    ordered: dict[str, list[CFunction]] = {}

    def place(module: str, above: frozenset[str]) -> None:
        for other in sorted(needs[module] - above - {module}, key=list(groups).index):
            if other not in ordered:
                place(other, above | {module})
        ordered.setdefault(module, groups[module])

    for module in groups:
        place(module, frozenset())
    return ordered


def program_text(program: Program, entries: dict[str, list[str]]) -> Iterator[str]:
    """Yield the lines of constants, helping functions, structs and functions.

    Args:
        program: the program.
        entries: lines of the entries' functions, which come last, by their names.
    """
    last = [line for lines in entries.values() for line in lines]
    functions = reachable(program, {word for line in last for word in read_names(line)})
    words = {word for one in functions for word in words_of(one)} | {word for line in last for word in read_names(line)}
    constants = [program.c_type(kind) for name, kind in program.used_constants.items() if name in words]
    yield from struct_lines(program, functions, last, constants)
    yield from constant_lines(program, words)
    yield from helper_lines(program, words)
    groups = by_module(functions)
    yield from prototype_lines(program, groups)
    for module, members in groups.items():
        yield ""
        yield from module_comment(module)
        for function in members:
            yield ""
            yield from function_lines(program, function)
    for lines in entries.values():
        yield ""
        yield from lines


def constant_lines(program: Program, words: set[str]) -> Iterator[str]:
    """Yield the definitions of named constants, with their comments, by the modules that define them."""
    used = {
        name: program.constants[name] for name in program.constants if name in words and name in program.used_constants
    }
    for module in dict.fromkeys(constant.module for constant, _ in used.values()):
        yield ""
        yield f"/* Constants of {module}. */"
        for name, (constant, value) in used.items():
            if constant.module == module:
                yield from _constant_line(program, name, value, constant.comment)


def _constant_line(program: Program, name: str, value: Any, comment: str) -> Iterator[str]:
    """Yield the definition of a constant with its comment."""
    kind = program.used_constants[name]
    number = _constant_value(program, value, kind)
    text = f"static const {program.c_type(kind)} {name} = {number};"
    if not comment:
        yield text
        return
    line = f"{text:<{COMMENT_COLUMN}} /* {comment.replace('*/', '* /')} */"
    if len(line) <= MAX_COLUMNS:
        yield line
        return
    yield from block_comment(comment)
    yield text


def _constant_value(program: Program, value: Any, kind: Type) -> str:
    """Return the initializer of a constant."""
    if isinstance(kind, Number):
        return str(value) if kind == INT_TYPE else c_number(float(value), program.c_type(kind))
    parts = zip(value._fields, value, parts_of(kind), strict=True)
    return (
        f"{{{', '.join(f'.{c_field(name)} = {_constant_value(program, item, part)}' for name, item, part in parts)}}}"
    )


def helper_lines(program: Program, words: set[str]) -> Iterator[str]:
    """Yield the helping functions that are called."""
    for name, text in HELPER_TEXTS.items():
        for kind, real in (("int", "int"), ("double", "double"), ("real", program.api.real)):
            own = name.format(name=kind)
            if own in words and (own != name or kind == "int"):
                yield ""
                yield from text.format(name=kind, real=real).split("\n")


def struct_lines(program: Program, functions: list[CFunction], last: list[str], constants: list[str]) -> Iterator[str]:
    """Yield the definitions of the structs that a program uses, beyond those of the header.

    Args:
        program: the program.
        functions: its functions.
        last: lines of the entries.
        constants: types of the constants.
    """
    text = "\n".join([*last, *(line for one in functions for line in function_lines(program, one))])
    names, public = read_names(text) | set(constants), set(program.api.structs())
    needed: dict[Struct, None] = {}
    for struct in program.structs:
        if struct.name in names:
            needed |= dict.fromkeys(struct.nested())
    for struct in needed:
        if struct not in public:
            yield ""
            yield from program.api.definition(struct)


def prototype_lines(program: Program, groups: dict[str, list[CFunction]]) -> Iterator[str]:
    """Yield declarations of the functions that are called before they are defined."""
    functions = {one.name: one for members in groups.values() for one in members}
    places = {name: i for i, name in enumerate(functions)}
    early = {
        word
        for i, one in enumerate(functions.values())
        for word in words_of(one)
        if word in places and places[word] > i
    }
    if early:
        yield ""
    for name, function in functions.items():
        if name in early:
            yield from broken(f"{head(program, function)};", INDENT_TEXT)


def module_comment(module: str) -> Iterator[str]:
    """Yield the comment about a module: its name and docstring."""
    text = inspect.getdoc(sys.modules[module]) if module in sys.modules else None
    yield from block_comment(f"{module.replace('.', '/')}.py" + (f"\n\n{text}" if text else ""))


def function_lines(program: Program, function: CFunction) -> Iterator[str]:
    """Yield the definition of a function."""
    if function.comment:
        yield from block_comment(function.comment)
    yield from broken(head(program, function), INDENT_TEXT)
    yield "{"
    yield from render(function.lines)
    yield "}"


def head(program: Program, function: CFunction) -> str:
    """Return the declaration of a function, without semicolon."""
    parameters = [
        parameter(program, one.name, one.kind, constant=not one.changed)
        for part in function.parameters
        for one in part
        if one.read
    ]
    if function.mode != "value":
        parameters += [
            parameter(program, one.name, one.kind, constant=False) for one in function.results if leaf_count(one.kind)
        ]
    result = program.c_type(function.kind) if function.mode == "value" else "void"
    return f"static {result} {function.name}({', '.join(parameters) or 'void'})"


def parameter(program: Program, name: str, kind: Type, *, constant: bool) -> str:
    """Return the declaration of a parameter.

    Args:
        program: the program.
        name: its name.
        kind: its type.
        constant: whether the function only reads it.
    """
    if isinstance(kind, Number):
        return f"{program.c_type(kind)} {name}" if constant else f"{program.c_type(kind)} *{name}"
    const = "const " if constant else ""
    if isinstance(kind, Record) or not is_array(kind):
        return f"{const}{program.c_type(kind)} *{name}"
    sizes = ""
    while is_array(kind):
        sizes += f"[{len(parts_of(kind))}]"
        kind = item_type(kind)
    return f"{const}{program.c_type(kind)} {name}{sizes}"
