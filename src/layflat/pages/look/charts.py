"""Line charts in the browser: units on every axis, lines that differ in dashes as well as in colour, bands.

Data are replaced in place: `LineChart.show` sends the numbers alone and redraws without animation, at 10 Hz if need be.
The page around the chart is not touched by that; an update of the element would let all of it be rendered anew.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import floor, log10
from typing import Any

import numpy as np
from nicegui import ui
from numpy.typing import NDArray

from layflat.pages.look.theme import FONT, PRIMARY, QUIET, TEXT

Dash = str | list[int]

STYLES: tuple[tuple[str, Dash], ...] = (
    (PRIMARY, "solid"),
    ("#b3263c", [7, 4]),
    ("#2f7a2a", [9, 3, 2, 3]),
    ("#a35a00", [2, 3]),
    ("#6b4c9a", [7, 2, 2, 2, 2, 2]),
    ("#0f7373", [12, 4]),
    ("#5f6670", [4, 2, 2, 2]),
)
"""Colour and dashes in order of use; each colour has a contrast of at least 4.5 on white."""

FEW = 4  # names that stand beside each other in a legend
MAX_DECIMALS = 15
DIGITS = 6  # significant digits of the numbers that are sent


@dataclass(frozen=True)
class Axis:
    """An axis with its unit; bounds that are not given follow the data."""

    name: str
    unit: str
    least: float | None = None
    most: float | None = None

    @property
    def title(self) -> str:
        """Title of the axis, with its unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name


@dataclass(frozen=True)
class Line:
    """A series: by default styled by its place among the others; `quiet` ones are not in the legend."""

    name: str
    colour: str = ""
    dash: Dash = ""
    width: float = 2.0
    quiet: bool = False
    opacity: float = 1.0


@dataclass(frozen=True)
class Band:
    """An area between two lines; `quiet` ones are not in the legend."""

    name: str
    colour: str = PRIMARY
    opacity: float = 0.15
    quiet: bool = False


Points = Sequence[Sequence[float]]

# An item of such a series: the number of points, least and most of both coordinates for the axes, then the points.
POLYGON = """(params, api) => {
  const n = api.value(0), points = [];
  for (let i = 0; i < n; i++) points.push(api.coord([api.value(5 + 2 * i), api.value(6 + 2 * i)]));
  return {type: 'polygon', shape: {points}, style: {fill: api.visual('color'), opacity: OPACITY}, silent: true};
}"""


ONCE = """() => {
  const known = (window.layflatCharts ??= new Set());
  if (!known.has('ID')) { known.add('ID'); emit(); }
}"""
"""Tells that a chart was drawn, once."""


def points(across: Iterable[float], up: Iterable[float]) -> list[list[float]]:
    """Return pairs for `LineChart.show` with the digits that a screen can show."""
    pairs: list[list[float]] = np.column_stack([_short(across), _short(up)]).tolist()
    return pairs


def _short(values: Iterable[float]) -> NDArray[np.float64]:
    """Return values to as many decimals as the greatest of them needs for `DIGITS` digits."""
    array = np.asarray(values, float)
    greatest = float(np.abs(array[np.isfinite(array)]).max(initial=0.0))
    return array if greatest == 0.0 else np.round(array, min(DIGITS - 1 - floor(log10(greatest)), MAX_DECIMALS))


class LineChart:
    """A chart of some lines over one axis, made once and then only given other data."""

    def __init__(
        self, across: Axis, up: Axis, lines: Sequence[Line], bands: Sequence[Band] = (), *, label: str,
        height: str = "15rem", legend: bool = True,
    ) -> None:  # fmt: skip
        """Make the chart within the current element.

        Args:
            across: the horizontal axis.
            up: the vertical axis.
            lines: in the order in which they are drawn, above all bands.
            bands: in the order in which they are drawn.
            label: what the chart shows, for a reader of screens.
            height: as in CSS.
            legend: whether names of lines are shown above the chart.
        """
        self._places = {name: i for i, name in enumerate([*(b.name for b in bands), *(ln.name for ln in lines)])}
        series = [_band(one, i) for i, one in enumerate(bands)]
        series += [_line(one, i, len(bands) + i) for i, one in enumerate(lines)]
        named = [_named_band(one) for one in bands if not one.quiet]
        named += [{"name": one.name} for one in lines if not one.quiet]
        self._legend = named if legend and len(named) > 1 else []
        self.box = ui.element("div").classes("lf-chart").style(f"height: {height}").props("role=img")
        self.label = label
        with self.box:
            self._options = _options(across, up, series, self._legend)
            self.chart = ui.echart(_copied(self._options)).classes("lf-chart").style("height: 100%")
        self._drawn = False
        self.chart.on("chart:rendered", self._first_drawn, js_handler=ONCE.replace("ID", str(self.chart.id)))

    @property
    def label(self) -> str:
        """Description of the chart for readers of screens; it may give the main figures."""
        return str(self.box.props["aria-label"])

    @label.setter
    def label(self, text: str) -> None:
        self.box.props["aria-label"] = text

    def show(self, data: Mapping[str, Points], upright: Mapping[str, float] | None = None) -> None:
        """Replace the data of lines by their name, and of bands by pairs there along one edge and back along the other.

        Args:
            data: lines that are not named keep theirs.
            upright: names of vertical marks and where they lie; default: as they were.
        """
        options = self._options
        sent: dict[str, dict[str, Any]] = {}
        for name, pairs in data.items():
            one = options["series"][self._places[name]]
            one["data"] = _polygon(pairs) if one["type"] == "custom" else list(pairs)
            sent[one["id"]] = {"id": one["id"], "data": one["data"]}
        drawn = [one["name"] for one in options["series"] if one["data"]]
        options["legend"]["data"] = named = [one for one in self._legend if one["name"] in drawn]
        options["grid"]["top"] = _top(len(named))
        if upright is not None:
            last = options["series"][-1]
            last["markLine"] = _marks(upright)
            sent.setdefault(last["id"], {"id": last["id"]})["markLine"] = last["markLine"]
        if self._drawn:
            axes = {axis: {"min": options[axis]["min"], "max": options[axis]["max"]} for axis in ("xAxis", "yAxis")}
            top = {"legend": {"data": named}, "grid": {"top": options["grid"]["top"]}}
            self.chart.run_chart_method("setOption", {"series": list(sent.values()), **axes, **top})

    def _first_drawn(self) -> None:
        self._drawn = True
        # With what was shown since it was sent first. The element has a copy: it would send itself with every change.
        self.chart.props["options"] = _copied(self._options)

    def bounds(self, up: tuple[float | None, float | None]) -> None:
        """Set least and most of the vertical axis; None follows the data."""
        self._options["yAxis"]["min"], self._options["yAxis"]["max"] = up


