"""Files of a parts list hold its rows: numbers as numbers, masses that add up, equal bytes for equal lists."""

from __future__ import annotations

import csv
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from layflat.errors import MissingExtraError
from layflat.solids.blanks import list_cuts
from layflat.solids.cost import Cost
from layflat.solids.parts_files import (
    CUT_COLUMNS,
    PART_COLUMNS,
    PRICE_COLUMNS,
    cost_rows,
    mass_rows,
    part_row,
    parts_page,
    write_parts_csv,
    write_parts_xlsx,
)
from layflat.solids.parts_list import list_parts
from tests.solids.joints import components_of, mass_by_name

if TYPE_CHECKING:
    from pathlib import Path

SMALL = components_of("paper-arm", "small")
PARTS = list_parts(SMALL, mass_by_name)
CUTS = list_cuts(SMALL)
ALL = list(PART_COLUMNS).index("mass of all (g)")


def test_masses_of_the_rows_add_up_to_that_of_the_assembly_within_a_gram() -> None:
    grams = sum(float(part_row(part)[ALL]) for part in PARTS.parts)
    assert grams == pytest.approx(1e3 * PARTS.mass, abs=1.0)
    masses = {str(name): float(mass) for name, mass in mass_rows(PARTS)}
    assert masses["small"] == masses["all"] == pytest.approx(masses["made parts"] + masses["bought parts"], abs=0.11)


def test_csv_is_that_of_rfc_4180(tmp_path: Path) -> None:
    text = write_parts_csv(PARTS, tmp_path / "parts.csv").read_bytes().decode()
    assert text.count("\r\n") == text.count("\n") == len(PARTS.parts) + 1
    heading, *rows = csv.reader(text.splitlines())
    assert heading == list(PART_COLUMNS)
    assert rows == [[str(cell) for cell in part_row(part)] for part in PARTS.parts]


def test_a_workbook_holds_numbers_below_a_heading_that_stays(tmp_path: Path) -> None:
    pytest.importorskip("xlsxwriter")
    openpyxl = pytest.importorskip("openpyxl")
    path = write_parts_xlsx(PARTS, CUTS, tmp_path / "parts.xlsx")
    book = openpyxl.load_workbook(path)
    assert book.sheetnames == ["parts", "cuts", "masses"]
    heading, *rows = book["parts"].iter_rows(values_only=True)
    assert list(heading) == list(PART_COLUMNS)
    assert [[cell if cell is not None else "" for cell in row] for row in rows] == [
        part_row(part) for part in PARTS.parts
    ]
    assert book["parts"].freeze_panes == "A2"
    assert book["parts"].column_dimensions["B"].width == pytest.approx(PART_COLUMNS["name"], abs=1.0)
    assert len(list(book["cuts"].iter_rows())) == 1 + sum(len(cut.pieces) for cut in CUTS)
    assert path.read_bytes() == write_parts_xlsx(PARTS, CUTS, tmp_path / "again.xlsx").read_bytes()


def test_a_workbook_without_its_package_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "xlsxwriter", None)
    with pytest.raises(MissingExtraError, match=r"layflat\[cad\]"):
        write_parts_xlsx(PARTS, CUTS, tmp_path / "parts.xlsx")


def test_a_page_holds_all_rows_and_escapes_texts() -> None:
    odd = list_parts([replace(SMALL[0], name="<cylinder>"), *SMALL[1:]], mass_by_name)
    page = parts_page("Parts & cuts", odd, CUTS)
    assert "Parts &amp; cuts" in page
    assert "&lt;cylinder&gt;" in page
    rows = len(odd.parts) + sum(len(cut.pieces) for cut in CUTS) + len(mass_rows(odd))
    assert page.count("<tr>") == rows + 3
    assert all(column in page for column in (*PART_COLUMNS, *CUT_COLUMNS))


COST = Cost({part.number: 1.25 for part in PARTS.parts[1:]}, {"small": 80.0, "": 2.5}, PARTS.parts[:1])


def test_prices_stand_in_two_more_columns_of_all_files(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    text = write_parts_csv(PARTS, tmp_path / "parts.csv", COST).read_text(encoding="utf-8")
    heading, first, *rows = csv.reader(text.splitlines())
    assert heading == [*PART_COLUMNS, *PRICE_COLUMNS]
    assert first[-2:] == ["", ""]
    prices = [[1.25, 1.25 * part.quantity] for part in PARTS.parts[1:]]
    assert [[float(cell) for cell in row[-2:]] for row in rows] == prices
    book = openpyxl.load_workbook(write_parts_xlsx(PARTS, CUTS, tmp_path / "parts.xlsx", COST))
    sheet = list(book["parts"].iter_rows(values_only=True))
    assert [list(row[-2:]) for row in sheet[2:]] == prices
    assert list(book["costs"].iter_rows(values_only=True))[1:] == [tuple(row) for row in cost_rows(COST)]
    page = parts_page("Parts", PARTS, CUTS, COST)
    assert page.count('<td class="figure">1.25</td>') >= len(prices)
    assert cost_rows(COST) == [["small", 80.0], ["arm", 2.5], ["all", 82.5], ["kinds of parts without a price", 1]]
