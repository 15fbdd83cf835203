"""Pictures of a design at rest, renewed in place: torque, cam, strap."""

import base64
from itertools import zip_longest

import numpy as np
from nicegui import background_tasks, ui

from layflat.arrays import Array
from layflat.design.strength import StrapStress
from layflat.errors import LayflatError
from layflat.pages.look.charts import Axis, Line, LineChart, points
from layflat.pages.studio.beside import LIMIT, find_drawing
from layflat.pages.studio.box import BLUE, CHAIN, HEIGHT, OTHER, RED, WAITING, Panel
from layflat.pages.studio.results import Figures
from layflat.pages.studio.session import Session


class TorqueView(Panel):
    """Torque of one hose over the joint's angle at the supply's pressure."""

    def __init__(self, session: Session) -> None:
        super().__init__("Torque of one hose")
        self._session = session
        lines = [
            Line(f"{OTHER}as built", RED, CHAIN),
            Line("on a round roller", "#5f6670", [2, 3], width=1.5),
            Line("as built", BLUE, "solid", 2.5),
        ]
        with self.content:
            label = "Torque of one hose over the angle of the joint"
            axes = Axis("Angle from mid-stroke", "deg"), Axis("Torque", "N m", least=0.0)
            self.chart = LineChart(*axes, lines, label=label, height=HEIGHT)
            self._said = ui.label().classes("lf-small")

    def show(self, figures: Figures, kept: Figures | None) -> None:
        """Draw a design, and the one that is kept as A."""
        session = self._session
        joint, supply = session.design.machine.joint[session.step.joint], session.design.machine.supply
        half = float(np.degrees(joint.stops.working_stroke) / 2)
        angle, torque = figures.torque
        data = {"as built": _thinned(angle, torque), "on a round roller": _thinned(*figures.roller_torque)}
        data[f"{OTHER}as built"] = [] if kept is None else _thinned(*kept.torque)
        self.chart.show(data, upright={"": -half, "working stroke": half})
        said = "The joint can't be made like this; the design rules say why."
        if len(torque):
            least, most = float(torque.min()), float(torque.max())
            span = f"{most:.4g} N m" if most - least < 1e-3 * most else f"{least:.4g} to {most:.4g} N m"
            said = f"{span} at {supply.pressure_gauge / 1e5:.3g} bar, over {angle[-1] - angle[0]:.4g} deg."
        self.chart.label = f"Torque of one hose over the angle of the joint: {said}"
        self._said.set_text(said)


class CamView(Panel):
    """The cam, or the whole layout, as it is drawn for the workshop."""

    def __init__(self, session: Session) -> None:
        super().__init__("Cam")
        self._session, self._newest = session, 0
        with self.head:
            self._layout = ui.toggle({False: "cam", True: "layout"}, value=False, on_change=self._again)
            self._layout.props('dense no-caps unelevated toggle-color=primary aria-label="Drawing"')
        with self.content:
            self._image = ui.element("img").classes("st-drawing")
            self._none = ui.label().classes("lf-quiet")

    def show(self, figures: Figures, kept: Figures | None) -> None:
        """Draw a design; the cam of the one that is kept as A in chain lines."""
        self._newest += 1
        background_tasks.create(self._draw(self._newest, figures, kept), context=self.content)

    async def _draw(self, number: int, figures: Figures, kept: Figures | None) -> None:
        layout = bool(self._layout.value)
        work = find_drawing, figures, kept, layout
        try:
            svg = await self._session.worker.beside.call(*work, limit=LIMIT, what="the drawing")
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
        figures, kept = self._session.shown.figures, self._session.kept
        if figures is not None:
            self.show(figures, kept.shown.figures if kept else None)


class StrapView(Panel):
    """Stress of the strap wherever it bends, against its yield stress."""

    def __init__(self) -> None:
        super().__init__("Strap stress")
        self._bars: list[StressBar] = []
        with self.content:
            self._none = ui.label(WAITING).classes("lf-quiet")

    def show(self, figures: Figures) -> None:
        """Draw bars up to the yield stress, the limit."""
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
        with ui.element("div").classes("st-stress") as self._head:
            self._place, self._total = ui.label().classes("st-name"), ui.label().classes("lf-number")
        with ui.element("div").classes("st-bar").props("role=img") as self._bar:
            self._tension = ui.element("div").classes("st-tension")
            self._bending = ui.element("div").classes("st-bending")
            self._limit = ui.element("div").classes("st-limit")
        self._said = ui.label().classes("lf-quiet lf-small")

    def show(self, stress: StrapStress | None) -> None:
        """Show a stress; nothing where there is none."""
        for part in (self._head, self._bar, self._said):
            part.set_visibility(stress is not None)
        if stress is None:
            return
        tension, bending, limit = (1e-6 * one for one in (stress.tensile, stress.bending, stress.yield_stress))
        total, scale = tension + bending, 100 / max(1.15 * limit, tension + bending)
        self._place.set_text(f"over the {stress.place}")
        self._total.set_text(f"{total:.0f} of {limit:.0f} MPa, safety {stress.safety:.2f}")
        self._bar.props["aria-label"] = f"{total:.0f} of {limit:.0f} MPa that the strap bears, over the {stress.place}"
        self._tension.style(f"width: {scale * tension:.1f}%")
        self._bending.style(f"width: {scale * bending:.1f}%")
        self._limit.style(f"left: {scale * limit:.1f}%")
        self._said.set_text(f"tension {tension:.0f}, bending {bending:.0f}; the line is the yield stress")


def _thinned(across: Array, up: Array) -> list[list[float]]:
    return points(across[::10], up[::10])
