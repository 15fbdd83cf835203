"""Values that mend a joint which can't be built, found by building it with them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from layflat.errors import DesignError, LayflatError
from layflat.lazy import numpy as np
from layflat.machine import changed
from layflat.solids.brake import DISC_SHARES
from layflat.solids.joint import joint_components, joint_sizes
from layflat.solids.making import making_findings
from layflat.solids.sizes import MM
from layflat.solids.standard.bushes import BUSHES
from layflat.solids.standard.stock import PLATE_THICKNESSES
from layflat.solids.standard.threads import THREADS
from layflat.solids.strength import check_strength
from layflat.solids.stresses import joint_stresses

if TYPE_CHECKING:
    from collections.abc import Iterator

    from layflat.solids.component import Component
    from layflat.solids.sizes import JointSizes

Change = tuple[str, str, float | str]  # of a joint's description: table, key, value

OFFSET_STEP = 1e-3  # between output axes that are tried, m
RADIUS_STEP = 5e-4  # between radii of the output, m
DIAMETER_STEP = 1e-3  # between diameters of discs and cylinders, m
SECOND_COUNT = 4  # of changes that mend an error for which a second one is looked for
WIDER_SHARE = 0.4  # greatest change of the diameter of a cylinder, or radius of the output, over it


def buildable_components(sizes: JointSizes, angle: float = 0.0, *, mend: bool = True) -> list[Component]:
    """Return the components of a joint in its own frame, mm, all of which can be made and bear their loads.

    Args:
        sizes: sizes of its parts.
        angle: of the output from mid-stroke, rad.
        mend: whether to look for values that mend a joint which can't be built, which can take seconds.

    Raises:
        DesignError: no size keeps a rule; the message says which value would mend it, if that is looked for.
    """
    try:
        return _checked_components(sizes, angle)
    except DesignError as error:
        # A size that does not exist has a message that lists those that do.
        if not mend or error.where.startswith(f"{sizes.label}."):
            raise
        changes = _mend(sizes) or _mend_twice(sizes, error)
        right = f"give {' and '.join(map(_text, changes))}" if changes else error.right
        raise DesignError(error.what, where=error.where, right=right) from None


def _checked_components(sizes: JointSizes, angle: float = 0.0, *, strong: bool = False) -> list[Component]:
    """Return the components of a joint; raise DesignError if one fails or can't be made, `strong`: or is weak."""
    label, parts = sizes.design.label, joint_components(sizes, angle)
    named = [replace(one, joint=label) for one in parts]
    weak = [check_strength(one) for one in joint_stresses(sizes, named, label)]
    for one in (*weak, *making_findings(named, {label: sizes})):
        if one is not None and (one.severity == "error" or (strong and one.rule == "strength")):
            raise DesignError(one.what, where=one.where, right=one.right)
    return parts


def _refusal(sizes: JointSizes, *, strong: bool = False) -> DesignError | None:
    """Return the error of `_checked_components`, if there is one."""
    try:
        _checked_components(sizes, strong=strong)
    except DesignError as error:
        return error
    return None


def _mend(sizes: JointSizes) -> tuple[Change, ...]:
    """Return the one change that lets a joint be built, if it can of strong parts, of described values first."""
    given, weak = sizes.build.model_fields_set, tuple[Change, ...]()
    for change in sorted(_changes(sizes), key=lambda one: one[1] not in given):
        varied = _changed(sizes, change)
        if varied is not None and _refusal(varied) is None:
            if _refusal(varied, strong=True) is None:
                return (change,)
            weak = weak or (change,)
    return weak


def _mend_twice(sizes: JointSizes, first: DesignError) -> tuple[Change, ...]:
    """Return another output or a wider cylinder, which mends a joint's error, and what then lets it be built."""
    tried = 0
    for change in (_other_kind(sizes), *_wider(sizes)):
        varied = _changed(sizes, change)
        refused = None if varied is None else _refusal(varied)
        if varied is None or refused is None or refused.right == first.right:  # still the same rule
            continue
        tried += 1
        second = _mend(varied)
        if second:
            return (change, *second)
        if tried == SECOND_COUNT:
            break
    return ()


def _changed(sizes: JointSizes, change: Change) -> JointSizes | None:
    """Return the sizes of a joint after a change of its description; None if it can't be designed."""
    table, key, value = change
    design = sizes.design
    try:
        machine = changed(design.machine, f"joint.{design.name}.{table}.{key}", value)
        return replace(joint_sizes(machine, design.name), mount=sizes.mount, foot=sizes.foot)
    except LayflatError:
        return None


def _text(change: Change) -> str:
    """Return a change for messages."""
    table, key, value = change
    if isinstance(value, str):
        return f'{table}.{key} of "{value}"'
    return f"{table}.{key} of {value:g} N m" if key == "torque" else f"{table}.{key} of {value * MM:g} mm"


def _changes(sizes: JointSizes) -> Iterator[Change]:
    """Yield changes to try: of the output and of parts that carry it first, of what makes another joint last."""
    output, wide = sizes.joint.output, sizes.joint.cylinder.diameter
    room = wide / 2 - output.shaft_offset
    for offset in _values_near(output.shaft_offset, OFFSET_STEP, min(room, output.shaft_offset)):
        yield "output", "shaft_offset", offset
    for bush in reversed(BUSHES):
        yield "build", "shaft_diameter", bush.bore
    plates = [one for one in sizes.build.model_fields_set if one.endswith("thickness")]
    for key in dict.fromkeys(("end_plate_thickness", *sorted(plates))):
        for thickness in PLATE_THICKNESSES:
            yield "build", key, thickness
    for diameter in _values_near(DISC_SHARES[0] * wide, DIAMETER_STEP, DISC_SHARES[0] * wide / 2):
        yield "build", "disc_diameter", diameter
    for one in sorted(THREADS.values(), key=lambda one: abs(one.diameter - sizes.screw.diameter)):
        yield "build", "screw", one.name
    for radius in _values_near(output.radius, RADIUS_STEP, WIDER_SHARE * output.radius):
        yield "output", "radius", radius
    yield _other_kind(sizes)
    for tenths in range(9, 0, -1):
        yield "brake", "torque", float(f"{tenths / 10 * sizes.joint.brake.torque:.3g}")
    yield from _wider(sizes)


def _other_kind(sizes: JointSizes) -> Change:
    """Return the change from cam to roller, or from roller to cam."""
    return "output", "kind", "roller" if sizes.joint.output.kind == "cam" else "cam"


def _wider(sizes: JointSizes) -> Iterator[Change]:
    """Yield wider cylinders, the narrowest first."""
    diameter = sizes.joint.cylinder.diameter
    for one in _values_near(diameter, DIAMETER_STEP, WIDER_SHARE * diameter):
        if one > diameter:
            yield "cylinder", "diameter", one


def _values_near(value: float, step: float, reach: float) -> list[float]:
    """Return multiples of a step within a reach of a value, the nearest first."""
    found = step * np.arange(np.ceil((value - reach) / step), np.floor((value + reach) / step) + 1)
    return [round(float(one), 6) for one in found[np.argsort(np.abs(found - value), kind="stable")]]
