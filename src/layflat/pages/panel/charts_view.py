"""The last half minute of a rig in charts: angles and targets, errors, pressures, voltages, brakes, air."""

from math import ceil, floor

import numpy as np
from nicegui import ui

from layflat.pages.look import theme
from layflat.pages.look.charts import STYLES, Axis, Line, LineChart, points
from layflat.pages.panel.desk import Data, Desk
from layflat.pages.panel.history import SPAN, Seen, air_taken

TIME = Axis("time before now", "s", -SPAN, 0.0)
KINDS = {
    "Angles": (Axis("angle", "deg"), 10.0),
    "Errors": (Axis("target less angle", "deg"), 2.0),
    "Pressures": (Axis("hose A less hose B", "bar"), 1.0),
    "Valves": (Axis("voltage", "V"), 5.0),
    "Brakes": (Axis("share of the brake's torque", "%"), 100.0),
    "Air": (Axis("taken since then", "normal litres"), 10.0),
}
"""What is drawn, by the name of its tab, and in which steps its axis grows: noise at rest is no motion."""


class ChartsView:
    """One chart at a time, as chosen."""

    def __init__(self, desk: Desk) -> None:
        """Build it."""
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
                        self._charts[kind] = LineChart(TIME, axis, self._lines(kind), label=label, height="13rem")

    def refresh(self) -> None:
        """Draw what was seen until now."""
        seen = self._desk.pilot.history.seen()
        kind = str(self._panels.value)
        if seen is None:
            return
        data, step = self._data(kind, seen), KINDS[kind][1]
        values = [y for pairs in data.values() for _, y in pairs]
        low, high = step * floor(min(values) / step), step * ceil(max(values) / step)
        self._charts[kind].bounds((low, max(high, low + step)))
        self._charts[kind].show(data)

    def _lines(self, kind: str) -> list[Line]:
        lines = []
        for i, name in enumerate(self._names):
            colour, dash = STYLES[i % len(STYLES)]
            lines.append(Line(name, colour, dash))
            if kind == "Angles":
                lines.append(Line(f"{name}, target", colour, "solid", width=1.0, quiet=True, opacity=0.5))
        return lines

    def _data(self, kind: str, seen: Seen) -> Data:
        """Return what a chart shows; all pages show the same."""
        known = self._desk.charts.get(kind)
        if known is None or known[0] is not seen:
            known = self._desk.charts[kind] = seen, self._draw(kind, seen)
        return known[1]

    def _draw(self, kind: str, seen: Seen) -> Data:
        joints = seen.joints
        drawn = {
            "Angles": np.degrees(joints["averaged_angle"]),
            "Errors": np.degrees(joints["demand"] - joints["averaged_angle"]),
            "Pressures": joints["averaged_pressure"] / 1e5,
            "Valves": joints["voltage"],
            "Brakes": 100.0 * joints["brake_share"],
            "Air": air_taken(seen),
        }[kind]
        found = {name: points(seen.times, drawn[:, j]) for j, name in enumerate(self._names)}
        if kind == "Angles":
            wanted = np.degrees(joints["demand"])
            found |= {f"{name}, target": points(seen.times, wanted[:, j]) for j, name in enumerate(self._names)}
        return found
