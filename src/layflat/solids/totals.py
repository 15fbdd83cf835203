"""Mass and cost of a machine as it would be built: from sizes by rules, without solids."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from layflat.errors import DesignError
from layflat.solids.assembly import assemble
from layflat.solids.cost import cost_of
from layflat.solids.parts_list import list_parts
from layflat.solids.volumes import mass_of

if TYPE_CHECKING:
    from layflat.machine import Machine
    from layflat.solids.cost import Prices
    from layflat.solids.parts_list import PartsList


class BuiltTotals(NamedTuple):
    """Mass and cost of a machine as it would be built."""

    mass: float  # kg
    cost: float  # in the currency of the prices; not a number without prices


def list_built_parts(machine: Machine) -> PartsList:
    """Return the parts list of a machine.

    Raises:
        DesignError: no size keeps a rule, or a joint is of a kind without solids; the message says why.
    """
    assembly = assemble(machine)
    for name, why in assembly.omitted.items():
        raise DesignError(f"joint {name} has no solids", where=machine.origin, right=why)
    return list_parts(assembly.components, mass_of)


def built_totals(machine: Machine, prices: Prices | None = None) -> BuiltTotals:
    """Return mass and cost of a machine as it would be built; raise DesignError as `list_built_parts`."""
    parts = list_built_parts(machine)
    return BuiltTotals(parts.mass, float("nan") if prices is None else cost_of(parts, prices).total)
