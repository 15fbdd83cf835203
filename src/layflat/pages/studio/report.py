"""A report of a design as one page that needs nothing else: what was changed, its figures, and its pictures."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from matplotlib.figure import Figure

from layflat._version import __version__
from layflat.description.quantity import Quantity as Kind
from layflat.design.findings import Finding
from layflat.pages.studio.cloud import LEVELS, Cloud, Step, Tolerances
from layflat.pages.studio.design import Design
from layflat.pages.studio.results import Figures, differences, drawing
from layflat.pages.studio.session import Kept, Session, Shown
from layflat.plot.page import Drawn, page
from layflat.plot.style import LINES, QUIET, SHADE, figure, to_svg

BANDS = ((0, 4, 0.15), (1, 3, 0.3))
"""Levels between which a band lies, and how dark it is."""


@dataclass(frozen=True)
class Content:
    """Content of a report; it travels to the process that writes it."""

    design: Design
    step: Step
    tolerances: Tolerances
    shown: Shown
    kept: Kept | None
    findings: list[Finding]

    @classmethod
    def of(cls, session: Session) -> Self:
        """Return what a session shows now."""
        return cls(
            session.design, session.step, session.tolerances, session.shown, session.kept, session.findings
        )  # fmt: skip


def report(session: Content) -> str:
    """Return the report of what is shown, as HTML; what A is compared with stands beside it."""
    design, shown, kept = session.design, session.shown, session.kept
    figures = shown.figures
    cloud = shown.cloud if isinstance(shown.cloud, Cloud) else None
    other = None if kept is None else kept.shown.figures
    other_cloud = None if kept is None or not isinstance(kept.shown.cloud, Cloud) else kept.shown.cloud
    now = [*(figures.quantities if figures else []), *(cloud.quantities if cloud else [])]
    compared = [*(other.quantities if other else []), *(other_cloud.quantities if other_cloud else [])]
    return page(
        "layflat.pages.studio", "report.html.j2",
        machine=design.machine.name, title=design.machine.title, joint=session.step.joint, version=__version__,
        base=design.opened.given, changes=changes(session), compared=kept is not None,
        figures=[(a.name, a.text, b.text if b else "", more) for a, b, more in differences(now, compared)],
        findings=[(one.severity, str(one)) for one in session.findings],
        summary=cloud.summary if cloud else str(shown.cloud or ""), tolerances=session.tolerances,
        runs=cloud.runs if cloud else 0, drawn=_drawn(figures, other, cloud, other_cloud),
    )  # fmt: skip


def changes(session: Content) -> list[tuple[str, str, str]]:
    """Return path, value as opened and value now of all that was changed."""
    design = session.design
    fields = {field.path: field for field in design.fields}
    rows = []
    for path in design.changes:
        field = fields[path]
        was, now = field.shown(design.was(path)), field.shown(design.value(path))
        rows.append((path, f"{was} {field.unit}".rstrip(), f"{now} {field.unit}".rstrip()))
    return rows


def _drawn(
    figures: Figures | None, other: Figures | None, cloud: Cloud | None, other_cloud: Cloud | None
) -> list[Drawn]:
    found = []
    if figures is not None and figures.design is not None:
        pressure = Kind("pressure", "Pa", "").text(figures.design.pressure, "bar")
        text = f"One hose at {pressure} gauge, over the angle of the joint from mid-stroke."
        found.append(Drawn("torque", "Torque.", text, to_svg(_torque(figures, other))))
        if svg := drawing(figures, other):
            found.append(Drawn("cam", "Cam.", "Dimensions in mm.", svg))
    if cloud is not None and cloud.sound.any():
        text = f"Median of {cloud.runs} runs, and where 50 % and 90 % of them lie."
        found.append(Drawn("step", "Step response.", text, to_svg(_step(cloud, other_cloud))))
    return found


def _torque(figures: Figures, other: Figures | None) -> Figure:
    with figure() as (made, (axes,)):
        axes.plot(*figures.torque, label="as built", **LINES[0])
        if len(figures.roller_torque[0]):
            axes.plot(*figures.roller_torque, label="on a round roller", **QUIET)
        if other is not None:
            axes.plot(*other.torque, label="A", **LINES[1])
        axes.set_xlabel("Angle from mid-stroke (deg)")
        axes.set_ylabel("Torque (N m)")
        axes.set_ylim(bottom=0.0)
        axes.legend()
    return made


def _step(cloud: Cloud, other: Cloud | None) -> Figure:
    with figure(2, 1, height=5.0) as (made, (angle, pressure)):
        levels = np.degrees(cloud.levels(cloud.angle))
        for low, high, alpha in BANDS:
            angle.fill_between(cloud.time, levels[low], levels[high], color=LINES[0]["color"], alpha=alpha, lw=0)
        angle.plot(cloud.time, levels[LEVELS.index(0.5)], label="median", **LINES[0])
        angle.axhspan(*(np.degrees(cloud.step.size) / 2 + 0.3 * np.array([-1.0, 1.0])), color=SHADE, lw=0)
        if other is not None and other.sound.any():
            angle.plot(other.time, np.degrees(other.levels(other.angle))[2], label="A: median", **LINES[1])
        angle.set_ylabel("Angle (deg)")
        angle.legend()
        for name, signal, line in (("A", cloud.pressure_a, LINES[0]), ("B", cloud.pressure_b, LINES[2])):
            pressure.plot(cloud.time, cloud.levels(signal)[2] / 1e5, label=f"hose {name}", **line)
        pressure.set_ylabel("Absolute pressure (bar)")
        pressure.set_xlabel("Time from the step (s)")
        pressure.legend()
    return made
