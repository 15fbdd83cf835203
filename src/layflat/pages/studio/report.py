"""Report of a design as one self-contained page: changes, figures and pictures."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from matplotlib.figure import Figure

from layflat._version import __version__
from layflat.description.quantity import Quantity as Kind
from layflat.design.summary import Finding
from layflat.pages.studio.cloud import QUANTILE_LEVELS, JointStep, StepCloud, Tolerances
from layflat.pages.studio.design import Design
from layflat.pages.studio.results import JointFigures, design_drawing, differences
from layflat.pages.studio.session import KeptDesign, ShownResults, StudioSession
from layflat.plot import CaptionedFigure, render_page
from layflat.plot.style import GUIDE_STYLE, SERIES_STYLES, SHADE_COLOUR, styled_figure, to_svg

BAND_LEVELS = ((0, 4, 0.15), (1, 3, 0.3))
"""Bands: indices of their lower and upper quantile level, and opacity."""


@dataclass(frozen=True)
class ReportContent:
    """Content of a report, which is sent to the process that renders it."""

    design: Design
    step: JointStep
    tolerances: Tolerances
    shown: ShownResults
    kept: KeptDesign | None
    findings: list[Finding]

    @classmethod
    def from_session(cls, session: StudioSession) -> Self:
        """Return the present content of a session."""
        return cls(
            session.design, session.step, session.tolerances, session.shown, session.kept, session.findings
        )  # fmt: skip


def render_report(content: ReportContent) -> str:
    """Return the report of a design as HTML, with the values of design A if it is kept."""
    design, shown, kept = content.design, content.shown, content.kept
    figures = shown.figures
    cloud = shown.cloud if isinstance(shown.cloud, StepCloud) else None
    other = None if kept is None else kept.shown.figures
    other_cloud = None if kept is None or not isinstance(kept.shown.cloud, StepCloud) else kept.shown.cloud
    now = [*(figures.quantities if figures else []), *(cloud.quantities if cloud else [])]
    compared = [*(other.quantities if other else []), *(other_cloud.quantities if other_cloud else [])]
    return render_page(
        "layflat.pages.studio", "report.html.j2",
        machine=design.machine.name, title=design.machine.title, joint=content.step.joint, version=__version__,
        base=design.opened.name, changes=changed_values(content), compared=kept is not None,
        figures=[(a.name, a.text, b.text if b else "", more) for a, b, more in differences(now, compared)],
        findings=[(one.severity, str(one)) for one in content.findings],
        summary=cloud.summary if cloud else str(shown.cloud or ""), tolerances=content.tolerances,
        runs=cloud.runs if cloud else 0, drawn=_draw_pictures(figures, other, cloud, other_cloud),
    )  # fmt: skip


def changed_values(content: ReportContent) -> list[tuple[str, str, str]]:
    """Return path, opened value and present value of all changes, with units."""
    design = content.design
    fields = {field.path: field for field in design.fields}
    rows = []
    for path in design.changes:
        field = fields[path]
        was, now = field.format_value(design.opened_value(path)), field.format_value(design.value(path))
        rows.append((path, f"{was} {field.unit}".rstrip(), f"{now} {field.unit}".rstrip()))
    return rows


def _draw_pictures(
    figures: JointFigures | None, other: JointFigures | None, cloud: StepCloud | None, other_cloud: StepCloud | None
) -> list[CaptionedFigure]:
    """Return the captioned pictures of torque, cam and step response, if there are results; `other` is design A."""
    pictures = []
    if figures is not None and figures.design is not None:
        pressure = Kind("pressure", "Pa", "").text(figures.design.pressure, "bar")
        text = f"One hose at {pressure} gauge, over the angle of the joint from mid-stroke."
        pictures.append(CaptionedFigure("torque", "Torque.", text, to_svg(_torque_figure(figures, other))))
        if svg := design_drawing(figures, other):
            pictures.append(CaptionedFigure("cam", "Cam.", "Dimensions in mm.", svg))
    if cloud is not None and cloud.sound.any():
        text = f"Median of {cloud.runs} runs, and where 50 % and 90 % of them lie."
        pictures.append(CaptionedFigure("step", "Step response.", text, to_svg(_step_figure(cloud, other_cloud))))
    return pictures


def _torque_figure(figures: JointFigures, other: JointFigures | None) -> Figure:
    """Draw the torque of one hose (N m) over the angle from mid-stroke (deg), on the cam and on a round roller."""
    with styled_figure() as (drawn_figure, (axes,)):
        axes.plot(*figures.torque, label="as built", **SERIES_STYLES[0])
        if len(figures.roller_torque[0]):
            axes.plot(*figures.roller_torque, label="on a round roller", **GUIDE_STYLE)
        if other is not None:
            axes.plot(*other.torque, label="A", **SERIES_STYLES[1])
        axes.set_xlabel("Angle from mid-stroke (deg)")
        axes.set_ylabel("Torque (N m)")
        axes.set_ylim(bottom=0.0)
        axes.legend()
    return drawn_figure


def _step_figure(cloud: StepCloud, other: StepCloud | None) -> Figure:
    """Draw angle (deg, bands and median) and median pressures (bar) over the time from a step (s)."""
    with styled_figure(2, 1, height=5.0) as (drawn_figure, (angle, pressure)):
        levels = np.degrees(cloud.levels["angle"])
        for low, high, alpha in BAND_LEVELS:
            angle.fill_between(
                cloud.time, levels[low], levels[high], color=SERIES_STYLES[0]["color"], alpha=alpha, lw=0
            )
        angle.plot(cloud.time, levels[QUANTILE_LEVELS.index(0.5)], label="median", **SERIES_STYLES[0])
        angle.axhspan(*(np.degrees(cloud.step.size) / 2 + 0.3 * np.array([-1.0, 1.0])), color=SHADE_COLOUR, lw=0)
        if other is not None and other.sound.any():
            angle.plot(other.time, np.degrees(other.levels["angle"])[2], label="A: median", **SERIES_STYLES[1])
        angle.set_ylabel("Angle (deg)")
        angle.legend()
        for name, line in (("A", SERIES_STYLES[0]), ("B", SERIES_STYLES[2])):
            median = cloud.levels[f"pressure_{name.lower()}"][2]
            pressure.plot(cloud.time, median / 1e5, label=f"hose {name}", **line)
        pressure.set_ylabel("Absolute pressure (bar)")
        pressure.set_xlabel("Time from the step (s)")
        pressure.legend()
    return drawn_figure
