"""Can it be made, and does it keep the paper's design rules? Answers are findings, worst first.

An "error" is what can't be made or breaks, a "warning" what works badly, a "note" what the maker should know.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
from layflat.machine.parameters import loss_share

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
        right: what would be right, or what follows.
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


def check(checked: Checked) -> tuple[Finding, ...]:
    """Findings of all rules, worst first."""
    found = [finding for rule in RULES for finding in rule(checked)]
    return tuple(sorted(found, key=lambda finding: ORDER.index(finding.severity)))


def refuse_errors(findings: Sequence[Finding]) -> None:
    """Raise the first error among findings, if there is one.

    Raises:
        DesignError: with the finding's text.
    """
    for finding in findings:
        if finding.severity == "error":
            raise DesignError(finding.what, where=finding.where, right=finding.right)


def _wrap(at: Checked) -> Iterator[Finding]:
    wrap, where = at.joint.hose.wrap, f"{at.where}.hose.wrap"
    if wrap > WRAP_GREATEST + SLACK:
        yield Finding("error", "wrap", where, f"{degrees(wrap):.4g} deg", "at most 180 deg; up to 120 deg works well")
    elif wrap > WRAP_LIMIT + SLACK:
        yield Finding(
            "warning",
            "wrap",
            where,
            f"{degrees(wrap):.4g} deg",
            "over 120 deg the hose kinks and slides: loss and wear",
        )


def _convex(at: Checked) -> Iterator[Finding]:
    if at.cam is not None and not at.cam.convex:
        worst = int(np.argmin(at.cam.curvature_radius))
        yield Finding(
            "error",
            "convexity",
            f"{at.where}.output",
            f"the cam is hollow at {degrees(at.cam.angle[worst]):.4g} deg "
            f"(radius of curvature {at.cam.smallest_radius * 1e3:.4g} mm), so a strap can't lie on it",
            "a larger output.radius (shorter stroke) or another output.shaft_offset may help",
        )


def _strap(at: Checked) -> Iterator[Finding]:
    strap, where = at.joint.strap, f"{at.where}.strap"
    if strap.width > at.joint.hose.width:
        yield Finding(
            "error",
            "strap width",
            f"{where}.width",
            f"{strap.width * 1e3:.4g} mm is wider than the hose",
            f"at most {at.joint.hose.width * 1e3:.4g} mm",
        )
    for stress in at.stresses:
        what = (
            f"{stress.total / 1e6:.4g} MPa over the {stress.place} (tension {stress.tensile / 1e6:.4g}, bending over "
            f"{stress.bend_radius * 1e3:.4g} mm {stress.bending / 1e6:.4g}), yield {stress.yield_stress / 1e6:.4g} MPa"
        )
        right = "a thinner strap bends easier, a wider one or more layers pull less each"
        if stress.safety < 1:
            yield Finding("error", "strap stress", where, what, right)
        elif stress.safety < SAFETY_WANTED:
            yield Finding("warning", "strap stress", where, f"{what}: safety {stress.safety:.3g}", right)


def _deflection(at: Checked) -> Iterator[Finding]:
    roller = at.joint.deflecting_roller
    if roller is not None:
        share = loss_share(at.joint) - loss_share(at.joint.model_copy(update={"deflecting_roller": None}))
        yield Finding(
            "warning",
            "deflection",
            f"{at.where}.deflecting_roller",
            f"{roller.count} of {roller.diameter * 1e3:.4g} mm bend the strap and cost {100 * share:.2g} % of torque",
            "larger rollers or a thinner strap lose less; an offset output shaft needs none",
        )
    elif at.cam is not None and at.joint.output.shaft_offset == 0:
        yield Finding(
            "warning",
            "deflection",
            f"{at.where}.output.shaft_offset",
            "0 mm without deflecting_roller, so the strap bends over the cylinder's edge",
            "offset the shaft, for example by half of the cylinder's radius, or describe deflecting_roller",
        )


def _place_of_shaft(at: Checked) -> Iterator[Finding]:
    if at.cam is None or at.outline is None or at.joint.deflecting_roller or at.joint.output.shaft_offset == 0:
        return
    where = f"{at.where}.output.shaft_offset"
    least = float(at.cam.alignment.min())
    if least < ALIGNMENT_WANTED:
        yield Finding(
            "warning",
            "alignment",
            where,
            f"the strap pulls across the shell's motion: only {100 * least:.3g} % of its tension works",
            "place the shaft further from the clamps",
        )
    if at.cam.dip > LEAST_SLOT:
        yield Finding(
            "note",
            "slot",
            where,
            f"the strap dips {at.cam.dip * 1e3:.3g} mm below the cylinder's free edge",
            "slot the cylinder there as wide as the strap, or place the shaft further from the clamps",
        )


def _stroke(at: Checked) -> Iterator[Finding]:
    full = at.characteristic.full_travel / at.joint.output.radius
    working = at.joint.stops.working_stroke
    if full < working - SLACK:
        yield Finding(
            "error",
            "stroke",
            f"{at.where}.stops.working_stroke",
            f"{degrees(working):.4g} deg, but the hose turns the output by {degrees(full):.4g} deg only",
            "a smaller output.radius gives more stroke and less torque",
        )


def _constant(at: Checked) -> Iterator[Finding]:
    if at.cam is None:
        left = at.characteristic.force[-1] / at.characteristic.force.max()
        yield Finding(
            "note",
            "constant torque",
            f"{at.where}.output.kind",
            f"on a round roller torque falls to {100 * left:.3g} % of its greatest",
            'kind = "cam" keeps it constant',
        )


def _measured(at: Checked) -> Iterator[Finding]:
    if at.characteristic.fit_error > FIT_WANTED:
        yield Finding(
            "warning",
            "measured table",
            at.characteristic.source,
            f"points lie up to {100 * at.characteristic.fit_error:.2g} % from the curve through them",
            "check for outliers; of a loop, give the mean of both directions",
        )


RULES = (_wrap, _convex, _strap, _deflection, _place_of_shaft, _stroke, _constant, _measured)
