from __future__ import annotations

import colorsys
from typing import Any

import numpy as np
import pytest

from layflat.cell import Cell
from layflat.cell.kinds import background_colours, make_detector, produce_kinds
from layflat.cell.vision import Colour, ColourDetector
from layflat.cell.vision.regions import colour_mask


def within(rgb: Any, colours: tuple[Colour, ...]) -> bool:
    hue, saturation, value = colorsys.rgb_to_hsv(*rgb)
    hsv = np.array([[[hue * 255.0, saturation * 255.0, value * 255.0]]]).astype(np.uint8)
    return bool(colour_mask(hsv, colours)[0, 0])


def test_skins_are_in_their_kind_lit_and_shaded_and_in_no_other(packing: Cell) -> None:
    rng = np.random.default_rng(1)
    kinds = {kind.name: kind for kind in produce_kinds(packing)}
    for name, produce in packing.produce.items():
        for skin in produce.colour.values():
            for _ in range(60):
                rgb = np.array(skin.rgb) * rng.normal(1.0, skin.std) + rng.normal(0.0, skin.std / 2, 3)
                if np.abs(rgb - skin.rgb).max() > 2.0 * skin.std:
                    continue
                rgb = np.clip(rgb, 0.02, 0.98) * rng.uniform(0.6, 1.0)
                for other, kind in kinds.items():
                    if other != name:
                        assert not within(rgb, kind.colours), (name, other, rgb)
                    elif max(skin.rgb) - min(skin.rgb) > 0.15:
                        assert within(rgb, kind.colours), (name, rgb)


def test_table_trays_and_packs_are_background_and_of_no_kind(packing: Cell) -> None:
    parts = [packing.table.colour, *(tray.colour for tray in packing.tray.values())]
    parts += [pack.layout.colour for pack in packing.container.values()]
    for colour in parts:
        for shade in (0.55, 0.8, 1.0, 1.1):
            rgb = shade * np.array(colour)
            assert within(rgb, background_colours(packing))
            assert not any(within(rgb, kind.colours) for kind in produce_kinds(packing))


def test_fruit_is_no_background(packing: Cell) -> None:
    for name, produce in packing.produce.items():
        for skin in produce.colour.values():
            assert not within(skin.rgb, background_colours(packing)), name


def test_what_is_not_known_is_not_looked_for(packing: Cell) -> None:
    assert {kind.name for kind in produce_kinds(packing)} == {"tomato", "apple", "mushroom"}


def test_who_changes_colours_changes_what_is_looked_for(packing: Cell) -> None:
    tomato = packing.produce["tomato"]
    violet = tomato.colour["red"].model_copy(update={"rgb": (0.5, 0.1, 0.7)})
    grade = {"first": tomato.grade["first"].model_copy(update={"colours": ("violet",)})}
    changed = tomato.model_copy(update={"colour": {"violet": violet}, "grade": grade})
    cell = packing.model_copy(update={"produce": packing.produce | {"tomato": changed}})
    kind = next(kind for kind in produce_kinds(cell) if kind.name == "tomato")
    assert within(violet.rgb, kind.colours)
    assert not within(tomato.colour["red"].rgb, kind.colours)


def test_shapes_follow_the_file(packing: Cell) -> None:
    kinds = {kind.name: kind for kind in produce_kinds(packing)}
    assert kinds["tomato"].flattening == packing.produce["tomato"].flattening.mean
    assert kinds["tomato"].height_ratio == pytest.approx(kinds["tomato"].flattening)
    assert kinds["mushroom"].flattening < 0.6
    assert kinds["mushroom"].height_ratio > 1.0
    assert kinds["apple"].diameter == pytest.approx((0.06, 0.079))


def test_things_lie_on_the_trays_floor(packing: Cell) -> None:
    detector = make_detector(packing)
    assert isinstance(detector, ColourDetector)
    assert detector.plane == pytest.approx(packing.tray["infeed"].wall)


def test_on_a_table_of_its_hue_a_mushroom_must_be_brighter(packing: Cell) -> None:
    warm = packing.table.model_copy(update={"colour": (0.60, 0.585, 0.55)})
    cell = packing.model_copy(update={"table": warm})
    mushroom = next(kind for kind in produce_kinds(cell) if kind.name == "mushroom")
    assert within(packing.produce["mushroom"].colour["white"].rgb, mushroom.colours)
    assert not any(within(shade * np.array(warm.colour), mushroom.colours) for shade in (0.5, 0.8, 1.0, 1.1))
