"""Can it be made, and does it keep the paper's design rules? Answers are findings, worst first.

An "error" is what can't be made or breaks, a "warning" what works badly, a "note" what the maker should know.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import degrees, pi, radians
from typing import Literal

import numpy as np

from layflat.design.cam import Cam
from layflat.design.characteristic import Characteristic
from layflat.design.outline import Outline
from layflat.design.strap import StrapStress
from layflat.errors import DesignError
from layflat.machine import Joint

Severity = Literal["error", "warning", "note"]
ORDER: tuple[Severity, ...] = ("error", "warning", "note")

WRAP_LIMIT = radians(120.0)
"""Over this wrap the hose kinks and slides. Source: section 2.1.1."""

WRAP_GREATEST = pi
"""Over half a turn Eq. (1) means nothing."""

SAFETY_WANTED = 1.3
"""Yield over stress below which a strap is worth a warning."""

ALIGNMENT_WANTED = 0.7
"""Share of the strap's tension along the shell's motion below which a shaft is badly placed."""

FIT_WANTED = 0.03
"""Distance of measured points from their curve, share of the greatest force, that is worth a warning."""

SLACK = radians(1e-6)
LEAST_SLOT = 0.5e-3


@dataclass(frozen=True)
class Finding:
    """One thing that was found.

    Args:
        severity: "error", "warning" or "note".
        rule: short name of the rule.
        where: machine, joint and key.
        what: what is so, with its value.
        right: what would be right, or what it leads to.
    """

    severity: Severity
    rule: str
    where: str
    what: str
    right: str = ""

    def __str__(self) -> str:
        text = f"{self.where}: {self.what}"
        return f"{text}; {self.right}" if self.right else text


@dataclass(frozen=True)
class Checked:
    """What the rules look at: a joint (named `where` in findings) with its curve, cam and strap."""

    where: str
    joint: Joint
    characteristic: Characteristic
    cam: Cam | None
    outline: Outline | None
    stresses: Sequence[StrapStress]

    @property
    def straight(self) -> Cam | None:
        """The cam, if it can be made and the strap runs straight from the shell to it."""
        deflected = self.joint.deflecting_roller is not None or self.joint.output.shaft_offset == 0
        return None if deflected or self.outline is None else self.cam


Found = Iterator[tuple[Severity, str, str, str]]
"""Severity, key within the joint, what is so, and what would be right or what it leads to."""


def check(checked: Checked) -> tuple[Finding, ...]:
    """Return the findings of all rules, worst first."""
    found = [
        Finding(severity, name, f"{checked.where}.{key}" if key else checked.characteristic.source, what, right)
        for name, rule in RULES.items()
        for severity, key, what, right in rule(checked)
    ]
    return tuple(sorted(found, key=lambda finding: ORDER.index(finding.severity)))


def refuse_errors(findings: Sequence[Finding]) -> None:
    """Raise the first error among findings, if there is one.

    Raises:
        DesignError: with the finding's text.
    """
    for finding in findings:
        if finding.severity == "error":
            raise DesignError(finding.what, where=finding.where, right=finding.right)


def _wrap(at: Checked) -> Found:
    wrap = at.joint.hose.wrap
    if wrap > WRAP_GREATEST + SLACK:
        yield "error", "hose.wrap", f"{degrees(wrap):.4g} deg", "at most 180 deg; up to 120 deg works well"
    elif wrap > WRAP_LIMIT + SLACK:
        yield (
            "warning",
            "hose.wrap",
            f"{degrees(wrap):.4g} deg",
            "over 120 deg the hose kinks and slides: loss and wear",
        )


def _convex(at: Checked) -> Found:
    if at.cam is not None and not at.cam.convex:
        worst = degrees(at.cam.angle[int(np.argmin(at.cam.curvature_radius))])
        hollow = f"the cam is hollow at {worst:.4g} deg (radius of curvature {at.cam.smallest_radius * 1e3:.4g} mm)"
        right = "a larger output.radius (shorter stroke) or another output.shaft_offset may help"
        yield "error", "output", f"{hollow}, so a strap can't lie on it", right


def _strap_width(at: Checked) -> Found:
    strap, hose = at.joint.strap.width * 1e3, at.joint.hose.width * 1e3
    if strap > hose:
        yield "error", "strap.width", f"{strap:.4g} mm is wider than the hose", f"at most {hose:.4g} mm"


def _strap_stress(at: Checked) -> Found:
    right = "a thinner strap bends easier, a wider one or more layers pull less each"
    for stress in at.stresses:
        what = (
            f"{stress.total / 1e6:.4g} MPa over the {stress.place} (tension {stress.tensile / 1e6:.4g}, bending over "
            f"{stress.bend_radius * 1e3:.4g} mm {stress.bending / 1e6:.4g}), yield {stress.yield_stress / 1e6:.4g} MPa"
        )
        if stress.safety < 1:
            yield "error", "strap", what, right
        elif stress.safety < SAFETY_WANTED:
            yield "warning", "strap", f"{what}: safety {stress.safety:.3g}", right


def _deflection(at: Checked) -> Found:
    roller = at.joint.deflecting_roller
    if roller is not None:
        from layflat.machine.parameters import loss_share  # noqa: PLC0415  # with the laws of all parts

        share = loss_share(at.joint) - loss_share(at.joint.model_copy(update={"deflecting_roller": None}))
        what = f"{roller.count} of {roller.diameter * 1e3:.4g} mm bend the strap and cost {100 * share:.2g} % of torque"
        right = "larger rollers or a thinner strap lose less; an offset output shaft needs none"
        yield "warning", "deflecting_roller", what, right
    elif at.cam is not None and at.joint.output.shaft_offset == 0:
        what = "0 mm without deflecting_roller, so the strap bends over the cylinder's edge"
        right = "offset the shaft, for example by half of the cylinder's radius, or describe deflecting_roller"
        yield "warning", "output.shaft_offset", what, right


def _alignment(at: Checked) -> Found:
    if at.straight is not None and at.straight.alignment.min() < ALIGNMENT_WANTED:
        share = f"only {100 * at.straight.alignment.min():.3g} % of its tension works"
        what = f"the strap pulls across the shell's motion: {share}"
        yield "warning", "output.shaft_offset", what, "place the shaft further from the clamps"


def _slot(at: Checked) -> Found:
    if at.straight is not None and at.straight.dip > LEAST_SLOT:
        what = f"the strap dips {at.straight.dip * 1e3:.3g} mm below the cylinder's free edge"
        right = "slot the cylinder there as wide as the strap, or place the shaft further from the clamps"
        yield "note", "output.shaft_offset", what, right


def _stroke(at: Checked) -> Found:
    full = at.characteristic.full_travel / at.joint.output.radius
    working = at.joint.stops.working_stroke
    if full < working - SLACK:
        what = f"{degrees(working):.4g} deg, but the hose turns the output by {degrees(full):.4g} deg only"
        yield "error", "stops.working_stroke", what, "a smaller output.radius gives more stroke and less torque"


def _constant(at: Checked) -> Found:
    if at.cam is None:
        left = 100 * at.characteristic.force[-1] / at.characteristic.force.max()
        what = f"on a round roller torque falls to {left:.3g} % of its greatest"
        yield "note", "output.kind", what, 'kind = "cam" keeps it constant'


def _measured(at: Checked) -> Found:
    if at.characteristic.fit_error > FIT_WANTED:
        what = f"points lie up to {100 * at.characteristic.fit_error:.2g} % from the curve through them"
        yield "warning", "", what, "check for outliers; of a hysteresis curve, give the mean of both directions"


RULES: dict[str, Callable[[Checked], Found]] = {
    "wrap": _wrap,
    "convexity": _convex,
    "strap width": _strap_width,
    "strap stress": _strap_stress,
    "deflection": _deflection,
    "alignment": _alignment,
    "slot": _slot,
    "stroke": _stroke,
    "constant torque": _constant,
    "measured table": _measured,
}
