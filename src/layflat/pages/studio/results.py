"""Results of a design, as of `layflat joint design`: torque, cam, strap, mass, air, findings of the design rules."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import degrees
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.design.drawing import MM, cam_sheet, layout_sheet
from layflat.design.joint import design_joint
from layflat.design.sheet import Polyline as Line
from layflat.design.sheet import svg_text
from layflat.design.summary import SEVERITY_ORDER, Finding, JointDesign
from layflat.errors import DesignError
from layflat.machine.model import AirSupply, Machine
from layflat.machine.parts import Joint


@dataclass(frozen=True)
class DesignQuantity:
    """Quantity of a design, as tables show it."""

    name: str
    value: float
    unit: str
    digits: int = 4

    @property
    def is_known(self) -> bool:
        """True if there is a value."""
        return bool(np.isfinite(self.value))

    @property
    def number(self) -> str:
        """The value without its unit."""
        return f"{self.value:.{self.digits}g}" if self.is_known else "none"

    @property
    def text(self) -> str:
        """The value with its unit."""
        return f"{self.number} {self.unit}".rstrip() if self.is_known else "none"


@dataclass(frozen=True)
class JointFigures:
    """Statics of one joint; `design` is None where the joint can't be made, for a reason in `findings`."""

    joint: str
    design: JointDesign | None
    findings: tuple[Finding, ...]  # of all joints, worst first

    @cached_property
    def torque(self) -> tuple[Array, Array]:
        """Angle from mid-stroke (deg) and torque of one hose (N m) at the supply's pressure; empty without a design."""
        return ((0.0 * np.zeros(0),) * 2) if self.design is None else _centre_angle(self.design, *self.design.torque)

    @cached_property
    def roller_torque(self) -> tuple[Array, Array]:
        """Angle from mid-stroke (deg) and torque (N m) on a round roller in place of the cam; empty without a cam."""
        if self.design is None or self.design.cam is None:
            return (np.zeros(0), np.zeros(0))
        return _centre_angle(self.design, *self.design.roller_torque)

    @cached_property
    def quantities(self) -> list[DesignQuantity]:
        """Quantities that are compared between designs, NaN for unknown ones; none without a design."""
        design = self.design
        if design is None:
            return []
        stress = max(design.stresses, key=lambda one: one.total, default=None)
        cam = design.cam
        return [
            DesignQuantity("torque, greatest", float(design.torque[1].max()), "N m"),
            DesignQuantity("torque, least", float(design.torque[1].min()), "N m"),
            DesignQuantity("full stroke", degrees(design.stroke), "deg"),
            DesignQuantity("strap stress, greatest", stress.total / 1e6 if stress else np.nan, "MPa"),
            DesignQuantity("strap safety", stress.safety if stress else np.nan, "", 3),
            DesignQuantity("smallest radius of the cam", cam.smallest_radius * MM if cam else np.nan, "mm"),
            DesignQuantity("mass of the joint", design.mass.body, "kg"),
            DesignQuantity("mass of hose, cylinder, shell, strap, cam", design.mass.counted, "kg"),
            DesignQuantity("air per full stroke of one hose", design.air.normal_litres, "normal l"),
        ]


def _centre_angle(design: JointDesign, angle: Array, torque: Array) -> tuple[Array, Array]:
    """Return an angle from the collapsed hose (rad) as one from mid-stroke (deg), with its torque."""
    return np.degrees(angle - design.stroke / 2), torque


class DesignInputs(NamedTuple):
    """All of a machine that the design of a joint depends on."""

    origin: str  # in findings
    name: str  # of the machine, in drawings
    supply: AirSupply
    joint: Joint


@dataclass
class Designer:
    """Designer that recomputes a joint only when it has changed."""

    _designs: dict[str, tuple[DesignInputs, JointDesign | Finding]] = field(default_factory=dict)

    def figures(self, machine: Machine, joint: str) -> JointFigures:
        """Return the statics of a joint, with the findings of the design rules in all joints, worst first."""
        designs = {name: self._cached_design(machine, name) for name in machine.joints}
        findings = [
            one for each in designs.values() for one in ((each,) if isinstance(each, Finding) else each.findings)
        ]
        chosen = designs[joint]
        return JointFigures(
            joint,
            chosen if isinstance(chosen, JointDesign) else None,
            tuple(sorted(findings, key=lambda finding: SEVERITY_ORDER.index(finding.severity))),
        )

    def _cached_design(self, machine: Machine, name: str) -> JointDesign | Finding:
        """Return the design of a joint, or the finding that it can't be made.

        It is recomputed only if its inputs have changed.
        """
        inputs = DesignInputs(machine.origin, machine.name, machine.supply, machine.joint[name])
        entry = self._designs.get(name)
        if entry is None or entry[0] != inputs:
            entry = self._designs[name] = (inputs, _try_design(machine, name))
        return entry[1]


def _try_design(machine: Machine, name: str) -> JointDesign | Finding:
    """Return the design of a joint, or the finding that it can't be made."""
    try:
        return design_joint(machine, name, strict=False)
    except DesignError as error:
        return Finding("error", "design", error.where, error.what, error.right)


def design_drawing(figures: JointFigures, beside: JointFigures | None = None, layout: bool = False) -> str:
    """Return a drawing of the cam, or of the whole layout, as SVG; "" where there is no cam.

    Args:
        figures: statics of the joint.
        beside: statics of another design, whose cam is drawn with chain lines.
        layout: whether cylinder, shell, strap and cam are drawn at three angles, in place of the cam alone.
    """
    if figures.design is None or figures.design.outline is None:
        return ""
    sheet = (layout_sheet if layout else cam_sheet)(figures.design)
    if not layout:
        sheet.notes.clear()  # the figures say the same
    other = None if beside is None or beside.design is None else beside.design.outline
    if other is not None and not layout:
        sheet.paths.append(Line(other.points * MM, "CENTRE", closed=True))
    return svg_text(sheet)


def differences(
    now: list[DesignQuantity], other: list[DesignQuantity]
) -> list[tuple[DesignQuantity, DesignQuantity | None, str]]:
    """Return each quantity of `now`, that of the same name in `other` or None, and the difference as text."""
    others: Mapping[str, DesignQuantity] = {one.name: one for one in other}
    return [(one, others.get(one.name), _difference_text(one, others.get(one.name))) for one in now]


def relative_difference(now: DesignQuantity, other: DesignQuantity | None) -> str:
    """Return the relative difference of a quantity from A's as text, "as A" below 0.05 %; "" where it is undefined."""
    if other is None or not (now.is_known and other.is_known) or other.value == 0.0:
        return ""
    difference = f"{100 * (now.value / other.value - 1):+.1f} %"
    return "as A" if difference in {"+0.0 %", "-0.0 %"} else f"{difference} against A"


def _difference_text(now: DesignQuantity, other: DesignQuantity | None) -> str:
    """Return the absolute and relative difference from A's quantity; "same" below the shown digits, "" if unknown."""
    if other is None or not (now.is_known and other.is_known):
        return ""
    difference = now.value - other.value
    if abs(difference) < 0.5 * 10.0 ** (np.floor(np.log10(abs(now.value) or 1.0)) - now.digits + 1):
        return "same"
    share = f" ({100 * difference / other.value:+.3g} %)" if other.value else ""
    return f"{difference:+.3g} {now.unit}".rstrip() + share
