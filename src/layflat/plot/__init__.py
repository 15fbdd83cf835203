"""Figures in one style, and self-contained pages with figures inside.

Figures know arrays and data sets, not machines: so results of all rooms can draw themselves. The names of modules of
figures are loaded when they are first used, since matplotlib takes long to import.

Example:
    >>> import layflat as lf
    >>> light = lf.rollout("paper-small-joint", "20 deg", start="0 deg", duration="1.5 s", payload="1 kg")
    >>> heavy = lf.rollout("paper-small-joint", "20 deg", start="0 deg", duration="1.5 s", payload="3 kg")
    >>> figure = lf.plot.angle_figure({"1 kg": light, "3 kg": heavy}, "small")
    >>> lf.plot.save_figure(figure, "angles.png").name
    'angles.png'
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from layflat.lazy import lazy_getattr

if TYPE_CHECKING:
    from layflat.plot.bars_and_maps import draw_bars, draw_map, study_figure
    from layflat.plot.curves import hysteresis_curves
    from layflat.plot.drawing import draw
    from layflat.plot.runs import angle_figure, run_figure
    from layflat.plot.style import SERIES_STYLES, add_caption, save_figure, styled_figure, to_svg

__all__ = [
    "SERIES_STYLES", "CaptionedFigure", "add_caption", "angle_figure", "draw", "draw_bars", "draw_map",
    "hysteresis_curves", "render_page", "run_figure", "save_figure", "study_figure", "styled_figure", "to_svg",
]  # fmt: skip

__getattr__ = lazy_getattr(
    __name__,
    {
        "SERIES_STYLES": "layflat.plot.style:SERIES_STYLES",
        "add_caption": "layflat.plot.style:add_caption",
        "angle_figure": "layflat.plot.runs:angle_figure",
        "draw": "layflat.plot.drawing:draw",
        "draw_bars": "layflat.plot.bars_and_maps:draw_bars",
        "draw_map": "layflat.plot.bars_and_maps:draw_map",
        "hysteresis_curves": "layflat.plot.curves:hysteresis_curves",
        "run_figure": "layflat.plot.runs:run_figure",
        "save_figure": "layflat.plot.style:save_figure",
        "study_figure": "layflat.plot.bars_and_maps:study_figure",
        "styled_figure": "layflat.plot.style:styled_figure",
        "to_svg": "layflat.plot.style:to_svg",
    },
)


@dataclass(frozen=True)
class CaptionedFigure:
    """Figure of a page, as SVG, with its caption."""

    id: str
    title: str
    caption: str
    svg: str

    def __html__(self) -> str:
        """Return the figure as HTML for a template, with escaped texts."""
        from markupsafe import escape  # noqa: PLC0415

        caption = f"<figcaption><b>{escape(self.title)}</b> {escape(self.caption)}</figcaption>"
        return f'<figure id="{escape(self.id)}">\n{self.svg}\n{caption}\n</figure>'


def render_page(package: str, template: str, **values: Any) -> str:
    """Return the HTML of a jinja2 template in a package, filled with values that are escaped.

    Args:
        package: package that holds the template.
        template: file name; it may extend `page.html.j2` of this package.
        values: values by their names in the template; jinja2.UndefinedError if one is missing.
    """
    from importlib.resources import files  # noqa: PLC0415

    import jinja2  # noqa: PLC0415

    def source(name: str) -> str:
        home = "layflat.plot" if name == "page.html.j2" else package
        return (files(home) / name).read_text(encoding="utf-8")

    loader = jinja2.FunctionLoader(source)
    environment = jinja2.Environment(loader=loader, autoescape=True, undefined=jinja2.StrictUndefined)
    return environment.get_template(template).render(**values)
