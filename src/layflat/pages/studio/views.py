"""Pictures of a design, updated in place: torque, cam and strap stress, and the cloud of runs of a step."""

import base64
from itertools import zip_longest

import numpy as np
from nicegui import background_tasks, ui

from layflat.arrays import Array
from layflat.design.strength import StrapStress
from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.charts import LINE_STYLES, Axis, Band, ChartLine, LineChart, band_outline, points
from layflat.pages.studio.cloud import MAX_SINGLE_RUNS, QUANTILE_LEVELS, STEP_DELAY, StepCloud
from layflat.pages.studio.results import JointFigures, design_drawing
from layflat.pages.studio.session import StudioSession

BLUE, RED, GREEN = (colour for colour, _ in LINE_STYLES[:3])
KEPT_PREFIX = "A: "  # prefix of the names of lines of the design that is kept as A
CHAIN_DASH = [8, 4]
HEIGHT = "13.5rem"
WAITING_TEXT = "Waiting for the first figures."
ANGLE_BANDS = ("5–95 %", "25–75 %")
RUN_NAMES = [f"run {i}" for i in range(1, MAX_SINGLE_RUNS + 1)]
EDGE_DASHES = {
    QUANTILE_LEVELS[0]: [2, 3],
    QUANTILE_LEVELS[1]: [6, 3],
    QUANTILE_LEVELS[3]: [6, 3],
    QUANTILE_LEVELS[4]: [2, 3],
}
"""Dashes of the lines along the bands, which are visible without colours, too."""


class ResultPanel:
    """Box with a heading; its content is grey while it is older than the newest edit."""

    def __init__(self, title: str) -> None:
        """Make the box, grey, within the current element."""
        with theme.panel(title) as self.head:
            with self.head:
                self._mark = ui.label("computing").classes("st-computing").props("aria-hidden=true")
            self.content = ui.element("div").classes("st-content")
        self.mark_current(False)

    def mark_current(self, is_current: bool) -> None:
        """Grey the content out unless it belongs to the newest edit."""
        self._mark.set_visibility(not is_current)
        self.content.classes(add="" if is_current else "st-old", remove="st-old" if is_current else "")


class TorqueView(ResultPanel):
    """Torque of one hose over the joint's angle at the supply's pressure."""

    def __init__(self, session: StudioSession) -> None:
        """Make the panel with an empty chart within the current element."""
        super().__init__("Torque of one hose")
        self._session = session
        lines = [
            ChartLine(f"{KEPT_PREFIX}as built", RED, CHAIN_DASH),
            ChartLine("on a round roller", "#5f6670", [2, 3], width=1.5),
            ChartLine("as built", BLUE, "solid", 2.5),
        ]
        with self.content:
            label = "Torque of one hose over the angle of the joint"
            axes = Axis("Angle from mid-stroke", "deg"), Axis("Torque", "N m", lower=0.0)
            self.chart = LineChart(*axes, lines, label=label, height=HEIGHT)
            self._caption = ui.label().classes("lf-small")

    def show(self, figures: JointFigures, kept: JointFigures | None) -> None:
        """Draw a design, and design A (`kept`) if it is not None; a design without torque has a caption alone."""
        session = self._session
        joint, supply = session.design.machine.joint[session.step.joint], session.design.machine.supply
        half = float(np.degrees(joint.stops.working_stroke) / 2)
        angle, torque = figures.torque
        data = {"as built": _thin_points(angle, torque), "on a round roller": _thin_points(*figures.roller_torque)}
        data[f"{KEPT_PREFIX}as built"] = [] if kept is None else _thin_points(*kept.torque)
        self.chart.show(data, upright={"": -half, "working stroke": half})
        caption = "The joint can't be made like this; the design rules say why."
        if len(torque):
            lowest, highest = float(torque.min()), float(torque.max())
            span = f"{highest:.4g} N m" if highest - lowest < 1e-3 * highest else f"{lowest:.4g} to {highest:.4g} N m"
            caption = f"{span} at {supply.pressure_gauge / 1e5:.3g} bar, over {angle[-1] - angle[0]:.4g} deg."
        self.chart.label = f"Torque of one hose over the angle of the joint: {caption}"
        self._caption.set_text(caption)


