from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from layflat.cell.file.loader import CELL_LIBRARY, LAYOUT_LIBRARY, build_cell, load, names
from layflat.cell.file.model import Cell
from layflat.errors import CellError, MachineError

MARKERS = {
    "thickness": "1 mm",
    "marker": {"one": {"number": 7, "centre": ["708 mm", "72 mm"], "side": "40 mm", "rotation": "0 deg"}},
}


def broken(path: str, value: Any) -> str:
    """What is said of the built-in cell with one value changed."""
    plain, sources = CELL_LIBRARY.tables("packing")
    *above, last = path.split("/")
    table = plain
    for key in above:
        table = table[key]
    table[last] = value
    with pytest.raises((CellError, MachineError)) as caught:
        build_cell(plain, sources, "mine.toml")
    text = str(caught.value)
    assert text.startswith("mine.toml")
    assert "\n" not in text
    return text


def test_built_in_cells_and_layouts_are_sound_and_sourced(packing: Cell) -> None:
    assert names() == ("belt", "packing")
    assert set(LAYOUT_LIBRARY.names) == {"punnet-2x3", "tray-12"}
    assert {pack.layout.name for pack in packing.container.values()} == set(LAYOUT_LIBRARY.names)
    for cell in (packing, load("belt")):
        sources = cell.provenance.items()
        assert [path for path, found in sources if path not in {"name", "title"} and not found.note] == []


def test_units_are_si_behind_the_file(packing: Cell) -> None:
    assert packing.lift.stroke == pytest.approx(0.16)
    assert packing.cup.vacuum == pytest.approx(0.7e5)
    assert packing.camera.focal_pixels == pytest.approx(8e-3 / 3.75e-6)


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("lift/stroke", 0.2, "mine.toml: lift.stroke: 0.2 is a bare number"),
        ("lift/strok", "1 mm", "did you mean 'stroke'?"),
        ("table/size", ["1 m", "0.5 m"], "does not stand on the table"),
        ("tray/infeed/centre", ["300 mm", "250 mm"], "tray.infeed and container.apples overlap"),
        ("tray/infeed/centre", ["670 mm", "300 mm"], "tray.infeed is out of the arm's reach by "),
        ("container/tomatoes/centre", ["0 mm", "800 mm"], "container.tomatoes is out of the arm's reach by "),
        ("container/apples/layout", "punnet-2x3", "container.apples is too small: a place of 'punnet-2x3' takes 70 mm"),
        ("container/apples/kind", "pear", "container.apples.kind is the unknown kind 'pear'"),
        ("container/apples/grade", "third", "container.apples.grade 'third' is none of apple"),
        ("tray/infeed/produce", ["apple", "pear"], "tray.infeed.produce names the unknown kind 'pear'"),
        ("lift/stroke", "140 mm", "lift.stroke is too short"),
        ("mount/home", {"large": "0 deg"}, "mount.home"),
        ("mount/home", {"large": "0 deg", "small": "61 deg"}, "mount.home.small is outside"),
        ("machine", "paper-large-joint", "is not a level arm of two joints"),
        ("base_markers/marker/left-near/centre", ["0 mm", "60 mm"], "marker.left-near and the arm's column overlap"),
        ("base_markers/marker/left-near/number", 41, "left-near.number 41 is that of 'right-far' too"),
        ("base_markers/marker", {}, "base_markers.marker"),
        ("base_markers", MARKERS | {"dictionary": "DICT_4X4_50"}, "number 7 is one of the board's (0 to 23)"),
        ("container/tomatoes/kind", "plum", "container.tomatoes.kind 'plum' is not recognised by vision"),
        ("clutter/leaves/shape", "blob", "clutter.leaves.shape"),
        ("cup/tilt", "22 mm", "is not an angle"),
        ("cup/diameter", "25 m", "mine.toml: cup.diameter: '25 m' is out of range; "),
        ("cup/diameter", "45 mm", "cup.diameter 45 mm is wider than the smallest fruit, 36 mm; give less"),
        ("cup/friction", 1e6, "cup.friction"),
        ("lift/mass", "1e9 kg", "lift.mass"),
        ("tray/infeed/size", ["1e200 m", "1 m"], "tray.infeed.size"),
        ("camera/focal_length", "8 km", "camera.focal_length"),
        ("camera/blur", 1e9, "camera.blur"),
        ("camera/looks_at", ["3000 mm", "370 mm", "0 mm"], "camera does not see tray.infeed: its centre is outside"),
        ("camera/looks_at", ["300 mm", "370 mm", "3000 mm"], "camera looks up, not at the table"),
        ("camera/position", ["300 mm", "370 mm", "100 mm"], "camera.position is not above the lift, 180 mm; raise it"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(path: str, value: Any, said: str) -> None:
    assert said in broken(path, value)


def test_a_held_fruit_has_to_pass_over_the_others() -> None:
    text = broken("lift", CELL_LIBRARY.tables("packing")[0]["lift"] | {"stroke": "130 mm", "clearance": "150 mm"})
    assert "lift.clearance is too small: a fruit of 75 mm must pass over 79 mm" in text


def test_a_colour_that_no_grade_knows_is_refused() -> None:
    text = broken("produce/apple/grade/first/colours", ["blue"])
    assert "grade 'first' names the colour 'blue'" in text


def test_files_extend_and_name_others_beside_them(tmp_path: Path) -> None:
    (tmp_path / "six.toml").write_text(
        'name = "six"\ntitle = "Six"\ncolumns = 3\nrows = 2\npitch = ["75 mm", "75 mm"]\nwall = "3 mm"\n'
        'height = "30 mm"\ndivider = "0 mm"\ncolour = [0.2, 0.3, 0.4]\n'
    )
    mine = tmp_path / "mine.toml"
    mine.write_text('extends = "packing"\n[lift]\nspeed = "0.3 m/s"\n[container.tomatoes]\nlayout = "six.toml"\n')
    cell = load(mine)
    assert cell.lift.speed == pytest.approx(0.3)
    assert cell.lift.acceleration == load("packing").lift.acceleration
    assert cell.container["tomatoes"].layout.title == "Six"
    assert cell.container["mushrooms"].layout.name == "punnet-2x3"
    assert cell.origin == str(mine)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("lift = ", "is not TOML"),
        ('extends = "pakking"', "did you mean 'packing'?"),
        ('extends = "packing"\n[container.tomatoes]\nlayout = "punnet"', "did you mean 'punnet-2x3'?"),
        ('extends = "packing"\n[container.tomatoes]\nlayout = "none.toml"', "can't be read"),
        ('extends = "packing"\nmachine = "paper-am"', "paper-arm"),
        ('extends = "mine.toml"', "break the circle"),
        ('extends = "packing"\n[lift]\nspeed = { value = "1 m/s", source = "guess" }', "source 'guess' is unknown"),
        ('name = "mine"', "is missing"),
    ],
)
def test_broken_files_are_told(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises((CellError, MachineError), match=r"mine\.toml|pakking|punnet|none\.toml|paper-am") as caught:
        load(path)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_cell_that_is_not_there_is_told() -> None:
    with pytest.raises(CellError, match="did you mean 'packing'"):
        load("packin")
