"""Masses, centres and inertias of solids beside those that a description claims."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from layflat.bridge.pieces import rigid_arm
from layflat.description.change import changed_all, value_at
from layflat.description.tables import Provenance
from layflat.design.summary import Finding
from layflat.lazy import numpy as np
from layflat.machine.saving import save_machine
from layflat.physics.arms.bodies import inertia_matrix, lump_bodies
from layflat.solids.checks.frames import belongs_to_joint, belongs_to_link, link_places
from layflat.solids.kernel import box
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from layflat.arrays import Array
    from layflat.machine import Machine
    from layflat.solids.assembly import Assembly
    from layflat.solids.component import Component

    Body = tuple[float, Array, Array]  # mass (kg), centre (m, (3,)) and central inertia (kg m2, (3, 3))

DEVIATION_LIMIT = 0.05  # beyond which a deviation is a finding
WRITTEN_DIGITS = 4  # significant digits of values that are written into a description
LEAST_SHARE = 1e-4  # of the largest moment of inertia, below which a product counts as 0
LEAST_OFFSET = 1e-6  # of a centre of mass from an axis, below which it counts as 0, m
FROM_SOLIDS = Provenance("derived", "from solids")


@dataclass(frozen=True)
class MassRow:
    """Quantity of a description beside the same of the solids; SI, vectors and matrices as tuples."""

    path: str  # of the description
    described: float | tuple[float, ...]
    solids: float | tuple[float, ...]
    deviation: float  # of the solids from the description over `described`; of a centre over the link's length
    unit: str

    @property
    def texts(self) -> tuple[str, str, str, str]:
        """Path, both values with units, and the deviation in percent."""

        def text(value: float | tuple[float, ...]) -> str:
            numbers = value if isinstance(value, tuple) else (value,)
            return f"{', '.join(f'{number:.4g}' for number in numbers)} {self.unit}"

        return self.path, text(self.described), text(self.solids), f"{100 * self.deviation:+.1f} %"


def mass_rows(assembly: Assembly) -> list[MassRow]:
    """Return masses, heights, centres and inertias as described and of the solids, joint by joint."""
    arm, rows = rigid_arm(assembly.machine), []
    for level, (name, link) in enumerate(zip(assembly.machine.joints, arm.links, strict=True), 1):
        if name not in assembly.sizes:
            continue
        at = link_places(assembly, assembly.angles)[level]
        own = [one for one in assembly.components if one.joint == name]
        joint = [one for one in own if belongs_to_joint(one)]
        axis = at.axes @ link.axis
        values: dict[str, Any] = {
            f"joint.{name}.body.mass": sum(assembly.mass_of(one) * one.quantity for one in joint),
            f"joint.{name}.body.height": _extent(assembly, joint, axis) / MM,
        }
        rotor = lump_bodies(_bodies(assembly, [one for one in joint if one.group == "output"]))
        values |= _link_values(assembly, name, [one for one in own if belongs_to_link(one)])
        values[f"{_link_path(assembly.machine, name)}.rotor_inertia"] = _about(rotor, at.origin / MM, axis)
        rows += [_row(assembly.machine, path, value) for path, value in values.items()]
    return rows


def mass_changes(assembly: Assembly) -> dict[str, Any]:
    """Return the values of a description that follow from the solids, SI, by their dotted paths."""
    return {row.path: _rounded(row.solids) for row in mass_rows(assembly)}


def write_masses(assembly: Assembly, path: Path) -> Machine:
    """Write the machine's description with masses, centres and inertias of its solids, and return it.

    Raises:
        InputError: the solids contradict each other in the description.
        OutputError: the file can't be written.
    """
    values = mass_changes(assembly)
    machine = changed_all(assembly.machine.model_copy(deep=True), values)
    machine.provenance.update(dict.fromkeys(values, FROM_SOLIDS))
    save_machine(machine, path)
    return machine


def mass_findings(assembly: Assembly, rows: Iterable[MassRow]) -> list[Finding]:
    """Return a warning for each quantity of which the solids deviate by more than 5 % from the description."""
    right = "take the solids' value, unless it lacks what no rule makes, such as a counterweight"
    return [
        Finding("warning", "mass", f"{assembly.machine.origin}: {row.path}",
                f"is described as {row.texts[1]}, the solids have {row.texts[2]} ({row.texts[3]})", right)
        for row in rows
        if abs(row.deviation) > DEVIATION_LIMIT
    ]  # fmt: skip


def _link_path(machine: Machine, name: str) -> str:
    """Return the path of the link that a joint turns."""
    return f"joint.{name}.link" if machine.joint[name].link is not None else f"arm.link.{name}"


def _link_values(assembly: Assembly, name: str, components: list[Component]) -> dict[str, Any]:
    """Return mass, centre and inertia of the link that a joint turns, by their paths; none without solids of it."""
    if not components:
        return {}
    level = 1 + list(assembly.machine.joints).index(name)
    at = link_places(assembly, assembly.angles)[level]
    mass, centre, inertia = lump_bodies(_bodies(assembly, components))
    centre, inertia = at.axes.T @ (centre - at.origin / MM), at.axes.T @ inertia @ at.axes
    path = _link_path(assembly.machine, name)
    if assembly.machine.joint[name].link is not None:
        return {f"{path}.mass": mass, f"{path}.centre": float(centre[0]), f"{path}.inertia": float(inertia[2, 2])}
    moments = [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    least = LEAST_SHARE * max(moments)
    return {
        f"{path}.mass": mass,
        f"{path}.centre": tuple(float(one) if abs(one) > LEAST_OFFSET else 0.0 for one in centre),
        f"{path}.inertia": tuple(float(one) if abs(one) > least else 0.0 for one in moments),
    }


def _row(machine: Machine, path: str, value: float | tuple[float, ...]) -> MassRow:
    """Return the row of a quantity of the solids beside the same of a description."""
    described, key = value_at(machine, path), path.rsplit(".", 1)[1]
    unit = {"mass": "kg", "height": "m", "centre": "m"}.get(key, "kg m^2")
    if not isinstance(value, tuple):
        scale = described or value or 1.0
        return MassRow(path, described, value, (value - described) / scale, unit)
    if key == "centre":
        scale = 2 * float(np.linalg.norm(described)) or float(np.linalg.norm(value))
        return MassRow(path, described, value, float(np.linalg.norm(np.subtract(value, described))) / scale, unit)
    one, other = (inertia_matrix((*moments, 0.0, 0.0, 0.0)[:6]) for moments in (described, value))
    return MassRow(path, described, value, float(np.linalg.norm(other - one) / np.linalg.norm(one)), unit)


def _bodies(assembly: Assembly, components: Iterable[Component]) -> list[Body]:
    """Return the parts of components as bodies in the frame of the base."""
    found: list[Body] = []
    for one in components:
        mass, (volume, centre, inertia) = assembly.mass_of(one), assembly.integrals(one.shape)
        inertia = inertia * mass / volume / MM**2
        found += [(mass, (at.axes @ centre + at.origin) / MM, at.axes @ inertia @ at.axes.T) for at in one.places]
    return found


def _about(body: Body, origin: Array, axis: Array) -> float:
    """Return the moment of inertia of a body about an axis (of length 1) through a point (m), kg m2."""
    mass, centre, inertia = body
    across = np.cross(centre - origin, axis)
    return float(axis @ inertia @ axis + mass * across @ across)


def _extent(assembly: Assembly, components: Iterable[Component], axis: Array) -> float:
    """Return the extent of components along an axis of length 1, mm, by the bounding boxes of their solids."""
    ends: list[float] = []
    for one in components:
        low, high = box(assembly.solid(one))
        for at in one.places:
            along = axis @ at.axes
            middle, half = axis @ at.origin + along @ (low + high) / 2, np.abs(along) @ (high - low) / 2
            ends += [float(middle - half), float(middle + half)]
    return max(ends) - min(ends)


def _rounded(value: float | tuple[float, ...]) -> float | tuple[float, ...]:
    """Return a value with the digits that are written."""
    if isinstance(value, tuple):
        return tuple(float(f"{one:.{WRITTEN_DIGITS}g}") for one in value)
    return float(f"{value:.{WRITTEN_DIGITS}g}")
