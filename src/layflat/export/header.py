"""Headers of C: structs with every field's unit and meaning, functions, and the parameters of a machine as a table."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from layflat._version import __version__
from layflat.export.entries import Argument, Entry
from layflat.export.layout import Struct, StructField, StructNames, struct_of
from layflat.export.numbers import c_number
from layflat.lanes import leaves

C_REALS = {"double": "double", "single": "float"}
COMMENT_COLUMN = 56  # at which the comments of fields begin
MAX_COLUMNS = 120  # of a line


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
        comments: unit and meaning of fields, by class and field, in place of the comments in the class's source.
    """

    def __init__(
        self,
        prefix: str,
        precision: str,
        entries: Iterable[Entry],
        comments: Mapping[type, Mapping[str, str]] | None = None,
    ) -> None:
        self.prefix, self.real, self.entries = prefix, C_REALS[precision], tuple(entries)
        outer = {
            argument.struct_name for entry in self.entries for argument in entry.arguments if argument.like is not None
        }
        self.names, self._structs = StructNames(prefix, frozenset(outer), comments or {}), dict[str, Struct]()
        for entry in self.entries:
            for argument in entry.arguments:
                if argument.like is not None:
                    self.struct(argument)

    def struct(self, argument: Argument) -> Struct:
        """Return the struct of an argument."""
        return self._structs.setdefault(
            argument.struct_name, struct_of(argument.like, self.names, argument.struct_name)
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
        const, struct = "" if argument.output else "const ", self.struct(argument).name
        return f"{const}{struct} {'*' if argument.rows is None else ''}{argument.name}{_items(argument.rows)}"

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
                f"#define {self.prefix.upper()}_{one.name} {c_number(one.value, self.real)} /* {one.comment} */"
            )
        for struct in self.structs():
            lines += ["", *self.definition(struct)]
        for table in tables:
            struct = self._structs[table.name]
            lines += ["", f"/* {table.comment} */", f"extern const {struct.name} {self.prefix}_default_{table.name};"]
        for entry in self.entries:
            lines += ["", *_function_comment(entry), f"{self.prototype(entry)};"]
        lines += ["", "#ifdef __cplusplus", "}", "#endif", "", f"#endif /* {guard} */", ""]
        return "\n".join(lines)

    def definition(self, struct: Struct) -> Iterator[str]:
        """Yield the lines of a struct's definition."""
        if struct.comment:
            yield f"/* {c_comment(struct.comment)}. */"
        yield "typedef struct {"
        for field in struct.fields:
            kind = self._field_type(struct, field) if field.struct is None else field.struct.name
            declared = f"    {kind} {field.name}{_items(field.count)};"
            line = f"{declared:<{COMMENT_COLUMN}}/* {c_comment(field.comment)} */" if field.comment else declared
            if len(line) > MAX_COLUMNS:
                yield f"    /* {c_comment(field.comment)} */"
            yield declared if len(line) > MAX_COLUMNS else line
        yield f"}} {struct.name};"

    def _field_type(self, struct: Struct, field: StructField) -> str:
        if struct.name == f"{self.prefix}_progress":
            return "int64_t"
        is_count = struct.name == f"{self.prefix}_state" and field.name in {"step", "due"}
        return "int64_t" if is_count else field.number or self.real

    def source(self, header: str, tables: Iterable[Table], *, checked: bool = True) -> str:
        """Return the source file with the parameters of the machine, and checks of the structs' sizes.

        Args:
            header: name of the header file.
            tables: the parameters.
            checked: whether there is machine code, with which the structs' sizes have to agree.
        """
        lines = ["#include <math.h>", "", f'#include "{header}"']
        if checked:
            lines += ["", "/* The compiler lays the structs out as the machine code does, or stops here. */"]
        for struct in self.structs() if checked else ():
            size = f"{struct.size} * sizeof({self.real})"
            lines.append(f"typedef char {struct.name}_check[sizeof({struct.name}) == {size} ? 1 : -1];")
        for table in tables:
            struct = self._structs[table.name]
            lines += ["", f"const {struct.name} {self.prefix}_default_{table.name} ="]
            lines += _initializer(table.like, struct, self.real, "")
            lines[-1] += ";"
        return "\n".join([*lines, ""])


def _items(count: int | None) -> str:
    return "" if count is None else f"[{count}]"


def _function_comment(entry: Entry) -> Iterator[str]:
    yield f"/* {entry.comment}"
    for argument in entry.arguments:
        yield f"   {argument.name}: {argument.comment}."
    if entry.result:
        yield f"   Returns {entry.result}."
    yield "*/"


def _initializer(value: Any, struct: Struct, real: str, indent: str, name: str = "") -> Iterator[str]:
    """Yield the lines of a struct's initializer, with the names of its fields as comments, which C++ takes, too."""
    yield f"{indent}{{{name}"
    inner = indent + "    "
    items = [item for item in value if not isinstance(item, tuple) or any(True for _ in leaves(item))]
    for field, item in zip(struct.fields, items, strict=True):
        label = f" /* {field.name} */"
        if field.struct is None and field.count is None:
            yield f"{inner}{c_number(item, real)},{label}"
        elif field.struct is None:
            yield f"{inner}{{{', '.join(c_number(one, real) for one in item)}}},{label}"
        elif field.count is None:
            yield from _closed(_initializer(item, field.struct, real, inner, label))
        else:
            yield f"{inner}{{{label}"
            for one in item:
                yield from _closed(_initializer(one, field.struct, real, f"{inner}    "))
            yield f"{inner}}},"
    yield f"{indent}}}"


def _closed(lines: Iterable[str]) -> Iterator[str]:
    """Yield lines with a comma behind the last."""
    *first, last = lines
    yield from (*first, f"{last},")


def c_comment(text: str) -> str:
    """Return a text that ends no comment of C."""
    return text.replace("*/", "* /")
