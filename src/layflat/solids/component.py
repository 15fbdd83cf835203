"""Components of an assembly: shape, material, how they are made or bought, and where they are."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

from layflat.lazy import numpy as np
from layflat.solids.standard.materials import material

if TYPE_CHECKING:
    from layflat.solids.shapes import PartPlace, Shape

Group = Literal["body", "output", "shell a", "shell b", "hose a", "hose b"]
"""Parts of a joint that move together; hoses and straps change their shape."""

Making = Literal["bought", "laser cutting", "milling", "turning", "bending", "sawing", "printing", "cutting"]


@dataclass(frozen=True)
class Component:
    """Parts of one kind in a joint or an arm, at one angle of each joint."""

    name: str
    group: Group
    shape: Shape
    material: str  # a name of `MATERIALS`
    making: Making
    places: tuple[PartPlace, ...]  # in the frame of the joint, mm
    designation: str = ""  # of a standard part, or the stock that it is made from
    bought_mass: float | None = None  # of one, kg; None: volume times density
    size: str = ""  # main sizes, such as lengths to cut
    joint: str = ""  # name of the joint that it belongs to; empty: the arm's
    tags: frozenset[str] = field(default_factory=frozenset)  # roles that checks look for

    @property
    def quantity(self) -> int:
        """Number of parts of this kind."""
        return len(self.places)

    @property
    def bought(self) -> bool:
        """True for parts that are bought ready."""
        return self.making == "bought"

    @property
    def density(self) -> float:
        """Density of its material, kg/m3."""
        return material(self.material).density

    def tagged(self, tag: str) -> Component:
        """Return it with one more tag."""
        return replace(self, tags=self.tags | {tag})

    def moved(self, outer: PartPlace) -> Component:
        """Return it where its frame has a place in another frame."""
        return self.put_at(tuple(one.then(outer) for one in self.places))

    def put_at(self, places: tuple[PartPlace, ...]) -> Component:
        """Return it at other places."""
        return replace(self, places=places)


def axes_towards(x: float, y: float, z: float) -> np.ndarray:
    """Return axes (3, 3) of which the third points along a direction.

    Args:
        x: component of the direction, of any length.
        y: the same.
        z: the same.
    """
    direction = np.array([x, y, z], float) / float(np.hypot(np.hypot(x, y), z))
    across = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = np.cross(across, direction)
    first = first / np.linalg.norm(first)
    return np.column_stack([first, np.cross(direction, first), direction])
