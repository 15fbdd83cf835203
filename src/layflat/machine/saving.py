"""Machines as description files: every value with its unit and its source."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from layflat.description.change import annotation_at, quantity_of, value_at
from layflat.description.quantity import Quantity
from layflat.description.tables import Plain, Sources, overlay
from layflat.files import write_text
from layflat.machine.listing import to_toml
from layflat.machine.model import Machine

UNIT_DIGITS = 12  # significant digits of a value in the unit that people use


def save_machine(machine: Machine, path: Path) -> Path:
    """Write the complete description of a machine to a TOML file that `load` reads, and return the path.

    Raises:
        OutputError: the file can't be written.
    """
    return write_text(path, description_text(machine))


def description_text(machine: Machine) -> str:
    """Return a machine as TOML text from which it can be loaded with every value as it was, to the last bit."""
    whole = json.loads(machine.model_dump_json(exclude_none=True))
    own = json.loads(machine.model_dump_json(exclude_none=True, exclude_defaults=True))
    plain = overlay(_with_sources(whole, machine.provenance, ""), own) if machine.provenance else whole
    return to_toml(_with_usual_units(machine, plain, ""), machine.provenance)


def _with_sources(table: Plain, sources: Sources, path: str) -> Plain:
    """Return the values that have a source, or are in a part that has one; all others are defaults."""
    kept: Plain = {}
    for key, value in table.items():
        here = f"{path}.{key}".lstrip(".")
        if here in sources:
            kept[key] = value
        elif isinstance(value, dict):
            kept[key] = _with_sources(value, sources, here)
    return kept


def _with_usual_units(machine: Machine, value: Any, path: str) -> Any:
    """Return a value of a description in which texts have usual units where those give the same bits.

    Empty tables and lists are left out.
    """
    if isinstance(value, Mapping):
        below = {key: _with_usual_units(machine, item, f"{path}.{key}".lstrip(".")) for key, item in value.items()}
        return {key: item for key, item in below.items() if item not in ({}, [])}
    if isinstance(value, list):
        return [_with_usual_units(machine, item, f"{path}.{number}") for number, item in enumerate(value)]
    quantity = quantity_of(annotation_at(machine, path)) if isinstance(value, str) else None
    return value if quantity is None else _exact_text(quantity, float(value_at(machine, path)), value)


def _exact_text(quantity: Quantity, value: float, text: str) -> str:
    """Return a value in the unit of the quantity's example, or the text in SI units if that is not exact."""
    usual = quantity.text(value, quantity.example.partition(" ")[2], UNIT_DIGITS)
    return usual if quantity.convert(usual) == value else text
