"""Charts of a rig's last 30 s: angles and targets, errors, pressures, voltages, brakes, air."""

from math import ceil, floor, isfinite

import numpy as np
from nicegui import ui

from layflat.pages.look import theme
from layflat.pages.look.charts import LINE_STYLES, Axis, ChartLine, LineChart, points
from layflat.pages.panel.desk import ChartData, Desk
from layflat.pages.panel.pilot import HISTORY_DURATION, RecentSamples, air_taken

TIME = Axis("time before now", "s", -HISTORY_DURATION, 0.0)
KINDS = {
    "Angles": (Axis("angle", "deg"), 10.0),
    "Errors": (Axis("target less angle", "deg"), 2.0),
    "Pressures": (Axis("hose A less hose B", "bar"), 1.0),
    "Valves": (Axis("voltage", "V"), 5.0),
    "Brakes": (Axis("share of the brake's torque", "%"), 100.0),
    "Air": (Axis("taken since then", "normal litres"), 10.0),
}
"""Axes of the charts by the names of their tabs, with the step in which each range grows: noise is not magnified."""


class ChartsView:
    """View of the charts of the last 30 s, one chart at a time in tabs."""

    def __init__(self, desk: Desk) -> None:
        """Build the view within the current element."""
        self._desk, self._names = desk, list(desk.first.joints)
        self._charts: dict[str, LineChart] = {}
        with theme.panel("Last 30 s"):
            with ui.tabs().props("dense no-caps align=left inline-label") as tabs:
                for kind in KINDS:
                    ui.tab(kind)
            with ui.tab_panels(tabs, value="Angles", animated=False, keep_alive=False).classes("lf-plain") as panels:
                self._panels = panels
                for kind, (axis, _) in KINDS.items():
                    with ui.tab_panel(kind).classes("lf-plain"):
                        label = f"{kind} of the last 30 seconds"
                        self._charts[kind] = LineChart(TIME, axis, self._chart_lines(kind), label=label, height="13rem")

    def refresh(self) -> None:
        """Draw the samples so far in the open chart; its range covers the finite ones in whole steps of `KINDS`."""
        samples = self._desk.pilot.history.samples()
        kind = str(self._panels.value)
        if samples is None:
            return
        data, step = self._shared_points(kind, samples), KINDS[kind][1]
        values = [y for pairs in data.values() for _, y in pairs if isfinite(y)]  # a failed sensor has no number
        low, high = step * floor(min(values, default=0.0) / step), step * ceil(max(values, default=0.0) / step)
        self._charts[kind].bounds((low, max(high, low + step)))
        self._charts[kind].show(data)

    def _chart_lines(self, kind: str) -> list[ChartLine]:
        """Return the lines of a chart, one for each joint; for angles a second, thin one for each target."""
        lines = []
        for i, name in enumerate(self._names):
            colour, dash = LINE_STYLES[i % len(LINE_STYLES)]
            lines.append(ChartLine(name, colour, dash))
            if kind == "Angles":
                lines.append(ChartLine(f"{name}, target", colour, "solid", width=1.0, quiet=True, opacity=0.5))
        return lines

    def _shared_points(self, kind: str, samples: RecentSamples) -> ChartData:
        """Return the points of the lines of a chart, computed once for all pages."""
        entry = self._desk.charts.get(kind)
        if entry is None or entry[0] is not samples:
            entry = self._desk.charts[kind] = samples, self._chart_points(kind, samples)
        return entry[1]

    def _chart_points(self, kind: str, samples: RecentSamples) -> ChartData:
        """Return the points of the lines by name, over time in s: degrees, bar, V, brake duty in % or normal litres."""
        joints = samples.joints
        drawn = {
            "Angles": np.degrees(joints["averaged_angle"]),
            "Errors": np.degrees(joints["demand"] - joints["averaged_angle"]),
            "Pressures": joints["averaged_pressure"] / 1e5,
            "Valves": joints["voltage"],
            "Brakes": 100.0 * joints["brake_share"],
            "Air": air_taken(samples),
        }[kind]
        lines = {name: points(samples.times, drawn[:, j]) for j, name in enumerate(self._names)}
        if kind == "Angles":
            targets = np.degrees(joints["demand"])
            lines |= {f"{name}, target": points(samples.times, targets[:, j]) for j, name in enumerate(self._names)}
        return lines
