"""All checks of an assembly: masses beside the description, clearances, stresses, and findings, worst first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from layflat.design.summary import SEVERITY_ORDER, Finding
from layflat.plot.tables import html_table
from layflat.solids.checks.clearances import Clearance, arm_clearances, joint_clearances
from layflat.solids.checks.masses import MassRow, mass_findings, mass_rows
from layflat.solids.checks.meshes import MeshStore
from layflat.solids.checks.reach import reach_findings
from layflat.solids.making import making_findings
from layflat.solids.strength import Strength, check_strength
from layflat.solids.stresses import joint_stresses

if TYPE_CHECKING:
    from collections.abc import Callable

    from layflat.solids.assembly import Assembly

MASS_COLUMNS = ("path", "described", "solids", "deviation")
STRESS_COLUMNS = ("part", "stress", "limit", "safety", "required", "formula", "source")
FINDING_COLUMNS = ("severity", "rule", "where", "found", "action")


@dataclass(frozen=True)
class BuildChecks:
    """Results of the checks of an assembly."""

    masses: tuple[MassRow, ...]
    clearances: tuple[Clearance, ...]  # of pairs that come within the required distance, nearest first
    stresses: tuple[Strength, ...]
    findings: tuple[Finding, ...]  # worst first

    def mass_table(self) -> list[list[str]]:
        """Return the rows of the table of masses, under `MASS_COLUMNS`."""
        return [list(row.texts) for row in self.masses]

    def stress_table(self) -> list[list[str]]:
        """Return the rows of the table of stresses, under `STRESS_COLUMNS`."""
        rows = []
        for one in self.stresses:
            scale, unit = (1e-6, "MPa") if one.unit == "Pa" else (1.0, "N")
            stress, limit = (f"{value * scale:.4g} {unit}" for value in (one.stress, one.limit))
            rows.append([one.where, stress, limit, f"{one.safety:.3g}", f"{one.required:g}", one.formula, one.source])
        return rows

    def finding_table(self) -> list[list[str]]:
        """Return the rows of the table of findings, under `FINDING_COLUMNS`."""
        return [[one.severity, one.rule, one.where, one.what, one.right] for one in self.findings]

    def _repr_html_(self) -> str:
        """Return all tables, for notebooks."""
        return (
            html_table("masses", MASS_COLUMNS, self.mass_table())
            + html_table("stresses", STRESS_COLUMNS, self.stress_table())
            + html_table("findings", FINDING_COLUMNS, self.finding_table())
        )


def check_build(assembly: Assembly, progress: Callable[[int, int], object] = lambda *_: None) -> BuildChecks:
    """Return the results of all checks of an assembly.

    Args:
        assembly: the assembly.
        progress: called with how many steps are done, and of how many.
    """
    steps = 2 * len(assembly.sizes) + 3
    store, clearances = MeshStore(assembly.shape_solid), list[Clearance]()
    for done, name in enumerate(assembly.sizes):
        progress(2 * done, steps)
        clearances += joint_clearances(assembly, name, store)
    progress(steps - 3, steps)
    clearances += arm_clearances(assembly, store)
    progress(steps - 2, steps)
    screws = reach_findings(assembly, store)
    progress(steps - 1, steps)
    masses = mass_rows(assembly)
    stresses = [
        one
        for name, sizes in assembly.sizes.items()
        for one in joint_stresses(sizes, [part for part in assembly.components if part.joint == name], name)
    ]
    weak = [check_strength(one) for one in stresses]
    findings = [
        *(one.finding for one in clearances if not one.enough),
        *(one for one in weak if one is not None),
        *making_findings(assembly.components, assembly.sizes),
        *screws,
        *mass_findings(assembly, masses),
    ]
    progress(steps, steps)
    return BuildChecks(
        tuple(masses),
        tuple(sorted(clearances, key=lambda one: one.distance)),
        tuple(stresses),
        tuple(sorted(findings, key=lambda one: SEVERITY_ORDER.index(one.severity))),
    )
