from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from layflat.cell.pictures import CAPTION_HEIGHT, OUTSIDE_GREY, TILE_GAP, TILE_SIZE, TITLE_HEIGHT, ContactSheet
from layflat.errors import InputError, OutputError

Picture = NDArray[np.uint8]
WIDE, HIGH = TILE_SIZE
TOP = TILE_GAP + 2 * TITLE_HEIGHT
LINES = ("pick 1: tomato, first, 61 mm", "tomatoes 1-2, 0.8 mm off, 42 m/s2")


def picture(seed: int = 0) -> Picture:
    return np.random.default_rng(seed).integers(0, 255, (960, 1280, 3), dtype=np.uint8)


def tile(sheet: Picture, row: int, column: int) -> Picture:
    x, y = TILE_GAP + column * (WIDE + TILE_GAP), TOP + row * (HIGH + CAPTION_HEIGHT + TILE_GAP)
    return sheet[y : y + HIGH, x : x + WIDE]


INSIDE = slice(20, -20), slice(20, -20)


@pytest.mark.parametrize(("count", "columns", "rows"), [(0, 5, 1), (5, 5, 1), (6, 5, 2), (7, 2, 4)])
def test_tiles_stand_in_order_in_rows(count: int, columns: int, rows: int) -> None:
    sheet = ContactSheet("Picks", columns)
    for k in range(count):
        sheet.add(picture(k), (640, 480), LINES)
    drawn = sheet.picture()
    assert drawn.shape == (TOP + rows * (HIGH + CAPTION_HEIGHT + TILE_GAP), TILE_GAP + columns * (WIDE + TILE_GAP), 3)
    for k in range(count):
        around = picture(k)[480 - HIGH // 2 :, 640 - WIDE // 2 :][:HIGH, :WIDE]
        assert np.array_equal(tile(drawn, k // columns, k % columns)[INSIDE], around[INSIDE])


def test_an_overview_takes_the_first_four_places() -> None:
    sheet = ContactSheet("Picks", 3)
    sheet.overview(np.full((540, 720, 3), 77, np.uint8), LINES)
    for k in range(3):
        sheet.add(picture(k), (640, 480), LINES)
    drawn = sheet.picture()
    assert (tile(drawn, 0, 0) == 77).all()
    assert (tile(drawn, 1, 1)[: HIGH // 2] == 77).all()
    for k, (row, column) in enumerate([(0, 2), (1, 2), (2, 0)]):
        around = picture(k)[480 - HIGH // 2 :, 640 - WIDE // 2 :][:HIGH, :WIDE]
        assert np.array_equal(tile(drawn, row, column)[INSIDE], around[INSIDE])


@pytest.mark.parametrize("at", [(0, 0), (1279, 959), (30.4, 500.0), (-900, 20), (5000, 5000)])
def test_a_pick_is_in_the_middle_of_its_tile_wherever_it_was(at: tuple[float, float]) -> None:
    sheet, seen = ContactSheet("Picks", 2), picture()
    sheet.add(seen, at, LINES)
    inside = tile(sheet.picture(), 0, 0)
    for down, right in ((0, 0), (60, -90), (-70, 100)):
        v, u = round(at[1]) + down, round(at[0]) + right
        expected = seen[v, u] if 0 <= v < 960 and 0 <= u < 1280 else [OUTSIDE_GREY] * 3
        assert inside[HIGH // 2 + down, WIDE // 2 + right].tolist() == list(expected)


def test_a_failed_pick_looks_different_without_colours_too() -> None:
    sheets = ContactSheet("Picks", 2), ContactSheet("Picks", 2)
    for sheet, failed in zip(sheets, ("", "missed"), strict=True):
        sheet.add(np.full((960, 1280, 3), 140, np.uint8), (640, 480), LINES, failed=failed)
    whole, failed_one = (tile(sheet.picture(), 0, 0).mean(axis=2) for sheet in sheets)
    frame = np.abs(whole - failed_one)[:5]
    assert 0.3 < (frame > 50).mean() < 0.7
    tag = np.abs(whole - failed_one)[8:40, 8:100]
    assert (tag > 50).mean() > 0.4
    assert np.array_equal(whole[60:-10, 20:-20], failed_one[60:-10, 20:-20])


def test_captions_stand_under_their_pictures_and_are_cut_where_there_is_no_room() -> None:
    sheet, long = ContactSheet("Title " * 60, 2), ("word " * 60, "word " * 60)
    for lines in (long, ("", "")):
        sheet.add(picture(), (640, 480), lines)
    drawn = sheet.picture()
    under = drawn[TOP + HIGH + 1 : TOP + HIGH + CAPTION_HEIGHT]
    assert under[:, : TILE_GAP + WIDE].min() < 60
    assert (under[:, TILE_GAP + WIDE + 1 :] == 255).all()
    assert (drawn[: TOP - 5, -TILE_GAP:] == 255).all()
    assert drawn[:TOP].min() < 60


def test_a_sheet_is_saved_whole(tmp_path: Path) -> None:
    sheet = ContactSheet("Picks")
    sheet.add(picture(), (640, 480), LINES, failed="lost")
    saved = sheet.save(tmp_path / "folder" / "sheet.png")
    with Image.open(saved) as opened:
        assert np.array_equal(np.asarray(opened), sheet.picture())
    assert list(saved.parent.iterdir()) == [saved]
    with pytest.raises(OutputError, match=r"'.jpg' is not a kind of file that is written here; give a path .* \.png"):
        sheet.save(tmp_path / "sheet.jpg")


def test_one_column_has_no_room_for_an_overview() -> None:
    with pytest.raises(InputError, match="columns of a sheet: 1 is too few; give 2 or more"):
        ContactSheet("Picks", 1)
