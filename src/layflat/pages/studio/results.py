"""Results of a design: torque, cam, strap, mass, air, and findings of the rules, as in `layflat design`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import degrees

import numpy as np

from layflat.arrays import Array
from layflat.design.drawing import MM, cam_sheet, layout_sheet
from layflat.design.findings import ORDER, Finding
from layflat.design.joint import design_joint
from layflat.design.sheet import Path as Line
from layflat.design.sheet_formats import svg_text
from layflat.design.summary import JointDesign
from layflat.errors import DesignError
from layflat.machine.model import Machine
from layflat.machine.parts import Joint


@dataclass(frozen=True)
class Quantity:
    """A figure in a table."""

    name: str
    value: float
    unit: str
    digits: int = 4

    @property
    def known(self) -> bool:
        """True where there is a value."""
        return bool(np.isfinite(self.value))

    @property
    def number(self) -> str:
        """The value without its unit."""
        return f"{self.value:.{self.digits}g}" if self.known else "none"

    @property
    def text(self) -> str:
        """The value with its unit."""
        return f"{self.number} {self.unit}".rstrip() if self.known else "none"


@dataclass(frozen=True)
class Figures:
    """The statics of one joint; `design` is None where it can't be made, which `findings` then say."""

    joint: str
    design: JointDesign | None
    findings: tuple[Finding, ...]  # of all joints, worst first

    @cached_property
    def torque(self) -> tuple[Array, Array]:
        """Angle from mid-stroke (deg) and torque of one hose (N m) at the supply's pressure."""
        return ((0.0 * np.zeros(0),) * 2) if self.design is None else _centred(self.design, *self.design.torque)

    @cached_property
    def roller_torque(self) -> tuple[Array, Array]:
        """The same on a round roller; empty where there is one."""
        if self.design is None or self.design.cam is None:
            return (np.zeros(0), np.zeros(0))
        return _centred(self.design, *self.design.roller_torque)

    @cached_property
    def quantities(self) -> list[Quantity]:
        """Quantities that are compared between designs."""
        made = self.design
        if made is None:
            return []
        stress = max(made.stresses, key=lambda one: one.total, default=None)
        cam = made.cam
        return [
            Quantity("torque, greatest", float(made.torque[1].max()), "N m"),
            Quantity("torque, least", float(made.torque[1].min()), "N m"),
            Quantity("full stroke", degrees(made.stroke), "deg"),
            Quantity("strap stress, greatest", stress.total / 1e6 if stress else np.nan, "MPa"),
            Quantity("strap safety", stress.safety if stress else np.nan, "", 3),
            Quantity("smallest radius of the cam", cam.smallest_radius * MM if cam else np.nan, "mm"),
            Quantity("mass of the joint", made.mass.body, "kg"),
            Quantity("mass of hose, cylinder, shell, strap, cam", made.mass.counted, "kg"),
            Quantity("air per full stroke of one hose", made.air.normal_litres, "normal l"),
        ]


def _centred(made: JointDesign, angle: Array, torque: Array) -> tuple[Array, Array]:
    return np.degrees(angle - made.stroke / 2), torque


@dataclass
class Designer:
    """Designs joints anew only where they have changed."""

    _known: dict[str, tuple[Joint, float, JointDesign | Finding]] = field(default_factory=dict)

    def figures(self, machine: Machine, joint: str) -> Figures:
        """Return the statics of a joint, and what the rules find in all joints."""
        made = {name: self._made(machine, name) for name in machine.joints}
        found = [one for each in made.values() for one in ((each,) if isinstance(each, Finding) else each.findings)]
        chosen = made[joint]
        return Figures(
            joint,
            chosen if isinstance(chosen, JointDesign) else None,
            tuple(sorted(found, key=lambda finding: ORDER.index(finding.severity))),
        )

    def _made(self, machine: Machine, name: str) -> JointDesign | Finding:
        joint, pressure = machine.joint[name], machine.supply.pressure_gauge
        known = self._known.get(name)
        if known is None or known[0] != joint or known[1] != pressure:
            known = self._known[name] = (joint, pressure, _designed(machine, name))
        return known[2]


def _designed(machine: Machine, name: str) -> JointDesign | Finding:
    try:
        return design_joint(machine, name, strict=False)
    except DesignError as error:
        return Finding("error", "design", error.where, error.what, error.right)


def drawing(figures: Figures, beside: Figures | None = None, *, layout: bool = False) -> str:
    """Return the cam, or the whole layout, as SVG; empty where there is none.

    Args:
        figures: of what is drawn.
        beside: another design, whose cam is drawn with chain lines.
        layout: cylinder, shell, strap and cam at three angles, in place of the cam alone.
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


def differences(now: list[Quantity], other: list[Quantity]) -> list[tuple[Quantity, Quantity | None, str]]:
    """Return each figure, the same of another design, and what it has more, in words."""
    known: Mapping[str, Quantity] = {one.name: one for one in other}
    return [(one, known.get(one.name), _more(one, known.get(one.name))) for one in now]


def share(now: Quantity, other: Quantity | None) -> str:
    """Return what a figure has more than another, as a share; "" where that means nothing."""
    if other is None or not (now.known and other.known) or other.value == 0.0:
        return ""
    more = f"{100 * (now.value / other.value - 1):+.1f} %"
    return "as A" if more in {"+0.0 %", "-0.0 %"} else f"{more} against A"


def _more(now: Quantity, other: Quantity | None) -> str:
    if other is None or not (now.known and other.known):
        return ""
    more = now.value - other.value
    if abs(more) < 0.5 * 10.0 ** (np.floor(np.log10(abs(now.value) or 1.0)) - now.digits + 1):
        return "same"
    share = f" ({100 * more / other.value:+.3g} %)" if other.value else ""
    return f"{more:+.3g} {now.unit}".rstrip() + share
