"""Places in a description, followed through the schema that pydantic keeps of each class.

What pydantic puts into a place beside the keys of the file (the tag of a kind, the name of a member of a union) is left
out, whatever way a kind is chosen.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel

from layflat.description.quantity import Quantity

Steps = tuple[int | str, ...]
Schema = dict[str, Any]

INNER = ("schema", "python_schema", "strict_schema")  # keys under which a schema that wraps another keeps it


@dataclass(frozen=True)
class Place:
    """Where something stands in a file."""

    steps: Steps  # keys, and numbers of items, from the outside in
    known: tuple[str, ...] = ()  # keys that may stand there, if it is a table
    size: int | None = None  # values that have to stand there, if it is a list of so many
    quantity: Quantity | None = None  # its kind, if it has one

    def __str__(self) -> str:
        return ".".join(map(str, self.steps))


@dataclass
class Walk:
    """The way through pydantic's schema of a class."""

    model: type[BaseModel]
    definitions: dict[str, Schema] = field(default_factory=dict)

    def to(self, location: Sequence[int | str]) -> Place:
        """Return the place in a file of what pydantic found somewhere."""
        node: Schema = dict(self.model.__pydantic_core_schema__)
        steps: list[int | str] = []
        above: Schema = {}
        for step in location:
            if step == "[key]":  # pydantic's own mark of a table's key
                continue
            here, _ = self._opened(node)
            node, written = self._below(here, step)
            if written:
                steps.append(step)
                above = here
        here, quantity = self._opened(node)
        size = len(above["items_schema"]) if above.get("type") == "tuple" else None
        return Place(tuple(steps), _keys(here) or _keys(above), size, quantity)

    def _opened(self, node: Schema) -> tuple[Schema, Quantity | None]:
        """What a schema wraps, and the quantity that a wrapper tells of."""
        quantity = None
        while node:
            quantity = (node.get("metadata") or {}).get("quantity", quantity)
            if node.get("type") == "definitions":
                self.definitions |= {one["ref"]: one for one in node["definitions"]}
            if node.get("type") == "definition-ref":
                node = self.definitions.get(node["schema_ref"], {})
                continue
            inner = next((node[key] for key in INNER if isinstance(node.get(key), dict)), None)
            if inner is None:
                return node, quantity
            node = inner
        return node, quantity

    def _below(self, here: Schema, step: int | str) -> tuple[Schema, bool]:
        """The schema under a step, and whether the step is one in the file too."""
        kind = here.get("type")
        if kind == "tagged-union":
            choice = here["choices"].get(step, {})
            return here["choices"][choice] if isinstance(choice, str) else choice, False
        if kind == "union":
            members = [one if isinstance(one, tuple) else (one, None) for one in here["choices"]]
            named = [one for one, label in members if label == step or self._label(one) == step]
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
        cls = node.get("cls")
        return cls.__name__ if cls is not None else str(node.get("type", ""))


def _fields(here: Schema) -> dict[str, Schema]:
    """Fields by the keys that they have in the file."""
    fields = here.get("fields")
    if not isinstance(fields, dict):
        return {}
    return {str(one.get("validation_alias", name)): one for name, one in fields.items()}


def _keys(here: Schema) -> tuple[str, ...]:
    return tuple(_fields(here)) if here.get("type") == "model-fields" else ()
