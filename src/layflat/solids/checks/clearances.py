"""Least distances of parts that move past each other, over the mechanical stroke of each joint and between links.

Distances are those of triangles within 0.05 mm of the solids' faces.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

from layflat.design.summary import Finding, Severity
from layflat.lazy import numpy as np
from layflat.solids.checks.frames import belongs_to_joint, inverse, joint_parts, joint_place, link_places
from layflat.solids.checks.meshes import CHORD_TOLERANCE, MeshStore, PartMesh, box_gaps, least_distance
from layflat.solids.shapes import Turned
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from layflat.solids.assembly import Assembly
    from layflat.solids.component import Component
    from layflat.solids.sizes import JointSizes

POSE_COUNT = 7  # of a joint, evenly over its mechanical stroke
RUNNING_GAP = 0.5  # required between parts that spacers or bushes guide beside each other, mm
AXIS_TOLERANCE = 1e-6  # of a part that is round about the output's axis, mm

TOUCHING_NAMES = (
    ("hose", "cylinder"), ("hose", "clamp bar"), ("hose", "screw of the clamp"), ("hose", "nut of the clamp"),
    ("hinge", "cylinder"), ("hinge", "clamp bar"), ("hinge", "screw of the clamp"), ("hinge", "nut of the clamp"),
    ("hinge", "hinge"), ("hinge", "hose"), ("bush", "shaft"), ("bush", "retaining ring"), ("brake disc", "brake pad"),
    ("angle sensor", "coupling"), ("angle sensor", "set screw of the coupling"), ("angle sensor", "shaft"),
    ("bump stop", "arm plate"), ("stud of a bump stop", "arm plate"), ("shaft", "lower end plate"),
    ("shaft", "upper end plate"),
)  # fmt: skip
"""Beginnings of names of parts of a joint that are meant to touch, or that a bush keeps apart."""

GUIDED_NAMES = (("strap of", "cam"), ("strap of", "roller"), ("strap of", "strap of"), ("strap of", "arm plate"),
          ("strap of", "spacer"))  # fmt: skip
"""Beginnings of names of parts that spacers on the shaft keep beside each other."""

REMEDY_KEYS = (
    ("strut", "joint.{joint}.stops.mechanical_stroke"), ("screw of a strut", "joint.{joint}.stops.mechanical_stroke"),
    ("nut of a strut", "joint.{joint}.stops.mechanical_stroke"), ("tool flange", "arm.tool"),
    ("brake", "joint.{joint}.build.disc_diameter"), ("bump stop", "joint.{joint}.build.screw"),
    ("stud of a bump stop", "joint.{joint}.build.screw"),
    ("shell", "joint.{joint}.output.shaft_offset"), ("bar of shell", "joint.{joint}.output.shaft_offset"),
    ("strap", "joint.{joint}.output.shaft_offset"), ("nut", "joint.{joint}.build.screw"),
    ("rod", "joint.{joint}.build.screw"), ("screw", "joint.{joint}.build.screw"),
    ("arm plate", "joint.{joint}.build.arm_plate_thickness"),
)  # fmt: skip
"""Beginnings of names of parts, and the key that most likely moves them apart from others."""


@dataclass(frozen=True)
class Clearance:
    """Least distance of two kinds of parts over the stroke."""

    first: str  # name of the part
    second: str
    joint: str  # of the first part, and of the second one if it is another
    angles: tuple[float, ...]  # at which they are nearest: of that joint, or of all, rad
    distance: float  # m; 0 where they overlap
    required: float  # m

    @property
    def enough(self) -> bool:
        """True if the distance is the required one, within the triangles' tolerance."""
        return self.distance >= self.required - 2 * CHORD_TOLERANCE / MM

    @property
    def finding(self) -> Finding:
        """Finding about parts that come too near."""
        at = ", ".join(f"{np.degrees(angle):.3g}" for angle in self.angles)
        distance = "they overlap" if self.distance == 0 else f"they come within {self.distance * MM:.3g} mm"
        names = self.first, self.second
        keys = [key for start, key in REMEDY_KEYS if any(name.startswith(start) for name in names)]
        key = (keys or ["joint.{joint}.stops.mechanical_stroke"])[0].format(joint=self.joint.split(", ")[-1])
        between_links = ", " in self.joint  # their strokes may be limited by other means
        severity: Severity = "error" if self.distance == 0 and not between_links else "warning"
        return Finding(severity, "clearance", self.joint,
                       f"{self.first} and {self.second}: {distance} at {at} deg",
                       f"{self.required * MM:.3g} mm are required; change {key}")  # fmt: skip


class _Pair(NamedTuple):
    first: PartMesh
    second: PartMesh
    required: float  # mm


def joint_clearances(
    assembly: Assembly, name: str, store: MeshStore, progress: Callable[[int, int], object] = lambda *_: None
) -> list[Clearance]:
    """Return the least distances up to the required ones within a joint and the link that it turns, nearest first.

    Args:
        assembly: the assembly.
        name: of the joint.
        store: of the triangles.
        progress: called with how many poses are done, and of how many.
    """
    sizes = assembly.sizes[name]
    nearest: dict[tuple[str, ...], Clearance] = {}
    for done, angle in enumerate(np.linspace(-sizes.swing, sizes.swing, POSE_COUNT)):
        progress(done, POSE_COUNT)
        parts = store.parts(joint_parts(assembly, name, float(angle)))
        _keep_least(nearest, _moving_pairs(sizes, parts), name, (float(angle),), by_name=True)
    progress(POSE_COUNT, POSE_COUNT)
    return sorted(nearest.values(), key=lambda one: one.distance)