class CamView(ResultPanel):
    """The cam, or the whole layout, as it is drawn for the workshop."""

    def __init__(self, session: StudioSession) -> None:
        """Make the panel, without a drawing, within the current element."""
        super().__init__("Cam")
        self._session, self._newest = session, 0
        with self.head:
            self._layout = ui.toggle({False: "cam", True: "layout"}, value=False, on_change=self._again)
            self._layout.props('dense no-caps unelevated toggle-color=primary aria-label="Drawing"')
        with self.content:
            self._image = ui.element("img").classes("st-drawing")
            self._none = ui.label().classes("lf-quiet")

    def show(self, figures: JointFigures, kept: JointFigures | None) -> None:
        """Draw a design; the cam of design A in chain lines."""
        self._newest += 1
        background_tasks.create(self._draw(self._newest, figures, kept), context=self.content)

    async def _draw(self, number: int, figures: JointFigures, kept: JointFigures | None) -> None:
        """Draw cam or layout in another process and show it, if it is still the newest request."""
        layout = bool(self._layout.value)
        try:
            svg = await self._session.worker.perform(design_drawing, figures, kept, layout, what="the drawing")
        except LayflatError:  # the process was ended: the page is being closed
            return
        if number != self._newest:
            return
        self._image.set_visibility(bool(svg))
        self._none.set_visibility(not svg)
        if svg:
            name = "Layout of cylinder, shell, strap and cam" if layout else "Cam with its dimensions in mm"
            self._image.props["src"] = f"data:image/svg+xml;base64,{base64.b64encode(svg.encode()).decode()}"
            self._image.props["alt"] = name
        else:
            roller = figures.design is not None and figures.design.cam is None
            self._none.set_text("This joint turns a round roller; output kind cam has a cam." if roller else
                                "There is no such cam; the design rules say why.")  # fmt: skip

    def _again(self) -> None:
        """Draw the results that are shown again, if there are some, as cam or layout."""
        figures, kept = self._session.shown.figures, self._session.kept
        if figures is not None:
            self.show(figures, kept.shown.figures if kept else None)


class StrapView(ResultPanel):
    """Stress of the strap at each place where it bends, against the yield stress."""

    def __init__(self) -> None:
        """Make the panel, without bars, within the current element."""
        super().__init__("Strap stress")
        self._bars: list[StressBar] = []
        with self.content:
            self._none = ui.label(WAITING_TEXT).classes("lf-quiet")

    def show(self, figures: JointFigures) -> None:
        """Draw a bar for each stress, with the yield stress as its limit."""
        stresses = () if figures.design is None else figures.design.stresses
        self._none.set_text("No stress is known: the joint can't be made like this.")
        self._none.set_visibility(not stresses)
        with self.content:
            while len(self._bars) < len(stresses):
                self._bars.append(StressBar())
        for bar, stress in zip_longest(self._bars, stresses):
            bar.show(stress)


class StressBar:
    """Tension and bending of a strap at one place, side by side, and the yield stress."""

    def __init__(self) -> None:
        """Make the bar, without a stress, within the current element."""
        with ui.element("div").classes("st-stress") as self._head:
            self._place, self._total = ui.label().classes("st-name"), ui.label().classes("lf-number")
        with ui.element("div").classes("st-bar").props("role=img") as self._bar:
            self._tension = ui.element("div").classes("st-tension")
            self._bending = ui.element("div").classes("st-bending")
            self._limit = ui.element("div").classes("st-limit")
        self._caption = ui.label().classes("lf-quiet lf-small")

    def show(self, stress: StrapStress | None) -> None:
        """Show a stress; nothing where there is none."""
        for part in (self._head, self._bar, self._caption):
            part.set_visibility(stress is not None)
        if stress is None:
            return
        tension, bending, limit = (
            1e-6 * stress_part for stress_part in (stress.tensile, stress.bending, stress.yield_stress)
        )
        total, scale = tension + bending, 100 / max(1.15 * limit, tension + bending)
        self._place.set_text(f"over the {stress.location}")
        self._total.set_text(f"{total:.0f} of {limit:.0f} MPa, safety {stress.safety:.2f}")
        self._bar.props["aria-label"] = (
            f"{total:.0f} of {limit:.0f} MPa that the strap bears, over the {stress.location}"
        )
        self._tension.style(f"width: {scale * tension:.1f}%")
        self._bending.style(f"width: {scale * bending:.1f}%")
        self._limit.style(f"left: {scale * limit:.1f}%")
        self._caption.set_text(f"tension {tension:.0f}, bending {bending:.0f}; the line is the yield stress")


def _thin_points(across: Array, up: Array) -> list[list[float]]:
    """Return every tenth point of a curve for `LineChart.show`."""
    return points(across[::10], up[::10])


