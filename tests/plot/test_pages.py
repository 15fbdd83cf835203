"""Pages: words are escaped, drawings are not, and what a template lacks is an error."""

from __future__ import annotations

from xml.etree import ElementTree

import jinja2
import pytest

from layflat.plot import CaptionedFigure, render_page
from layflat.plot.style import styled_figure, to_svg


def test_a_figure_keeps_its_drawing_and_escapes_its_words() -> None:
    with styled_figure() as (made, (axes,)):
        axes.set_xlabel("a < b & c (s)")
    drawn = CaptionedFigure("fig-1", "Torque <b>", "5 N m & more", to_svg(made))
    text = drawn.__html__()
    root = ElementTree.fromstring(text)
    assert root.attrib["id"] == "fig-1"
    caption = root.find("figcaption")
    assert caption is not None
    assert "".join(caption.itertext()) == "Torque <b> 5 N m & more"
    assert [child.tag.rpartition("}")[2] for child in root] == ["svg", "figcaption"]


def test_a_page_without_its_values_is_an_error() -> None:
    with pytest.raises(jinja2.UndefinedError):
        render_page("layflat.tune", "tuning.html.j2")
    with pytest.raises(FileNotFoundError):
        render_page("layflat.tune", "none.html.j2")
