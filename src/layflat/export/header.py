"""Headers of C: structs with every field's unit and meaning, functions, and the parameters of a machine as a table."""

from collections.abc import Iterable, Iterator
from math import inf, isinf, isnan
from typing import Any, NamedTuple

from layflat._version import __version__
from layflat.export.entries import Argument, Entry
from layflat.export.layout import Struct, StructNames, struct_of

C_REALS = {"double": "double", "single": "float"}
COMMENT_COLUMN = 56  # at which the comments of fields begin


class Constant(NamedTuple):
    """Number of a machine that a program needs, as a macro."""

    name: str
    value: float | int
    comment: str


class Table(NamedTuple):
    """Parameters of the machine as an initialised struct."""

    name: str
    like: Any  # tuple with the numbers
    comment: str


class Api:
    """Interface of C to entries: their structs by the tuples' structures.

    Args:
        prefix: prefix of all names.
        precision: "double" or "single".
        entries: the entries.
    """

    def __init__(self, prefix: str, precision: str, entries: Iterable[Entry]) -> None:
        self.prefix, self.real, self.entries = prefix, C_REALS[precision], tuple(entries)
        outer = {
            argument.struct_name for entry in self.entries for argument in entry.arguments if argument.like is not None
        }
        self._names, self._structs = StructNames(prefix, frozenset(outer)), dict[str, Struct]()
        for entry in self.entries:
            for argument in entry.arguments:
                if argument.like is not None:
                    self.struct(argument)

    def struct(self, argument: Argument) -> Struct:
        """Return the struct of an argument."""
        return self._structs.setdefault(
            argument.struct_name, struct_of(argument.like, self._names, argument.struct_name)
        )

    def structs(self) -> Iterator[Struct]:
        """Yield all structs, each after those that it needs."""
        found: dict[Struct, None] = {}
        for struct in self._structs.values():
            found |= dict.fromkeys(struct.nested())
        yield from found

    def prototype(self, entry: Entry) -> str:
        """Return the declaration of an entry's function, without semicolon."""
        taken = ",\n    ".join(self._parameter(argument) for argument in entry.arguments)
        return f"{'int32_t' if entry.result else 'void'} {self.prefix}_{entry.name}(\n    {taken})"

    def _parameter(self, argument: Argument) -> str:
        if argument.like is None:
            return f"{self.real if argument.number == 'real' else argument.number} {argument.name}"
        const = "" if argument.output else "const "
        items = "" if argument.rows is None else f"[{argument.rows}]"
        return (
            f"{const}{self.struct(argument).name} {argument.name}{items}"
            if items
            else (f"{const}{self.struct(argument).name} *{argument.name}")
        )

    def header(self, title: str, constants: Iterable[Constant], tables: Iterable[Table]) -> str:
        """Return the header.

        Args:
            title: the machine and the target, for the first comment.
            constants: macros.
            tables: parameters that `source` defines.
        """
        guard = f"{self.prefix.upper()}_H"
        lines = [f"/* {title}. Made by layflat {__version__}; changes belong in the machine's description. */"]
        lines += [f"#ifndef {guard}", f"#define {guard}", "", "#include <stdint.h>", ""]
        lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
        for one in constants:
            lines.append(
                f"#define {self.prefix.upper()}_{one.name} {number_text(one.value, self.real)} /* {one.comment} */"
            )
        for struct in self.structs():
            lines += ["", *self._definition(struct)]
        for table in tables:
            struct = self._structs[table.name]
            lines += ["", f"/* {table.comment} */", f"extern const {struct.name} {self.prefix}_default_{table.name};"]
        for entry in self.entries:
            lines += ["", *_function_comment(entry), f"{self.prototype(entry)};"]
        lines += ["", "#ifdef __cplusplus", "}", "#endif", "", f"#endif /* {guard} */", ""]
        return "\n".join(lines)

    def _definition(self, struct: Struct) -> Iterator[str]:
        if struct.comment:
            yield f"/* {c_comment(struct.comment)}. */"
        yield "typedef struct {"
        for field in struct.fields:
            kind = self._field_type(struct, field.name) if field.struct is None else field.struct.name
            declared = f"    {kind} {field.name}{'' if field.count is None else f'[{field.count}]'};"
            yield f"{declared:<{COMMENT_COLUMN}}/* {c_comment(field.comment)} */" if field.comment else declared
        yield f"}} {struct.name};"

    def _field_type(self, struct: Struct, name: str) -> str:
        return "int64_t" if struct.name == f"{self.prefix}_state" and name in {"step", "due"} else self.real

    def source(self, header: str, tables: Iterable[Table]) -> str:
        """Return the source file with the parameters of the machine.

        Args:
            header: name of the header file.
            tables: the parameters.
        """
        lines = ["#include <math.h>", "", f'#include "{header}"']
        for table in tables:
            struct = self._structs[table.name]
            lines += ["", f"const {struct.name} {self.prefix}_default_{table.name} ="]
            lines += [*_initializer(table.like, struct, self.real, ""), ";"]
            lines[-2:] = [lines[-2] + ";"]
        return "\n".join([*lines, ""])


def _function_comment(entry: Entry) -> Iterator[str]:
    yield f"/* {entry.comment}"
    for argument in entry.arguments:
        yield f"   {argument.name}: {argument.comment}."
    if entry.result:
        yield f"   Returns {entry.result}."
    yield "*/"


def _initializer(value: Any, struct: Struct, real: str, indent: str, name: str = "") -> Iterator[str]:
    """Yield the lines of a struct's initializer, with the names of its fields."""
    yield f"{indent}{name}{{"
    inner = indent + "    "
    items = [item for item in value if not isinstance(item, tuple) or any(True for _ in _numbers(item))]
    for field, item in zip(struct.fields, items, strict=True):
        label = f".{field.name} = "
        if field.struct is None and field.count is None:
            yield f"{inner}{label}{number_text(item, real)},"
        elif field.struct is None:
            yield f"{inner}{label}{{{', '.join(number_text(one, real) for one in item)}}},"
        elif field.count is None:
            lines = list(_initializer(item, field.struct, real, inner, label))
            yield from (*lines[:-1], f"{lines[-1]},")
        else:
            yield f"{inner}{label}{{"
            for one in item:
                lines = list(_initializer(one, field.struct, real, f"{inner}    "))
                yield from (*lines[:-1], f"{lines[-1]},")
            yield f"{inner}}},"
    yield f"{indent}}}"


def _numbers(value: Any) -> Iterator[Any]:
    for item in value:
        if isinstance(item, tuple):
            yield from _numbers(item)
        else:
            yield item


def number_text(value: float, real: str) -> str:
    """Return a number in C, exact in `real` ("double" or "float"): a whole number as itself, else in hexadecimal."""
    if isnan(value):
        return "NAN"
    if isinf(value):
        return "INFINITY" if value == inf else "-INFINITY"
    if isinstance(value, int) or value == float(f"{value:.6g}"):
        return f"{value:.6g}" if isinstance(value, int) else f"{float(value)!r}{'f' if real == 'float' else ''}"
    suffix = "f" if real == "float" else ""
    if value == int(value) and abs(value) < 1e6:
        return f"{int(value)}.0{suffix}"
    return f"{float_text(value)}{suffix}" if real == "float" else float(value).hex()


def float_text(value: float) -> str:
    """Return a number in nine digits, which single precision reads back to its nearest number."""
    return f"{value:.9e}"


def c_comment(text: str) -> str:
    """Return a text that ends no comment of C."""
    return text.replace("*/", "* /")
