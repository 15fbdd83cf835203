"""Line charts with bands: units on every axis, lines that differ in dashes as well as in colour.

Data are replaced in place: `LineChart.show` sends only the numbers and redraws without animation, at up to 10 Hz.
The page around the chart is not rendered again, as it would be by an update of the element.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import floor, log10
from typing import Any

import numpy as np
from nicegui import ui
from numpy.typing import NDArray

from layflat.pages.look.theme import FONT_FAMILY, PRIMARY_COLOUR, QUIET_COLOUR, TEXT_COLOUR

Dash = str | list[int]

LINE_STYLES: tuple[tuple[str, Dash], ...] = (
    (PRIMARY_COLOUR, "solid"),
    ("#b3263c", [7, 4]),
    ("#2f7a2a", [9, 3, 2, 3]),
    ("#a35a00", [2, 3]),
    ("#6b4c9a", [7, 2, 2, 2, 2, 2]),
    ("#0f7373", [12, 4]),
    ("#5f6670", [4, 2, 2, 2]),
)
"""Colour and dashes in order of use; each colour has a contrast of at least 4.5 on white."""

MAX_LEGEND_ROW = 4  # names in one line of a legend
MAX_DECIMALS = 15
DIGITS = 6  # significant digits of the numbers that are sent


@dataclass(frozen=True)
class Axis:
    """Axis with its unit; a bound of None follows the data."""

    name: str
    unit: str
    lower: float | None = None
    upper: float | None = None

    @property
    def title(self) -> str:
        """Title of the axis, with its unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name


@dataclass(frozen=True)
class ChartLine:
    """Line of a chart, by default styled by its index among the lines; `quiet` ones are not in the legend."""

    name: str
    colour: str = ""
    dash: Dash = ""
    width: float = 2.0
    quiet: bool = False
    opacity: float = 1.0


@dataclass(frozen=True)
class Band:
    """Filled area between two lines; `quiet` ones are not in the legend."""

    name: str
    colour: str = PRIMARY_COLOUR
    opacity: float = 0.15
    quiet: bool = False


Points = Sequence[Sequence[float]]

# An item of a band's series: number of points; min and max of x, then of y, for the axes; then the points.
RENDER_POLYGON = """(params, api) => {
  const n = api.value(0), points = [];
  for (let i = 0; i < n; i++) points.push(api.coord([api.value(5 + 2 * i), api.value(6 + 2 * i)]));
  return {type: 'polygon', shape: {points}, style: {fill: api.visual('color'), opacity: OPACITY}, silent: true};
}"""


REPORT_RENDERED = """() => {
  const known = (window.layflatCharts ??= new Set());
  if (!known.has('ID')) { known.add('ID'); emit(); }
}"""
"""Handler that reports the first rendering of a chart."""


def points(across: Iterable[float], up: Iterable[float]) -> list[list[float]]:
    """Return pairs (x, y) for `LineChart.show`, x and y each rounded to `DIGITS` digits of its greatest magnitude."""
    pairs: list[list[float]] = np.column_stack([_round_digits(across), _round_digits(up)]).tolist()
    return pairs


def _round_digits(values: Iterable[float]) -> NDArray[np.float64]:
    """Round values to as many decimals as the greatest magnitude needs for `DIGITS` significant digits."""
    array = np.asarray(values, float)
    greatest = float(np.abs(array[np.isfinite(array)]).max(initial=0.0))
    return array if greatest == 0.0 else np.round(array, min(DIGITS - 1 - floor(log10(greatest)), MAX_DECIMALS))


