"""Parts list of an assembly: equal parts of all joints in one row, with numbers, masses, and where they belong."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING

from layflat.solids.blanks import blank_size
from layflat.solids.standard.materials import material

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable, Sequence

    from layflat.solids.component import Component

FLEXIBLE_TAGS = frozenset({"hose", "hinge", "strap"})  # tags of parts whose shape changes as the joint turns
NUMBER_STEP = 100  # numbers of bought parts begin after a full hundred
SIDE_LETTER = re.compile(r" ([A-Z])$")  # letter of a part's hose


@dataclass(frozen=True)
class ListedPart:
    """Row of a parts list: equal parts, wherever they are."""

    number: int
    components: tuple[Component, ...]
    mass: float  # of all, kg

    @property
    def name(self) -> str:
        """Name of the parts: that of all uses, or the common part of their names."""
        return common_name(self.names)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the uses of the parts."""
        return tuple(dict.fromkeys(one.name for one in self.components))

    @property
    def quantity(self) -> int:
        """Number of parts."""
        return sum(one.quantity for one in self.components)

    @property
    def mass_each(self) -> float:
        """Mass of one part, kg."""
        return self.mass / self.quantity

    @property
    def bought(self) -> bool:
        """True for parts that are bought ready."""
        return self.components[0].bought

    @property
    def making(self) -> str:
        """Process that makes the parts, or "bought"."""
        return self.components[0].making

    @property
    def material(self) -> str:
        """Grade of the material of made parts, designation of bought ones."""
        one = self.components[0]
        return one.designation if one.bought and one.designation else material(one.material).grade

    @property
    def stock(self) -> str:
        """Stock from which made parts are made; empty for bought ones."""
        return "" if self.bought else self.components[0].designation

    @property
    def size(self) -> str:
        """Size of the blank, or that which the component states."""
        one = self.components[0]
        return one.size if self.bought or (one.tags & FLEXIBLE_TAGS and one.size) else blank_size(one)

    @property
    def joints(self) -> dict[str, int]:
        """Number of parts by joint; the empty name is that of the arm."""
        counts: dict[str, int] = {}
        for one in self.components:
            counts[one.joint] = counts.get(one.joint, 0) + one.quantity
        return counts


@dataclass(frozen=True)
class PartsList:
    """Parts of an assembly: made parts from number 1 on, bought ones from 101 (or the next free hundred) on."""

    parts: tuple[ListedPart, ...]
    masses: dict[str, float]  # kg by joint; the empty name is that of the arm

    @property
    def made_mass(self) -> float:
        """Mass of all made parts, kg."""
        return sum(part.mass for part in self.parts if not part.bought)

    @property
    def bought_mass(self) -> float:
        """Mass of all bought parts, kg."""
        return sum(part.mass for part in self.parts if part.bought)

    @property
    def mass(self) -> float:
        """Mass of the assembly, kg."""
        return self.made_mass + self.bought_mass

    def part(self, component: Component) -> ListedPart:
        """Return the row of a component; raise KeyError if the list was made without it."""
        key = part_key(component)
        return next(part for part in self.parts if part_key(part.components[0]) == key)


def list_parts(components: Iterable[Component], mass: Callable[[Component], float]) -> PartsList:
    """Return the parts list of components.

    Args:
        components: of joints and arm, in the order in which they are put together; numbers follow it.
        mass: function that returns the mass of one part of a component, kg.
    """
    rows: dict[Hashable, list[Component]] = {}
    masses: dict[str, float] = {}
    weights: dict[Hashable, float] = {}
    for one in components:
        key, weight = part_key(one), mass(one) * one.quantity
        rows.setdefault(key, []).append(one)
        weights[key] = weights.get(key, 0.0) + weight
        masses[one.joint] = masses.get(one.joint, 0.0) + weight
    made = [key for key, row in rows.items() if not row[0].bought]
    bought = [key for key, row in rows.items() if row[0].bought]
    first_bought = NUMBER_STEP * ceil((len(made) + 1) / NUMBER_STEP) + 1
    numbered = [*enumerate(made, 1), *enumerate(bought, first_bought)]
    return PartsList(tuple(ListedPart(number, tuple(rows[key]), weights[key]) for number, key in numbered), masses)


def part_key(component: Component) -> Hashable:
    """Return a key that equal parts have in common.

    Bought parts are equal by designation; made ones by material, process, stock and shape, whatever their names are.
    The shape of hoses, hinges and straps depends on the pose: they are equal by the size to which they are cut.
    """
    if component.bought and component.designation:
        return component.designation, component.size
    kind = (component.material, component.making, component.designation, component.size)
    return (*kind, component.tags & FLEXIBLE_TAGS or component.shape)


def common_name(names: Sequence[str]) -> str:
    """Return one name for parts of several names: "hose A, B" of hoses A and B, "screw" of screws of several uses."""
    if len(names) == 1:
        return names[0]
    letters = [found[1] for name in names if (found := SIDE_LETTER.search(name))]
    bases = {SIDE_LETTER.sub("", name) for name in names}
    if len(letters) == len(names) and len(bases) == 1:
        return f"{bases.pop()} {', '.join(letters)}"
    heads = [re.split(r" (?:of|on) ", name)[0].split() for name in names]
    common: list[str] = []
    for words in zip(*(reversed(head) for head in heads), strict=False):
        if len(set(words)) > 1:
            break
        common.insert(0, words[0])
    return " ".join(common) or ", ".join(names)
