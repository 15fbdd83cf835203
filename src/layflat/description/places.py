"""Locations in a file of pydantic's errors, by the schema that pydantic keeps of each class.

Steps of pydantic's locations that are no keys of the file (the tag of a kind, the name of a member of a union) are left
out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel

from layflat.description.quantity import Quantity

Steps = tuple[int | str, ...]
Schema = dict[str, Any]

WRAPPED_SCHEMA_KEYS = (
    "schema",
    "python_schema",
    "strict_schema",
)  # keys under which a schema that wraps another keeps it


@dataclass(frozen=True)
class FileLocation:
    """Location in a file, with its schema."""

    steps: Steps  # keys, and numbers of items, from the outside in
    valid_keys: tuple[str, ...] = ()  # valid keys: its own if it is a table, else those of its table
    size: int | None = None  # number of values, if it is a list of fixed length
    quantity: Quantity | None = None  # of the value, if it has one

    def __str__(self) -> str:
        return ".".join(map(str, self.steps))


@dataclass
class SchemaWalk:
    """Traversal of pydantic's schema of a class."""

    model: type[BaseModel]
    definitions: dict[str, Schema] = field(default_factory=dict)

    def locate(self, location: Sequence[int | str]) -> FileLocation:
        """Return the location in the file of a location in pydantic's error."""
        node: Schema = dict(self.model.__pydantic_core_schema__)
        steps: list[int | str] = []
        above: Schema = {}
        for step in location:
            if step == "[key]":  # pydantic's mark of a table's key
                continue
            here, _ = self._unwrap(node)
            node, in_file = self._below(here, step)
            if in_file:
                steps.append(step)
                above = here
        here, quantity = self._unwrap(node)
        size = len(above["items_schema"]) if above.get("type") == "tuple" else None
        return FileLocation(tuple(steps), _keys(here) or _keys(above), size, quantity)

    def _unwrap(self, node: Schema) -> tuple[Schema, Quantity | None]:
        """Return the innermost schema that a schema wraps, and the quantity of any wrapper; collect definitions."""
        quantity = None
        while node:
            quantity = (node.get("metadata") or {}).get("quantity", quantity)
            if node.get("type") == "definitions":
                self.definitions |= {schema["ref"]: schema for schema in node["definitions"]}
            if node.get("type") == "definition-ref":
                node = self.definitions.get(node["schema_ref"], {})
                continue
            inner = next((node[key] for key in WRAPPED_SCHEMA_KEYS if isinstance(node.get(key), dict)), None)
            if inner is None:
                return node, quantity
            node = inner
        return node, quantity

    def _below(self, here: Schema, step: int | str) -> tuple[Schema, bool]:
        """Return the schema below a step (empty if unknown), and whether the step is a key or item of the file."""
        kind = here.get("type")
        if kind == "tagged-union":
            choice = here["choices"].get(step, {})
            return here["choices"][choice] if isinstance(choice, str) else choice, False
        if kind == "union":
            members = [choice if isinstance(choice, tuple) else (choice, None) for choice in here["choices"]]
            named = [member for member, label in members if label == step or self._label(member) == step]
            return (named or [{}])[0], False
        if kind in {"model-fields", "typed-dict", "dataclass-args"}:
            return _fields(here).get(str(step), {}).get("schema", {}), True
        if kind == "dict":
            return here.get("values_schema", {}), True
        if kind == "tuple":
            items = here["items_schema"]
            return items[min(int(step), len(items) - 1)] if items else {}, True
        return here.get("items_schema") or {}, True

    def _label(self, node: Schema) -> str:
        """Return pydantic's name of a member of a union: that of its class, else of its type."""
        cls = node.get("cls")
        return cls.__name__ if cls is not None else str(node.get("type", ""))


def _fields(here: Schema) -> dict[str, Schema]:
    """Return the schemas of fields by their keys in the file."""
    fields = here.get("fields")
    if not isinstance(fields, dict):
        return {}
    return {str(schema.get("validation_alias", name)): schema for name, schema in fields.items()}


def _keys(here: Schema) -> tuple[str, ...]:
    return tuple(_fields(here)) if here.get("type") == "model-fields" else ()
