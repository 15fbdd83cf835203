"""Screws that a straight driver, or a key, reaches past the parts that are mounted before them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from layflat.design.summary import Finding
from layflat.lazy import numpy as np
from layflat.solids.checks.meshes import box_gaps, least_distance, segment_mesh
from layflat.solids.sizes import MM
from layflat.solids.standard.threads import THREADS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.solids.assembly import Assembly
    from layflat.solids.checks.meshes import MeshStore, PartMesh
    from layflat.solids.component import Component

DRIVER_LENGTH = 60.0  # of a straight driver's blade, mm
DRIVER_GAP = 0.1  # between the blade and what lies beside it, mm
KEY_ARMS = {2.0: 16.0, 2.5: 18.0, 3.0: 20.0, 4.0: 25.0, 5.0: 28.0, 6.0: 32.0, 8.0: 36.0, 10.0: 40.0}
"""Length of the short arm of a hexagon key by its width across flats, mm (ISO 2936)."""


def reach_findings(assembly: Assembly, store: MeshStore) -> list[Finding]:
    """Return a finding for each kind of socket screw whose driver meets a part that is mounted before it.

    A joint's parts are mounted in the order of its components; parts of other joints are not in the way.
    """
    found = []
    for name in assembly.sizes:
        own = [one for one in assembly.components if one.joint == name]
        before: list[PartMesh] = []
        for one in own:
            meshes = store.parts([one])
            if one.designation.startswith("ISO 4762"):
                finding = _screw_finding(one, name, before)
                found += [finding] if finding else []
            before += meshes
    return found


def _screw_finding(screw: Component, joint: str, before: Sequence[PartMesh]) -> Finding | None:
    """Return a note if only a key's short arm reaches screws, a warning if that does not either, else None."""
    size = THREADS[screw.designation.split()[2]]
    flats = size.socket * MM
    key = KEY_ARMS[round(flats, 1)]
    blocked = _in_the_way(screw, before, DRIVER_LENGTH)
    if not blocked:
        return None
    where, right = f"{joint}: {screw.name}", f"a hexagon key of {flats:g} mm reaches it"
    what = f"a straight driver meets the part {blocked!r}"
    still = _in_the_way(screw, before, key)
    if not still:
        return Finding("note", "screw", where, what, right)
    return Finding("warning", "screw", where, f"neither driver nor key reaches it past the part {still!r}",
                   f"mount it earlier, or move it: change joint.{joint}.build.screw")  # fmt: skip


def _in_the_way(screw: Component, before: Sequence[PartMesh], length: float) -> str:
    """Return the name of a part that a blade of a length (mm) on a screw's head meets; empty if it meets none."""
    size = THREADS[screw.designation.split()[2]]
    radius = size.socket * MM / np.sqrt(3) + DRIVER_GAP
    for at in screw.places:
        start = at.origin + (size.head_height * MM + radius + DRIVER_GAP) * at.axes[:, 2]
        blade = segment_mesh(screw, start, start + (length - radius) * at.axes[:, 2])
        near = box_gaps([blade], before)[0] <= radius if before else ()
        for part, close in zip(before, near, strict=True):
            if close and least_distance(blade, part, radius) < radius:
                return part.component.name
    return ""
