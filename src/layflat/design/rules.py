"""Can it be made, and does it keep the paper's design rules? Answers are findings, worst first.

An "error" is what can't be made or breaks, a "warning" what works badly, a "note" what the maker should know.
"""

from collections.abc import Iterator
from math import degrees, pi, radians

import numpy as np

from layflat.design.findings import ORDER, Finding, Severity
from layflat.design.summary import JointDesign

Found = Iterator[tuple[Severity, str, str, str, str]]
"""Severity, rule, key within the joint, what is so, and what would be right or what it leads to."""

WRAP_LIMIT = radians(120.0)  # over this wrap the hose kinks and slides; source: section 2.1.1
WRAP_GREATEST = pi  # over half a turn Eq. (1) means nothing
SAFETY_WANTED = 1.3  # yield over stress below which a strap is worth a warning
ALIGNMENT_WANTED = 0.7  # share of the strap's tension along the shell's motion below which a shaft is badly placed
FIT_WANTED = 0.03  # distance of measured points from their curve, share of the greatest force, that is worth a warning
SLACK = radians(1e-6)
LEAST_SLOT = 0.5e-3


def check(design: JointDesign) -> tuple[Finding, ...]:
    """Return the findings of all rules, worst first."""
    found = [
        Finding(severity, rule, f"{design.where}.{key}" if key else design.characteristic.source, what, right)
        for rules in (_sizes, _strap, _torque)
        for severity, rule, key, what, right in rules(design)
    ]
    return tuple(sorted(found, key=lambda finding: ORDER.index(finding.severity)))


def _sizes(design: JointDesign) -> Found:
    wrap, cam = design.joint.hose.wrap, design.cam
    if wrap > WRAP_GREATEST + SLACK:
        right = "at most 180 deg; up to 120 deg works well"
        yield "error", "wrap", "hose.wrap", f"{degrees(wrap):.4g} deg", right
    elif wrap > WRAP_LIMIT + SLACK:
        right = "over 120 deg the hose kinks and slides: loss and wear"
        yield "warning", "wrap", "hose.wrap", f"{degrees(wrap):.4g} deg", right
    if cam is not None and not cam.convex:
        worst = degrees(cam.angle[int(np.argmin(cam.curvature_radius))])
        hollow = f"the cam is hollow at {worst:.4g} deg (radius of curvature {cam.smallest_radius * 1e3:.4g} mm)"
        right = "a larger output.radius (shorter stroke) or another output.shaft_offset may help"
        yield "error", "convexity", "output", f"{hollow}, so a strap can't lie on it", right
    strap, hose = design.joint.strap.width * 1e3, design.joint.hose.width * 1e3
    if strap > hose:
        what = f"{strap:.4g} mm is wider than the hose"
        yield "error", "strap width", "strap.width", what, f"at most {hose:.4g} mm"


def _strap(design: JointDesign) -> Found:
    for stress in design.stresses:
        what = (
            f"{stress.total / 1e6:.4g} MPa over the {stress.place} (tension {stress.tensile / 1e6:.4g}, bending over "
            f"{stress.bend_radius * 1e3:.4g} mm {stress.bending / 1e6:.4g}), yield {stress.yield_stress / 1e6:.4g} MPa"
        )
        right = "a thinner strap bends easier, a wider one or more layers pull less each"
        if stress.safety < 1:
            yield "error", "strap stress", "strap", what, right
        elif stress.safety < SAFETY_WANTED:
            yield "warning", "strap stress", "strap", f"{what}: safety {stress.safety:.3g}", right
    roller, offset, cam = design.joint.deflecting_roller, "output.shaft_offset", design.cam
    if roller is not None:
        from layflat.machine.parameters import loss_share  # noqa: PLC0415  # with the laws of all parts

        joint = design.joint
        share = loss_share(joint) - loss_share(joint.model_copy(update={"deflecting_roller": None}))
        what = f"{roller.count} of {roller.diameter * 1e3:.4g} mm bend the strap and cost {100 * share:.2g} % of torque"
        right = "larger rollers or a thinner strap lose less; an offset output shaft needs none"
        yield "warning", "deflection", "deflecting_roller", what, right
    elif cam is not None and design.joint.output.shaft_offset == 0:
        what = "0 mm without deflecting_roller, so the strap bends over the cylinder's edge"
        right = "offset the shaft, for example by half of the cylinder's radius, or describe deflecting_roller"
        yield "warning", "deflection", offset, what, right
    elif cam is not None and cam.convex:  # straight from the shell to the cam
        if cam.alignment.min() < ALIGNMENT_WANTED:
            share = 100 * float(cam.alignment.min())
            what = f"the strap pulls across the shell's motion: only {share:.3g} % of its tension works"
            yield "warning", "alignment", offset, what, "place the shaft further from the clamps"
        if cam.dip > LEAST_SLOT:
            what = f"the strap dips {cam.dip * 1e3:.3g} mm below the cylinder's free edge"
            right = "slot the cylinder there as wide as the strap, or place the shaft further from the clamps"
            yield "note", "slot", offset, what, right


def _torque(design: JointDesign) -> Found:
    characteristic, working = design.characteristic, design.joint.stops.working_stroke
    if design.stroke < working - SLACK:
        what = f"{degrees(working):.4g} deg, but the hose turns the output by {degrees(design.stroke):.4g} deg only"
        right = "a smaller output.radius gives more stroke and less torque"
        yield "error", "stroke", "stops.working_stroke", what, right
    if design.cam is None:
        left = 100 * characteristic.force[-1] / characteristic.force.max()
        what = f"on a round roller torque falls to {left:.3g} % of its greatest"
        yield "note", "constant torque", "output.kind", what, 'kind = "cam" keeps it constant'
    if characteristic.fit_error > FIT_WANTED:
        what = f"points lie up to {100 * characteristic.fit_error:.2g} % from the curve through them"
        right = "check for outliers; of a hysteresis curve, give the mean of both directions"
        yield "warning", "measured table", "", what, right
