"""Sentences of an assembly guide: numbers of parts, torques and angles in place of their names."""

from __future__ import annotations

import re
from math import degrees
from typing import TYPE_CHECKING

from markupsafe import Markup, escape

from layflat.solids.standard.screws import PROOF_STRESS
from layflat.solids.standard.threads import thread
from layflat.solids.strength import tightening_torque

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from layflat.solids.component import Component
    from layflat.solids.sizes import JointSizes

PRELOAD_SHARE = 0.7  # preload of a tightened screw over its load at 0.2 % strain
SCREW_PATTERN = re.compile(r"ISO (?:4762|4032) (M[\d.]+)(?: x [\d.]+)?")
REFERENCE_PATTERN = re.compile(r"\[([^\]|]+)(?:\|([^\]]+))?\]")
FACT_PATTERN = re.compile(r"\{(\??)([^{}]+)\}")
SET_BY_SPRINGS = frozenset({"nut of the brake"})  # by whose length they are tightened


def tightening(component: Component) -> str:
    """Return the torque to which screws or nuts are tightened, with its unit; empty for other parts."""
    found = SCREW_PATTERN.match(component.designation)
    if not found or component.name in SET_BY_SPRINGS:
        return ""
    size = thread(found[1])
    torque = tightening_torque(PRELOAD_SHARE * PROOF_STRESS * size.stress_area, size.diameter)
    return f"{torque:.2g} N m"


def component_facts(components: Iterable[Component]) -> dict[str, str]:
    """Return sizes, threads and torques of components by "size NAME", "thread NAME" and "torque NAME"."""
    values: dict[str, dict[str, None]] = {}
    for one in components:
        values.setdefault(f"size {one.name}", {})[one.size] = None
        screw, torque = SCREW_PATTERN.match(one.designation), tightening(one)
        if screw:
            values.setdefault(f"thread {one.name}", {})[screw[0].split(" ", 2)[2]] = None
        if torque:
            values.setdefault(f"torque {one.name}", {})[torque] = None
    return {name: " or ".join(texts) for name, texts in values.items()}


def joint_facts(sizes: JointSizes) -> dict[str, str]:
    """Return angles and torques of a joint, and the conditions that it meets, by name."""
    stroke, limit = degrees(sizes.stroke / 2), degrees(sizes.swing)
    facts = {
        "kind": sizes.joint.output.kind,
        "double" if sizes.double else "single": "",
        "limit": f"{limit:.1f} deg",
        "collapsed A": f"-{stroke:.1f} deg from mid-stroke",
        "collapsed B": f"+{stroke:.1f} deg",
        "slip": f"{sizes.joint.brake.torque:.3g} N m",
    }
    if limit > stroke:
        facts["margin"] = f"{limit - stroke:.1f} deg"
    if sizes.joint.hose.folded:
        facts["folded"] = ""
    return facts


def fill_sentence(sentence: str, numbers: Mapping[str, Sequence[int]], facts: Mapping[str, str]) -> Markup | None:
    """Return a sentence with its references and facts; None if one of them is missing.

    Args:
        sentence: with [name], [name|words], {fact} and {?condition}.
        numbers: in the parts list, by the names of components.
        facts: values and conditions by name; conditions that are met are empty.
    """
    while found := FACT_PATTERN.search(sentence):
        if found[2] not in facts:
            return None
        sentence = sentence.replace(found[0], facts[found[2]])
    if any(name not in numbers for name, _ in REFERENCE_PATTERN.findall(sentence)):
        return None

    def refer(match: re.Match[str]) -> str:
        return f"{escape(match[2] or match[1])} <b>({', '.join(map(str, numbers[match[1]]))})</b>"

    return Markup(REFERENCE_PATTERN.sub(refer, sentence))  # sentences of this package, names without markup