class StepView(ResultPanel):
    """Angle over a step: the cloud as bands, some single runs, and the demand."""

    def __init__(self) -> None:
        """Make the panel with an empty chart within the current element."""
        super().__init__("Step response")
        bands = [Band(ANGLE_BANDS[0], BLUE, 0.12), Band(ANGLE_BANDS[1], BLUE, 0.22)]
        lines = [
            ChartLine("demand", "#5f6670", [4, 4], width=1.2),
            *(ChartLine(name, "#5f6670", "solid", 0.7, quiet=True, opacity=0.7) for name in RUN_NAMES),
            *(ChartLine(f"{100 * level:.0f} %", BLUE, dash, 1.0, quiet=True) for level, dash in EDGE_DASHES.items()),
            ChartLine(f"{KEPT_PREFIX}5 %", RED, [2, 3], 1.0, quiet=True),
            ChartLine(f"{KEPT_PREFIX}95 %", RED, [2, 3], 1.0, quiet=True),
            ChartLine(f"{KEPT_PREFIX}median", RED, CHAIN_DASH),
            ChartLine("median", BLUE, "solid", 2.5),
        ]
        with self.content:
            axes = Axis("Time from the step", "s", lower=-STEP_DELAY), Axis("Angle", "deg")
            self.chart = LineChart(*axes, lines, bands, label="Angle over time", height=HEIGHT)
            self._caption = ui.label().classes("lf-small").props("aria-live=polite")
            self._caption.set_text("Waiting for the first runs.")

    def show(self, cloud: StepCloud | LayflatError, kept: StepCloud | None) -> None:
        """Draw a cloud, and that of the design that is kept as A."""
        drawn = isinstance(cloud, StepCloud) and bool(cloud.sound.any())
        self.chart.box.set_visibility(drawn)
        if not isinstance(cloud, StepCloud) or not drawn:
            self._caption.set_text(str(cloud) if isinstance(cloud, LayflatError) else "All runs diverged.")
            return
        time, levels = cloud.time, np.degrees(cloud.levels["angle"])
        half = float(np.degrees(cloud.step.size) / 2)
        data: dict[str, list[list[float]]] = {
            ANGLE_BANDS[0]: band_outline(time, levels[0], levels[4]),
            ANGLE_BANDS[1]: band_outline(time, levels[1], levels[3]),
            "median": points(time, levels[2]),
            "demand": [[float(time[0]), -half], [0.0, -half], [0.0, half], [float(time[-1]), half]],
        }  # fmt: skip
        some = np.flatnonzero(cloud.sound)[:MAX_SINGLE_RUNS]
        data |= {name: points(time, np.degrees(cloud.angle[i])) for name, i in zip(RUN_NAMES, some, strict=False)}
        data |= {f"{100 * level:.0f} %": points(time, levels[QUANTILE_LEVELS.index(level)]) for level in EDGE_DASHES}
        data |= _kept_levels(kept)
        self.chart.show(data)
        self.chart.label = f"Angle over time after a step of {2 * half:.3g} deg. {cloud.summary}"
        self._caption.set_text(f"{cloud.summary} {cloud.runs} runs, step {1e3 * cloud.plant_step:g} ms.")

    def wait(self, text: str) -> None:
        """Show the reason of a wait in place of the caption."""
        self._caption.set_text(text)


def _kept_levels(kept: StepCloud | None) -> dict[str, list[list[float]]]:
    """Return the 5 %, 50 % and 95 % levels of design A's angle (deg) over time, by the name of their line.

    They are empty without a cloud, or if all its runs diverged.
    """
    names = [f"{KEPT_PREFIX}5 %", f"{KEPT_PREFIX}median", f"{KEPT_PREFIX}95 %"]
    if kept is None or not kept.sound.any():
        return {name: [] for name in names}
    levels = np.degrees(kept.levels["angle"])
    return {name: points(kept.time, levels[i]) for name, i in zip(names, (0, 2, 4), strict=True)}


class PressureView(ResultPanel):
    """Pressures of both hoses over the step."""

    def __init__(self) -> None:
        """Make the panel with an empty chart within the current element."""
        super().__init__("Pressures")
        bands = [Band("hose A, 5 to 95 %", BLUE, 0.15, quiet=True), Band("hose B, 5 to 95 %", GREEN, 0.15, quiet=True)]
        lines = [
            ChartLine(f"{KEPT_PREFIX}hose A", RED, CHAIN_DASH, 1.5),
            ChartLine(f"{KEPT_PREFIX}hose B", RED, [2, 3], 1.5),
            ChartLine("hose B", GREEN, [9, 3, 2, 3]), ChartLine("hose A", BLUE, "solid"),
        ]  # fmt: skip
        with self.content:
            axes = Axis("Time from the step", "s", lower=-STEP_DELAY), Axis("Absolute pressure", "bar")
            self.chart = LineChart(*axes, lines, bands, label="Pressures over time", height=HEIGHT)
            self._caption = ui.label().classes("lf-small lf-quiet")

    def show(self, cloud: StepCloud | LayflatError, kept: StepCloud | None) -> None:
        """Draw a cloud, and that of the design that is kept as A."""
        drawn = isinstance(cloud, StepCloud) and bool(cloud.sound.any())
        self.chart.box.set_visibility(drawn)
        self._caption.set_text("Medians, and bands of 5 to 95 % of the runs." if drawn else "No runs to show.")
        data: dict[str, list[list[float]]] = {}
        for hose in "AB":
            name = f"hose {hose}"
            levels, time = _pressures(cloud, hose)
            data[name] = points(time, levels[2])
            data[f"{name}, 5 to 95 %"] = band_outline(time, levels[0], levels[4])
            other, time = _pressures(kept, hose)
            data[f"{KEPT_PREFIX}{name}"] = points(time, other[2])
        self.chart.show(data)


def _pressures(cloud: object, hose: str) -> tuple[Array, Array]:
    """Return quantile levels of a hose's absolute pressure, bar, (levels, instants), and the instants, s.

    There are no instants without a cloud, or if all its runs diverged.
    """
    if not isinstance(cloud, StepCloud) or not cloud.sound.any():
        return np.zeros((len(QUANTILE_LEVELS), 0)), np.zeros(0)
    return cloud.levels[f"pressure_{hose.lower()}"] / 1e5, cloud.time