class LineChart:
    """Chart of lines and bands over one axis, built once; `show` replaces its data."""

    def __init__(
        self, across: Axis, up: Axis, lines: Sequence[ChartLine], bands: Sequence[Band] = (), *, label: str,
        height: str = "15rem", legend: bool = True,
    ) -> None:  # fmt: skip
        """Build the chart within the current element.

        Args:
            across: the horizontal axis.
            up: the vertical axis.
            lines: lines in the order in which they are drawn, above all bands.
            bands: bands in the order in which they are drawn.
            label: description of the chart, for a reader of screens.
            height: height as CSS has it.
            legend: whether names of lines are shown above the chart.
        """
        self._places = {name: i for i, name in enumerate([*(b.name for b in bands), *(ln.name for ln in lines)])}
        series = [_band_series(one, i) for i, one in enumerate(bands)]
        series += [_line_series(one, i, len(bands) + i) for i, one in enumerate(lines)]
        named = [_named_band(one) for one in bands if not one.quiet]
        named += [{"name": one.name} for one in lines if not one.quiet]
        self._legend = named if legend and len(named) > 1 else []
        self.box = ui.element("div").classes("lf-chart").style(f"height: {height}").props("role=img")
        self.label = label
        with self.box:
            self._options = _chart_options(across, up, series, self._legend)
            self.chart = ui.echart(_copy_options(self._options)).classes("lf-chart").style("height: 100%")
        self._drawn = False
        self.chart.on("chart:rendered", self._first_drawn, js_handler=REPORT_RENDERED.replace("ID", str(self.chart.id)))

    @property
    def label(self) -> str:
        """Description of the chart for screen readers; it may give the main figures."""
        return str(self.box.props["aria-label"])

    @label.setter
    def label(self, text: str) -> None:
        self.box.props["aria-label"] = text

    def show(self, data: Mapping[str, Points], upright: Mapping[str, float] | None = None) -> None:
        """Replace the data of lines and bands.

        Args:
            data: pairs (x, y) by the name of a line; of a band its outline, see `band_outline`. Others keep theirs.
            upright: positions of vertical marks on the x axis, by their names; None keeps the present ones.
        """
        options = self._options
        sent: dict[str, dict[str, Any]] = {}
        for name, pairs in data.items():
            series = options["series"][self._places[name]]
            series["data"] = _polygon_row(pairs) if series["type"] == "custom" else list(pairs)
            sent[series["id"]] = {"id": series["id"], "data": series["data"]}
        drawn = [series["name"] for series in options["series"] if series["data"]]
        options["legend"]["data"] = named = [series for series in self._legend if series["name"] in drawn]
        options["grid"]["top"] = _legend_height(len(named))
        if upright is not None:
            last = options["series"][-1]
            last["markLine"] = _vertical_marks(upright)
            sent.setdefault(last["id"], {"id": last["id"]})["markLine"] = last["markLine"]
        if self._drawn:
            axes = {axis: {"min": options[axis]["min"], "max": options[axis]["max"]} for axis in ("xAxis", "yAxis")}
            top = {"legend": {"data": named}, "grid": {"top": options["grid"]["top"]}}
            self.chart.run_chart_method("setOption", {"series": list(sent.values()), **axes, **top})

    def _first_drawn(self) -> None:
        """Send all options once, with the data shown so far; from now on `show` sends changes at once."""
        self._drawn = True
        # With what was shown since it was sent first. The element has a copy: it would send itself with every change.
        self.chart.props["options"] = _copy_options(self._options)

    def bounds(self, up: tuple[float | None, float | None]) -> None:
        """Set the lower and upper bound of the vertical axis from the next `show` on; None follows the data."""
        self._options["yAxis"]["min"], self._options["yAxis"]["max"] = up


def band_outline(across: Iterable[float], low: Iterable[float], high: Iterable[float]) -> list[list[float]]:
    """Return the outline of a band for `LineChart.show`: forth along its lower edge, back along its upper one.

    Args:
        across: x of the edges, ascending, (n,).
        low: y of the lower edge, (n,).
        high: y of the upper edge, (n,).
    """
    across = np.asarray(across, float)
    return [*points(across, low), *points(across[::-1], np.asarray(high, float)[::-1])]


def _copy_options(options: dict[str, Any]) -> dict[str, Any]:
    """Return a copy of a chart's options; points are shared, as nobody changes them."""
    copied: dict[str, Any] = {
        key: _copy_options(value) if isinstance(value, dict) else value for key, value in options.items()
    }
    if "series" in copied:
        copied["series"] = [dict(one) for one in copied["series"]]
    return copied


