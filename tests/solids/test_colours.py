"""Colours of materials can be told apart, also without colour."""

import re
from itertools import pairwise

import pytest

from layflat.solids.colours import MATERIAL_COLOURS, linear_colour
from layflat.solids.standard.materials import MATERIALS


def lightness(material: str) -> float:
    """Return L* of a colour (CIE 1976)."""
    red, green, blue = linear_colour(material)
    luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue
    return 116 * luminance ** (1 / 3) - 16 if luminance > 216 / 24389 else luminance * 24389 / 27


def test_every_material_has_a_colour_of_its_own_lightness() -> None:
    assert set(MATERIAL_COLOURS) == set(MATERIALS)
    order = [lightness(name) for name in MATERIAL_COLOURS]
    assert all(second - first > 3.0 for first, second in pairwise(order))
    assert all(re.fullmatch("#[0-9a-f]{6}", colour) for colour in MATERIAL_COLOURS.values())


@pytest.mark.parametrize("material", MATERIAL_COLOURS)
def test_linear_colours_go_back_to_those_of_the_table(material: str) -> None:
    encoded = [12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055 for v in linear_colour(material)]
    assert "#" + "".join(f"{round(255 * v):02x}" for v in encoded) == MATERIAL_COLOURS[material]
