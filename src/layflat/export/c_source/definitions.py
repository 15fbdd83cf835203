"""Structs and constants of a program."""

import math
import re
from typing import Any

from layflat.export.c_source.c_types import (
    DOUBLE_TYPE,
    INT_TYPE,
    REAL_TYPE,
    Number,
    Record,
    Type,
    skeleton,
    type_of_tuple,
)
from layflat.export.c_source.sources import NamedConstant, named_constant
from layflat.export.c_source.values import Known
from layflat.export.layout import Struct, snake_case, struct_of
from layflat.lanes import leaves

C_NUMBERS = {
    "double": {REAL_TYPE: "double", DOUBLE_TYPE: "double"},
    "single": {REAL_TYPE: "float", DOUBLE_TYPE: "double"},
}


class Definitions:
    """Structs and constants of C.

    Args:
        api: interface whose structs the program shares.
        precision: "double" or "single".
    """

    def __init__(self, api: Any, precision: str) -> None:
        self.api, self.precision = api, precision
        self.constants: dict[str, tuple[NamedConstant, Any]] = {}  # that laws name, with their values
        self.used_constants: dict[str, Type] = {}
        self.structs: dict[Struct, None] = {}
        self._types: dict[Type, str] = {}

    def share(self, kind: Type, struct: Struct) -> None:
        """Note that a type is a struct of the interface."""
        self._types[kind] = struct.name

    def c_type(self, kind: Type) -> str:
        """Return C's type of a number, or of a struct, which is defined once."""
        if isinstance(kind, Number):
            return C_NUMBERS[self.precision].get(kind, kind.name.removeprefix("real "))
        if kind not in self._types:
            struct = struct_of(skeleton(kind), self.api.names)
            self.structs |= dict.fromkeys(struct.nested())
            self._types[kind] = struct.name
        return self._types[kind]

    def struct_variable(self, kind: Type, name: str) -> str:
        """Return a name for a variable with a struct."""
        return snake_case(kind.cls.__name__) if isinstance(kind, Record) else name

    def constant_name(self, module: str, name: str, value: Any) -> str:
        """Return the name in C of a constant; "" where it has none.

        Args:
            module: module of the law that sees it.
            name: its name there.
            value: its value.
        """
        is_tuple = isinstance(value, tuple) and hasattr(value, "_fields") and _holds_floats(value)
        if (
            isinstance(value, bool)
            or not (isinstance(value, int | float) or is_tuple)
            or getattr(math, name, None) is value
        ):
            return ""
        constant = named_constant(module, name)
        if constant is None:
            return ""
        known = self.constants.setdefault(constant.name, (constant, value))
        if known[0].module == constant.module:
            return constant.name
        own = f"{constant.module.rpartition('.')[2].upper()}_{constant.name.strip('_')}"
        self.constants[own] = constant, value
        return own

    def constant_text(self, value: Known, kind: Type) -> str:
        """Return the expression of a constant by its name in the type of a number or struct; "" where there is none."""
        text = value.text
        if not text or (kind == INT_TYPE) != (isinstance(value.value, int)):
            return ""
        if self.precision == "single" and (
            kind == DOUBLE_TYPE or text not in self.constants or isinstance(kind, Record)
        ):
            return ""
        for name in _constant_names(text):
            constant = self.constants[name][1]
            own = (
                type_of_tuple(constant)
                if isinstance(constant, tuple)
                else INT_TYPE
                if isinstance(constant, int)
                else REAL_TYPE
            )
            self.used_constants[name] = own
        return text


def _constant_names(text: str) -> set[str]:
    return set(re.findall(r"(?<![\w.])[A-Za-z_]\w*", text))


def _holds_floats(value: tuple[Any, ...]) -> bool:
    return any(True for _ in leaves(value)) and all(isinstance(leaf, float) for leaf in leaves(value))
