"""What a step of a joint looks like: its angle and its pressures, as clouds of runs."""

import numpy as np
from nicegui import ui

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.pages.look.charts import Axis, Band, Line, LineChart, edges, points
from layflat.pages.studio.box import BLUE, CHAIN, GREEN, HEIGHT, OTHER, RED, Panel
from layflat.pages.studio.cloud import LEVELS, REST, SINGLE, Cloud

ANGLE_BANDS = ("5–95 %", "25–75 %")
SINGLES = [f"run {i}" for i in range(1, SINGLE + 1)]
EDGES = {LEVELS[0]: [2, 3], LEVELS[1]: [6, 3], LEVELS[3]: [6, 3], LEVELS[4]: [2, 3]}
"""Dashes of the lines along the bands, which are seen without colours, too."""


class StepView(Panel):
    """The angle over a step: the cloud as bands, some of its runs, and the demand."""

    def __init__(self) -> None:
        super().__init__("Step response")
        bands = [Band(ANGLE_BANDS[0], BLUE, 0.12), Band(ANGLE_BANDS[1], BLUE, 0.22)]
        lines = [
            Line("demand", "#5f6670", [4, 4], width=1.2),
            *(Line(name, "#5f6670", "solid", 0.7, quiet=True, opacity=0.7) for name in SINGLES),
            *(Line(f"{100 * level:.0f} %", BLUE, dash, 1.0, quiet=True) for level, dash in EDGES.items()),
            Line(f"{OTHER}5 %", RED, [2, 3], 1.0, quiet=True),
            Line(f"{OTHER}95 %", RED, [2, 3], 1.0, quiet=True),
            Line(f"{OTHER}median", RED, CHAIN),
            Line("median", BLUE, "solid", 2.5),
        ]
        with self.content:
            axes = Axis("Time from the step", "s", least=-REST), Axis("Angle", "deg")
            self.chart = LineChart(*axes, lines, bands, label="Angle over time", height=HEIGHT)
            self._said = ui.label().classes("lf-small").props("aria-live=polite")
            self._said.set_text("Waiting for the first runs.")

    def show(self, cloud: Cloud | LayflatError, kept: Cloud | None) -> None:
        """Draw a cloud, and that of the design that is kept as A."""
        drawn = isinstance(cloud, Cloud) and bool(cloud.sound.any())
        self.chart.box.set_visibility(drawn)
        if not isinstance(cloud, Cloud) or not drawn:
            self._said.set_text(str(cloud) if isinstance(cloud, LayflatError) else "All runs diverged.")
            return
        time, levels = cloud.time, np.degrees(cloud.angle_levels)
        half = float(np.degrees(cloud.step.size) / 2)
        data: dict[str, list[list[float]]] = {
            ANGLE_BANDS[0]: edges(time, levels[0], levels[4]), ANGLE_BANDS[1]: edges(time, levels[1], levels[3]),
            "median": points(time, levels[2]),
            "demand": [[float(time[0]), -half], [0.0, -half], [0.0, half], [float(time[-1]), half]],
        }  # fmt: skip
        some = np.flatnonzero(cloud.sound)[:SINGLE]
        data |= {name: points(time, np.degrees(cloud.angle[i])) for name, i in zip(SINGLES, some, strict=False)}
        data |= {f"{100 * level:.0f} %": points(time, levels[LEVELS.index(level)]) for level in EDGES}
        data |= _kept_lines(kept)
        self.chart.show(data)
        self.chart.label = f"Angle over time after a step of {2 * half:.3g} deg. {cloud.summary}"
        self._said.set_text(f"{cloud.summary} {cloud.runs} runs, step {1e3 * cloud.plant_step:g} ms.")

    def wait(self, text: str) -> None:
        """Say what is waited for."""
        self._said.set_text(text)


def _kept_lines(kept: Cloud | None) -> dict[str, list[list[float]]]:
    names = [f"{OTHER}5 %", f"{OTHER}median", f"{OTHER}95 %"]
    if kept is None or not kept.sound.any():
        return {name: [] for name in names}
    levels = np.degrees(kept.angle_levels)
    return {name: points(kept.time, levels[i]) for name, i in zip(names, (0, 2, 4), strict=True)}


class PressureView(Panel):
    """Pressures of both hoses over the step."""

    def __init__(self) -> None:
        super().__init__("Pressures")
        bands = [Band("hose A, 5 to 95 %", BLUE, 0.15, quiet=True), Band("hose B, 5 to 95 %", GREEN, 0.15, quiet=True)]
        lines = [
            Line(f"{OTHER}hose A", RED, CHAIN, 1.5), Line(f"{OTHER}hose B", RED, [2, 3], 1.5),
            Line("hose B", GREEN, [9, 3, 2, 3]), Line("hose A", BLUE, "solid"),
        ]  # fmt: skip
        with self.content:
            axes = Axis("Time from the step", "s", least=-REST), Axis("Absolute pressure", "bar")
            self.chart = LineChart(*axes, lines, bands, label="Pressures over time", height=HEIGHT)
            self._said = ui.label().classes("lf-small lf-quiet")

    def show(self, cloud: Cloud | LayflatError, kept: Cloud | None) -> None:
        """Draw a cloud, and that of the design that is kept as A."""
        drawn = isinstance(cloud, Cloud) and bool(cloud.sound.any())
        self.chart.box.set_visibility(drawn)
        self._said.set_text("Medians, and bands of 5 to 95 % of the runs." if drawn else "No runs to show.")
        data: dict[str, list[list[float]]] = {}
        for hose in "AB":
            name = f"hose {hose}"
            levels, time = _pressures(cloud, hose)
            data[name] = points(time, levels[2])
            data[f"{name}, 5 to 95 %"] = edges(time, levels[0], levels[4])
            other, time = _pressures(kept, hose)
            data[f"{OTHER}{name}"] = points(time, other[2])
        self.chart.show(data)


def _pressures(cloud: object, hose: str) -> tuple[Array, Array]:
    if not isinstance(cloud, Cloud) or not cloud.sound.any():
        return np.zeros((len(LEVELS), 0)), np.zeros(0)
    return (cloud.pressure_a_levels if hose == "A" else cloud.pressure_b_levels) / 1e5, cloud.time