def edges(across: Iterable[float], low: Iterable[float], high: Iterable[float]) -> list[list[float]]:
    """Return the outline of a band for `LineChart.show`."""
    across = np.asarray(across, float)
    return [*points(across, low), *points(across[::-1], np.asarray(high, float)[::-1])]


def _copied(options: dict[str, Any]) -> dict[str, Any]:
    """Return a copy of a chart's options that keeps what is in them now; points are shared, as nobody changes them."""
    copied: dict[str, Any] = {
        key: _copied(value) if isinstance(value, dict) else value for key, value in options.items()
    }
    if "series" in copied:
        copied["series"] = [dict(one) for one in copied["series"]]
    return copied


def _line(line: Line, place: int, at: int) -> dict[str, Any]:
    colour, dash = STYLES[place % len(STYLES)]
    style = {"color": line.colour or colour, "type": line.dash or dash, "width": line.width, "opacity": line.opacity}
    return {
        "type": "line", "id": str(at), "name": line.name, "data": [], "symbol": "none", "silent": line.quiet,
        "lineStyle": style, "itemStyle": {"color": line.colour or colour}, "z": 3 + place / 100, "animation": False,
        "emphasis": {"disabled": True},
        "tooltip": {"show": not line.quiet},
    }  # fmt: skip


def _band(band: Band, at: int) -> dict[str, Any]:
    return {
        "type": "custom", "id": str(at), "name": band.name, "data": [], "silent": True, "z": 1 + at / 100,
        "itemStyle": {"color": band.colour}, "animation": False, "clip": True, "encode": {"x": [1, 2], "y": [3, 4]},
        ":renderItem": POLYGON.replace("OPACITY", str(band.opacity)), "tooltip": {"show": False},
    }  # fmt: skip


def _polygon(pairs: Points) -> list[list[float]]:
    if not pairs:
        return []
    across, up = zip(*pairs, strict=True)
    flat = [value for pair in pairs for value in pair]
    return [[len(pairs), min(across), max(across), min(up), max(up), *flat]]


def _named_band(band: Band) -> dict[str, Any]:
    return {"name": band.name, "icon": "rect", "itemStyle": {"opacity": min(1.0, 2 * band.opacity)}}


def _marks(upright: Mapping[str, float]) -> dict[str, Any]:
    return {
        "silent": True, "symbol": "none", "animation": False, "lineStyle": {"color": QUIET, "type": [4, 4], "width": 1},
        "label": {"position": "insideEndTop", "color": TEXT, "formatter": "{b}", "fontSize": 11},
        "data": [{"name": name, "xAxis": at} for name, at in upright.items()],
    }  # fmt: skip


def _top(names: int) -> int:
    """Room above the axes for the legend, px; more than a few names take two lines."""
    return 12 if not names else 30 if names <= FEW else 52


def _options(across: Axis, up: Axis, series: list[dict[str, Any]], named: list[dict[str, Any]]) -> dict[str, Any]:
    def axis(one: Axis, gap: int) -> dict[str, Any]:
        return {
            "type": "value", "name": one.title, "nameLocation": "middle", "nameGap": gap, "scale": True,
            "min": one.least, "max": one.most, "nameTextStyle": {"color": TEXT, "fontSize": 12},
            "axisLabel": {"color": QUIET, "hideOverlap": True}, "axisLine": {"show": True, "onZero": False},
            "splitLine": {"lineStyle": {"color": "#e3e7eb"}},
        }  # fmt: skip

    return {
        "animation": False, "textStyle": {"fontFamily": FONT}, "aria": {"enabled": False},
        "grid": {"left": 62, "right": 18, "top": _top(len(named)), "bottom": 44},
        "legend": {
            "show": bool(named), "data": named, "top": 0, "itemWidth": 24, "itemGap": 10,
            "itemStyle": {"opacity": 0}, "textStyle": {"color": TEXT}, "selectedMode": False,
        },
        "tooltip": {"trigger": "axis", "confine": True, "transitionDuration": 0},
        "xAxis": axis(across, 28), "yAxis": axis(up, 44), "series": series,
    }  # fmt: skip