def _line_series(line: ChartLine, index: int, series_id: int) -> dict[str, Any]:
    """Return the ECharts series of a line, without data; its index gives the default style."""
    colour, dash = LINE_STYLES[index % len(LINE_STYLES)]
    style = {"color": line.colour or colour, "type": line.dash or dash, "width": line.width, "opacity": line.opacity}
    return {
        "type": "line", "id": str(series_id), "name": line.name, "data": [], "symbol": "none", "silent": line.quiet,
        "lineStyle": style, "itemStyle": {"color": line.colour or colour}, "z": 3 + index / 100, "animation": False,
        "emphasis": {"disabled": True},
        "tooltip": {"show": not line.quiet},
    }  # fmt: skip


def _band_series(band: Band, series_id: int) -> dict[str, Any]:
    """Return the ECharts series of a filled polygon, without data."""
    return {
        "type": "custom", "id": str(series_id), "name": band.name, "data": [], "silent": True, "z": 1 + series_id / 100,
        "itemStyle": {"color": band.colour}, "animation": False, "clip": True, "encode": {"x": [1, 2], "y": [3, 4]},
        ":renderItem": RENDER_POLYGON.replace("OPACITY", str(band.opacity)), "tooltip": {"show": False},
    }  # fmt: skip


def _polygon_row(pairs: Points) -> list[list[float]]:
    """Return a polygon as a row of ECharts data, none without points: count, bounds of x and y, all coordinates."""
    if not pairs:
        return []
    across, up = zip(*pairs, strict=True)
    flat = [value for pair in pairs for value in pair]
    return [[len(pairs), min(across), max(across), min(up), max(up), *flat]]


def _named_band(band: Band) -> dict[str, Any]:
    """Return the ECharts legend entry of a band, a rectangle of twice its opacity."""
    return {"name": band.name, "icon": "rect", "itemStyle": {"opacity": min(1.0, 2 * band.opacity)}}


def _vertical_marks(upright: Mapping[str, float]) -> dict[str, Any]:
    """Return the ECharts options of labelled vertical lines, by the x at which each stands."""
    return {
        "silent": True, "symbol": "none", "animation": False,
        "lineStyle": {"color": QUIET_COLOUR, "type": [4, 4], "width": 1},
        "label": {"position": "insideEndTop", "color": TEXT_COLOUR, "formatter": "{b}", "fontSize": 11},
        "data": [{"name": name, "xAxis": at} for name, at in upright.items()],
    }  # fmt: skip


def _legend_height(names: int) -> int:
    """Return the room above the axes for a legend of so many names, px; more than `MAX_LEGEND_ROW` take two lines."""
    return 12 if not names else 30 if names <= MAX_LEGEND_ROW else 52


def _chart_options(across: Axis, up: Axis, series: list[dict[str, Any]], named: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the ECharts options of a chart with two value axes; the named series are in its legend."""

    def axis(axis_of: Axis, gap: int) -> dict[str, Any]:
        """Return the ECharts options of an axis, its name at a gap (px)."""
        return {
            "type": "value", "name": axis_of.title, "nameLocation": "middle", "nameGap": gap, "scale": True,
            "min": axis_of.lower, "max": axis_of.upper, "nameTextStyle": {"color": TEXT_COLOUR, "fontSize": 12},
            "axisLabel": {"color": QUIET_COLOUR, "hideOverlap": True}, "axisLine": {"show": True, "onZero": False},
            "splitLine": {"lineStyle": {"color": "#e3e7eb"}},
        }  # fmt: skip

    return {
        "animation": False, "textStyle": {"fontFamily": FONT_FAMILY}, "aria": {"enabled": False},
        "grid": {"left": 62, "right": 18, "top": _legend_height(len(named)), "bottom": 44},
        "legend": {
            "show": bool(named), "data": named, "top": 0, "itemWidth": 24, "itemGap": 10,
            "itemStyle": {"opacity": 0}, "textStyle": {"color": TEXT_COLOUR}, "selectedMode": False,
        },
        "tooltip": {"trigger": "axis", "confine": True, "transitionDuration": 0},
        "xAxis": axis(across, 28), "yAxis": axis(up, 44), "series": series,
    }  # fmt: skip
