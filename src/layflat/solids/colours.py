"""Colours of materials on screens: no two have one lightness, so that they also differ in grey."""

from __future__ import annotations

MATERIAL_COLOURS = {
    "rubber": "#181818",
    "hose": "#341b17",
    "spring-steel": "#2b2e3a",
    "polyurethane": "#103f5c",
    "webbing": "#1b4682",
    "screw-steel": "#525559",
    "steel": "#686260",
    "shaft-steel": "#6a7079",
    "bearing-steel": "#757d83",
    "steel-strip": "#758fa3",
    "stainless-steel": "#9a9895",
    "PETG": "#fa864c",
    "brass": "#d4ae5a",
    "aluminium-tube": "#bdc1c8",
    "aluminium": "#cecfd1",
    "aluminium-sheet": "#d6dce1",
    "PLA": "#dfebd3",
    "PA6": "#faf0da",
    "POM": "#fcfbf7",
}
"""Colours (sRGB) by material, from dark to light."""

LINEAR_BELOW, LINEAR_SLOPE = 0.04045, 12.92  # of the curve of sRGB (IEC 61966-2-1)


def linear_colour(material: str) -> tuple[float, float, float]:
    """Return the red, green and blue of a material in linear light, 0 to 1, as renderers want them."""
    text = MATERIAL_COLOURS[material]
    red, green, blue = (_linear(int(text[k : k + 2], 16) / 255) for k in (1, 3, 5))
    return red, green, blue


def _linear(value: float) -> float:
    """Return a component of sRGB in linear light."""
    return value / LINEAR_SLOPE if value <= LINEAR_BELOW else ((value + 0.055) / 1.055) ** 2.4
