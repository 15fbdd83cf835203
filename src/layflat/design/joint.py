"""Design of one joint from its description, with findings by the paper's design rules.

Findings are sorted, worst first. An "error" is a joint that can't be made or breaks, a "warning" one that works badly,
a "note" information for its maker.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import degrees, pi, radians
from pathlib import Path

import numpy as np

from layflat.description.wrong import shown
from layflat.design import straplines
from layflat.design.cam import cam_outline, synthesise
from layflat.design.characteristic import Characteristic, Through, cylinder_characteristic, spline
from layflat.design.summary import SEVERITY_ORDER, Finding, JointDesign, Severity, refuse_errors
from layflat.errors import DesignError, MachineError
from layflat.machine import Machine, load

Found = Iterator[tuple[Severity, str, str, str, str]]
"""Severity, rule, key within the joint, observation, and advice or consequence."""

WRAP_LIMIT = radians(120.0)  # wrap above which the hose kinks and slides; source: section 2.1.1
WRAP_GREATEST = pi  # wrap above which Eq. (1) is not defined
SAFETY_WANTED = 1.3  # yield over stress of a strap below which a warning is raised
ALIGNMENT_WANTED = 0.7  # alignment of the strap with the shell's motion below which a warning is raised
FIT_WANTED = (
    0.03  # distance of measured points from their curve over the greatest force above which a warning is raised
)
STROKE_TOLERANCE = radians(1e-6)
LEAST_SLOT = 0.5e-3  # dip of the strap above which a note advises a slot, m


def check(design: JointDesign) -> tuple[Finding, ...]:
    """Return the findings of all rules, worst first."""
    findings = [
        Finding(severity, rule, f"{design.label}.{key}" if key else design.characteristic.source, what, right)
        for rules in (_size_findings, _strap_findings, _torque_findings)
        for severity, rule, key, what, right in rules(design)
    ]
    return tuple(sorted(findings, key=lambda finding: SEVERITY_ORDER.index(finding.severity)))


def _size_findings(design: JointDesign) -> Found:
    """Yield the findings on wrap angle, convexity of the cam, and width of the strap."""
    wrap, cam = design.joint.hose.wrap, design.cam
    if wrap > WRAP_GREATEST + STROKE_TOLERANCE:
        right = "at most 180 deg; up to 120 deg works well"
        yield "error", "wrap", "hose.wrap", f"{degrees(wrap):.4g} deg", right
    elif wrap > WRAP_LIMIT + STROKE_TOLERANCE:
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


def _strap_findings(design: JointDesign) -> Found:
    """Yield the findings on stresses of the strap, its rollers, and its path from the shell to the cam."""
    for stress in design.stresses:
        bending = f"bending over {stress.bend_radius * 1e3:.4g} mm {stress.bending / 1e6:.4g}"
        total = f"{stress.total / 1e6:.4g} MPa over the {stress.location}"
        what = f"{total} (tension {stress.tensile / 1e6:.4g}, {bending}), yield {stress.yield_stress / 1e6:.4g} MPa"
        right = "a thinner strap bends easier, a wider one or more layers pull less each"
        if stress.safety < 1:
            yield "error", "strap stress", "strap", what, right
        elif stress.safety < SAFETY_WANTED:
            yield "warning", "strap stress", "strap", f"{what}: safety {stress.safety:.3g}", right
    roller, offset, cam = design.joint.deflecting_roller, "output.shaft_offset", design.cam
    if roller is not None:
        from layflat.machine.parameters import loss_fraction  # noqa: PLC0415  # with the laws of all parts

        joint = design.joint
        share = loss_fraction(joint) - loss_fraction(joint.model_copy(update={"deflecting_roller": None}))
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


def _torque_findings(design: JointDesign) -> Found:
    """Yield the findings on stroke, on a torque that is not constant, and on the fit of a measured table."""
    characteristic, working = design.characteristic, design.joint.stops.working_stroke
    if design.stroke < working - STROKE_TOLERANCE:
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


def design_joint(
    machine: str | Path | Machine, joint: str | None = None, *, measured: Characteristic | None = None,
    bore: float | None = None, strict: bool = True, through: Through = spline,
) -> JointDesign:  # fmt: skip
    """Design one joint of a machine.

    The cam keeps stroke and mean torque of a round roller of output.radius, as the machine's parameters do.

    Args:
        machine: a machine, its built-in name, or its file.
        joint: name of the joint; not needed if there is only one.
        measured: measured characteristic in place of Eq. (1), from `read_characteristic`.
        bore: diameter of the cam's bore, m; default: the largest common one.
        strict: whether to raise the first error among the findings.
        through: interpolation of the curve of Eq. (1); `stencils` needs no SciPy.

    Raises:
        MachineError: there is no such machine or joint.
        DesignError: the joint can't be made.

    Example:
        >>> import layflat as lf
        >>> design = lf.design_joint("paper-arm", "large")
        >>> design.mean_torque  # N m
        82.0
        >>> figure = design.plot()
    """
    machine = load(machine)
    names = list(machine.joints)
    if joint is None and len(names) > 1:
        raise MachineError("the joint is missing", where=machine.origin, right=f"name one of {', '.join(names)}")
    name = names[0] if joint is None else joint
    if not isinstance(name, str) or name not in machine.joint:
        raise MachineError(
            f"unknown joint {shown(name)}", where=machine.origin, right=f"name one of {', '.join(names)}"
        )
    described = machine.joint[name]
    characteristic = measured or cylinder_characteristic(described, through=through)
    cam = outline = None
    if described.output.kind == "cam":
        try:
            stroke = characteristic.full_travel / described.output.radius
            cam = synthesise(characteristic, straplines.joint_strap_line(described), stroke)
            outline = cam_outline(cam, bore) if cam.convex else None
        except DesignError as error:
            where = f"{machine.origin}: joint.{name}.output"
            raise DesignError(error.what, where=where, right=error.right) from None
    design = JointDesign(machine, name, machine.supply.pressure_gauge, characteristic, cam, outline)
    findings = check(design)
    if strict:
        refuse_errors(findings)
    return replace(design, findings=findings)