def arm_clearances(assembly: Assembly, store: MeshStore) -> list[Clearance]:
    """Return the least distance up to the required one between the parts of each two joints and links, nearest first.

    The joints are at all corners of their mechanical strokes.

    Args:
        assembly: the assembly.
        store: of the triangles.
    """
    names = [name for name in assembly.machine.joints if name in assembly.sizes]
    if len(names) < 2 or len(names) < len(assembly.machine.joints):
        return []
    at_rest = link_places(assembly, assembly.angles)
    seats = [joint_place(assembly, name).then(inverse(at_rest[k])) for k, name in enumerate(names)]
    swings = [assembly.sizes[name].swing for name in names]
    parts = {
        (name, side): store.parts(joint_parts(assembly, name, side * swing))
        for name, swing in zip(names, swings, strict=True)
        for side in (-1.0, 1.0)
    }
    nearest: dict[tuple[str, ...], Clearance] = {}
    for corner in product((-1.0, 1.0), repeat=len(names)):
        angles = tuple(side * swing for side, swing in zip(corner, swings, strict=True))
        frames = link_places(assembly, angles)
        placed = [
            [one.moved(seats[k].then(frames[k])) for one in parts[name, corner[k]]] for k, name in enumerate(names)
        ]
        for k, m in product(range(len(names)), repeat=2):
            if k < m:
                required = max(assembly.sizes[names[k]].clearance, assembly.sizes[names[m]].clearance)
                pairs = _near_pairs((placed[k], placed[m]), required, (k, m))
                _keep_least(nearest, pairs, f"{names[k]}, {names[m]}", angles, by_name=False)
    return sorted(nearest.values(), key=lambda one: one.distance)


def _level(component: Component, joint: int) -> int:
    """Return the number of the link that a component of a joint moves with; 0 for the base."""
    return joint + (component.group == "output")


def _moving_pairs(sizes: JointSizes, parts: Sequence[PartMesh]) -> Iterable[_Pair]:
    """Yield the pairs of a joint's parts that move past each other and whose boxes are near, with their distance."""
    gaps = box_gaps(parts, parts)
    for i, k in zip(*np.nonzero(np.triu(gaps <= sizes.clearance, 1)), strict=True):
        first, second = parts[i], parts[k]
        required = _required(sizes, first, second)
        if required > 0 and gaps[i, k] <= required:
            yield _Pair(first, second, required)


def _near_pairs(
    parts: tuple[Sequence[PartMesh], Sequence[PartMesh]], required: float, joints: tuple[int, int]
) -> Iterable[_Pair]:
    """Yield the pairs of two joints' parts that move past each other and whose boxes are near.

    Args:
        parts: of both joints.
        required: distance of the boxes, mm.
        joints: numbers of both joints.
    """
    first, second = parts
    for i, k in zip(*np.nonzero(box_gaps(first, second) <= required), strict=True):
        if _level(first[i].component, joints[0]) != _level(second[k].component, joints[1]):
            yield _Pair(first[i], second[k], required)


def _required(sizes: JointSizes, first: PartMesh, second: PartMesh) -> float:
    """Return the distance that two parts of a joint have to keep, mm; 0 if they are fixed or meant to touch."""
    one, other = first.component, second.component
    if one.group == other.group or _named(one, other, TOUCHING_NAMES):
        return 0.0
    if any(group.startswith("hose") for group in (one.group, other.group)) and one.name[-1] == other.name[-1]:
        return 0.0  # hose, hinge and strap lie on what belongs to the same hose
    if any(_round_about_axis(sizes, part) for part in (first, second)) or _named(one, other, GUIDED_NAMES):
        return min(RUNNING_GAP, sizes.clearance)
    return sizes.clearance


def _named(component: Component, other: Component, pairs: Iterable[tuple[str, str]]) -> bool:
    """Return whether the names of two components begin as those of a pair."""
    names = component.name, other.name
    return any(
        (names[0].startswith(a) and names[1].startswith(b)) or (names[0].startswith(b) and names[1].startswith(a))
        for a, b in pairs
    )


def _round_about_axis(sizes: JointSizes, part: PartMesh) -> bool:
    """Return whether a part of the output, in the joint's frame, is turned and runs true about the output's axis."""
    component = part.component
    if component.group != "output" or not isinstance(component.shape, Turned) or not belongs_to_joint(component):
        return False
    return all(
        float(np.hypot(*(at.origin[:2] - [0.0, sizes.axis]))) < AXIS_TOLERANCE
        and abs(float(at.axes[2, 2])) > 1 - AXIS_TOLERANCE
        for at in component.places
    )


def _keep_least(
    nearest: dict[tuple[str, ...], Clearance],
    pairs: Iterable[_Pair],
    joint: str,
    angles: tuple[float, ...],
    *,
    by_name: bool,
) -> None:
    """Note the least distances of pairs of parts, up to the required ones.

    Args:
        nearest: the notes.
        pairs: of parts in one pose.
        joint: or joints that they belong to.
        angles: of the pose, rad.
        by_name: whether to note each pair of names, or only the least for each pair of joints.
    """
    for first, second, required in pairs:
        names = first.component.name, second.component.name
        key = names if by_name else (joint,)
        before = nearest.get(key)
        reach = min(required, before.distance * MM if before else required)
        distance = least_distance(first, second, reach) if reach > 0 else float("inf")
        if distance < reach or (before is None and distance <= reach):
            nearest[key] = Clearance(*names, joint, angles, distance / MM, required / MM)
