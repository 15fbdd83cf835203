"""Nested tuples of numbers as structs of C: every field with its name, and its unit and meaning as the class states it.

A struct holds the numbers of a tuple in order, and nothing else: it is the tuple's row of numbers.
"""

import inspect
import io
import re
import tokenize
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from layflat.lanes import leaves

C_KEYWORDS = frozenset(
    [
        "auto", "bool", "break", "case", "catch", "char", "class", "const", "constexpr", "continue", "default",
        "delete", "do", "double", "else", "enum", "explicit", "export", "extern", "false", "float", "for",
        "friend", "goto", "if", "inline", "int", "int32_t", "int64_t", "long", "mutable", "namespace", "new",
        "nullptr", "operator", "private", "protected", "public", "register", "restrict", "return", "short",
        "signed", "sizeof", "static", "static_assert", "struct", "switch", "template", "this", "throw", "true",
        "try", "typedef", "typename", "union", "unsigned", "using", "virtual", "void", "volatile", "while",
    ]
)  # fmt: skip
"""Names that C or C++ keeps for itself, or a header uses."""


@dataclass(frozen=True)
class StructField:
    """StructField of a struct: a number, a struct, or an array of either."""

    name: str
    struct: "Struct | None" = None  # None: numbers
    count: int | None = None  # of an array's items; None: a single one
    comment: str = ""  # unit and meaning
    number: str = ""  # C's type of its numbers; empty: that of the precision


@dataclass(frozen=True)
class Struct:
    """Struct of C."""

    name: str
    fields: tuple[StructField, ...]
    comment: str = ""

    @property
    def size(self) -> int:
        """Number of numbers in it."""
        return sum((1 if one.struct is None else one.struct.size) * (one.count or 1) for one in self.fields)

    def nested(self) -> Iterator["Struct"]:
        """Yield the structs that it needs, each once and after those that it needs itself, and it last."""
        found: dict[Struct, None] = {}
        for one in self.fields:
            if one.struct is not None:
                found |= dict.fromkeys(one.struct.nested())
        yield from found
        yield self


class StructNames:
    """Names of structs: that of the tuple's class, with a number where classes of one name differ in their fields.

    Args:
        prefix: prefix of all names.
        outer: names that only structs of arguments have; a part of such a name belongs to a joint.
        comments: unit and meaning of fields, by class and field, in place of the comments in the class's source.
    """

    def __init__(
        self,
        prefix: str,
        outer: frozenset[str] = frozenset(),
        comments: Mapping[type, Mapping[str, str]] = MappingProxyType({}),
    ) -> None:
        self._prefix, self._outer, self._known = prefix, outer, dict[str, list[tuple[StructField, ...]]]()
        self._comments = comments

    def comments(self, kind: type) -> Mapping[str, str]:
        """Return unit and meaning of the fields of a class."""
        return self._comments.get(kind) or field_comments(kind)

    def struct_name(self, name: str, fields: tuple[StructField, ...], *, outer: bool) -> str:
        """Return the name of a struct.

        Args:
            name: name without prefix.
            fields: its fields, by which structs of one name differ.
            outer: whether it is the struct of an argument.
        """
        if not outer and name in self._outer:
            name = f"joint_{name}"
        known = self._known.setdefault(name, [])
        if fields not in known:
            known.append(fields)
        number = known.index(fields)
        return f"{self._prefix}_{name}{number + 1 if number else ''}"


def struct_of(value: Any, names: StructNames, name: str = "", comment: str = "") -> Struct:
    """Return the struct of a nested tuple of numbers.

    Args:
        value: the tuple; of its numbers only the structure counts.
        names: names of structs so far.
        name: name without prefix; default: that of the class.
        comment: description; default: that of the class.
    """
    comments = names.comments(type(value))
    labels = getattr(value, "_fields", [f"item_{i}" for i in range(len(value))])
    items = zip(labels, value, strict=True)
    fields = tuple(_field(c_name(label), item, names, comments.get(label, "")) for label, item in items if _count(item))
    described = comment or (inspect.getdoc(type(value)) or "").split("\n")[0].rstrip(".")
    plain = not hasattr(value, "_fields")
    own = snake_case("group" if plain else type(value).__name__)
    return Struct(names.struct_name(name or own, fields, outer=bool(name)), fields, described)


def _field(name: str, item: Any, names: StructNames, comment: str) -> StructField:
    if not isinstance(item, tuple):
        return StructField(name, comment=comment, number=number_type(item))
    if type(item) is not tuple:
        return StructField(name, struct_of(item, names), comment=comment)
    if not any(isinstance(one, tuple) for one in item):
        return StructField(name, count=len(item), comment=comment, number=number_type(item[0]))
    structs = {struct_of(one, names) if isinstance(one, tuple) else None for one in item}
    if len(structs) == 1:
        return StructField(name, structs.pop(), len(item), comment)
    return StructField(name, struct_of(item, names), comment=comment)


def number_type(leaf: Any) -> str:
    """Return C's type of a number if it is another than that of the precision, else ""."""
    return str(getattr(leaf, "c_type", ""))


def _count(item: Any) -> int:
    return sum(1 for _ in leaves(item))


def c_name(name: str) -> str:
    """Return a name as an identifier of C."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII).strip("_") or "unnamed"
    if plain[0].isdigit():
        return f"n{plain}"
    return f"{plain}_" if plain in C_KEYWORDS else plain


def snake_case(name: str) -> str:
    """Return the name of a class in lower case, its words parted by underscores."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower().strip("_")


def field_comments(kind: Any) -> dict[str, str]:
    """Return the comment behind each field of a class in its source: its unit and meaning; nothing without source."""
    try:
        source = inspect.getsource(kind)
    except (OSError, TypeError):
        return {}
    fields, comments, name = set(getattr(kind, "_fields", ())), dict[str, str](), ""
    for token in tokenize.generate_tokens(io.StringIO(inspect.cleandoc(source)).readline):
        if (
            token.type == tokenize.NAME
            and token.string in fields
            and token.line.lstrip().startswith(f"{token.string}:")
        ):
            name = token.string
        elif token.type == tokenize.COMMENT and name:
            comments.setdefault(name, token.string.lstrip("# "))
    return comments
