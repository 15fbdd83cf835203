"""Files of drawings: names, bytes that depend on the machine alone, and what a reader of PDF finds."""

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from layflat import extras
from layflat.parallel import generate_in_process
from layflat.solids.drawings.assembly import DrawnMachine
from layflat.solids.drawings.write import draw_sheets, file_stem, merge_items, write_drawings
from layflat.solids.parts_list import list_parts
from tests.programs import skip_without
from tests.solids.drawings.parts import joint_parts

PARTS = [one for one in joint_parts() if one.name in {"cylinder", "arm plate", "shaft", "shell A", "bush"}]
NUMBERS = [3, 5, 8, 13, 21]
MACHINE = DrawnMachine("joint", PARTS, NUMBERS, [0.25] * len(PARTS))


def written(folder: Path, progress: list[tuple[int, int]] | None = None) -> dict[str, bytes]:
    steps = progress if progress is not None else []
    files = write_drawings(MACHINE, folder, progress=lambda *at: steps.append(at))
    assert set(files) == set(folder.iterdir())
    return {path.name: path.read_bytes() for path in files}


def test_each_made_part_has_its_files(tmp_path: Path) -> None:
    steps: list[tuple[int, int]] = []
    files = written(tmp_path / "new", steps)
    made = {f"{number:02d}-{file_stem(one.name)}" for number, one in zip(NUMBERS, PARTS, strict=True) if not one.bought}
    assert {name.rpartition(".")[0] for name in files} == made | {"00-assembly", "00-list"}
    assert {name for name in files if name.endswith(".dxf")} == {
        f"{stem}.dxf" for stem in made if "arm-plate" in stem or "shell" in stem
    }
    assert steps == [(k, 6) for k in range(1, 7)]


def test_the_same_machine_gives_the_same_bytes(tmp_path: Path) -> None:
    assert written(tmp_path / "one") == written(tmp_path / "other")


@pytest.mark.parametrize("ready", range(7))
def test_sheets_that_another_process_has_drawn_are_not_drawn_again(tmp_path: Path, ready: int) -> None:
    folder = tmp_path / "aside"
    sheets = list(draw_sheets(MACHINE, folder))
    stamps = {path: path.stat().st_mtime_ns for one in sheets[:ready] for path in one.paths}
    files = write_drawings(MACHINE, folder, sheets[:ready])
    assert files == [path for one in sheets for path in one.paths]
    assert {path for path in files if path.stat().st_mtime_ns == stamps.get(path)} == set(stamps)


def test_another_process_draws_the_same(tmp_path: Path) -> None:
    folder = tmp_path / "aside"
    with generate_in_process("layflat.solids.drawings.write:draw_sheets", MACHINE, folder) as sheets:
        files = write_drawings(MACHINE, folder, sheets)
    assert {path.name: path.read_bytes() for path in files} == written(tmp_path / "here")
    assert set(files) == set(folder.iterdir())


def test_without_ezdxf_there_are_no_contours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "available", lambda *_: False)
    assert not any(name.endswith(".dxf") for name in written(tmp_path))


def test_a_reader_of_pdf_finds_the_texts(tmp_path: Path) -> None:
    if shutil.which("pdftotext") is None:
        skip_without("poppler")
    written(tmp_path)
    path = next(tmp_path.glob("*arm-plate.pdf"))
    text = subprocess.run(["pdftotext", path, "-"], capture_output=True, check=True, text=True).stdout
    for word in ("arm plate", "laser cutting", "ISO 9013-1", "250 g", "H7", "A4"):
        assert word in text, word


def test_components_with_one_number_are_one_item() -> None:
    parts = [replace(one, joint=joint) for joint in ("a", "b") for one in PARTS[:2]]
    found = merge_items(parts, [4, 2, 4, 9])
    assert list(found) == [2, 4, 9]
    assert found[4].quantity == 2 * PARTS[0].quantity
    assert found[4].joint == "a, b"
    assert found[4].name == PARTS[0].name


def test_items_agree_with_the_parts_list() -> None:
    parts = list_parts(joint_parts(), lambda _: 0.1)
    items = merge_items(joint_parts(), [parts.part(one).number for one in joint_parts()])
    listed = [(one.number, one.name, one.quantity) for one in parts.parts]
    assert [(number, one.name, one.quantity) for number, one in items.items()] == listed


def test_a_machine_without_solids_has_no_drawings(tmp_path: Path) -> None:
    assert write_drawings(DrawnMachine("none", [], [], []), tmp_path) == []
    assert not list(tmp_path.iterdir())
