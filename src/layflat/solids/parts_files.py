"""Files of a parts list: CSV, XLSX and an HTML page."""

from __future__ import annotations

import csv
from datetime import datetime
from io import StringIO
from typing import TYPE_CHECKING

from layflat import extras, files
from layflat.plot import render_page

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path
    from typing import Any

    from layflat.solids.blanks import Cut
    from layflat.solids.parts_list import ListedPart, PartsList

Cell = str | int | float

PART_COLUMNS = {"number": 8, "name": 34, "made or bought": 15, "material or designation": 44, "stock": 26,
                "size (mm)": 26, "quantity": 9, "mass of one (g)": 15, "mass of all (g)": 15, "joints": 24,
                "uses": 60}  # fmt: skip
"""Headings of the columns of a parts list, and their widths in characters."""
CUT_COLUMNS = {"stock": 34, "material": 28, "part": 34, "length (mm)": 12, "pieces": 8, "length to buy (mm)": 18}
"""Headings of the columns of a list of cuts, and their widths in characters."""
MASS_COLUMNS = {"of": 24, "mass (g)": 12}
"""Headings of the columns of the table of masses, and their widths in characters."""
BOOK_DATE = datetime(2000, 1, 1)  # date in every workbook: equal lists give equal files


def part_row(part: ListedPart) -> list[Cell]:
    """Return the cells of a part in the order of `PART_COLUMNS`."""
    joints = ", ".join(f"{name or 'arm'} {number}" for name, number in part.joints.items())
    uses = "" if part.name.startswith(part.names[0][:-1]) else "; ".join(part.names)
    return [part.number, part.name, part.making, part.material, part.stock, part.size, part.quantity,
            round(1e3 * part.mass_each, 2), round(1e3 * part.mass, 2), joints, uses]  # fmt: skip


def mass_rows(parts: PartsList) -> list[list[Cell]]:
    """Return the cells of the masses of each joint, of made, of bought and of all parts."""
    masses = {name or "arm": mass for name, mass in parts.masses.items()}
    masses |= {"made parts": parts.made_mass, "bought parts": parts.bought_mass, "all": parts.mass}
    return [[name, round(1e3 * mass, 1)] for name, mass in masses.items()]


def cut_rows(cuts: Sequence[Cut]) -> list[list[Cell]]:
    """Return the cells of lengths to cut; stock, material and length to buy stand in the first row of a stock."""
    rows: list[list[Cell]] = []
    for cut in cuts:
        for k, (name, length, number) in enumerate(cut.pieces):
            first = k == 0
            rows.append([cut.stock if first else "", cut.material if first else "", name, length, number,
                         cut.total if first else ""])  # fmt: skip
    return rows


def write_parts_csv(parts: PartsList, path: Path) -> Path:
    """Write the rows of a parts list as CSV (RFC 4180) and return its path; raise OutputError if it can't."""
    text = StringIO()
    writer = csv.writer(text)
    writer.writerow(PART_COLUMNS)
    writer.writerows(part_row(part) for part in parts.parts)
    with files.whole_file(path) as temporary:
        temporary.write_bytes(text.getvalue().encode())
    return path


def write_parts_xlsx(parts: PartsList, cuts: Sequence[Cut], path: Path) -> Path:
    """Write a workbook with sheets of parts, cuts and masses; equal lists give equal bytes.

    Args:
        parts: the parts list.
        cuts: lengths to cut.
        path: of the file.

    Raises:
        MissingExtraError: the extra `cad` is not installed.
        OutputError: it can't be written.
    """
    xlsxwriter = extras.import_extra("cad", "xlsxwriter", where=str(path))
    with files.whole_file(path) as temporary, xlsxwriter.Workbook(temporary) as book:
        book.set_properties({"created": BOOK_DATE})
        _add_sheet(book, "parts", PART_COLUMNS, [part_row(part) for part in parts.parts])
        _add_sheet(book, "cuts", CUT_COLUMNS, cut_rows(cuts))
        _add_sheet(book, "masses", MASS_COLUMNS, mass_rows(parts))
    return path


def _add_sheet(book: Any, name: str, columns: dict[str, int], rows: Sequence[Sequence[Cell]]) -> None:
    """Add a sheet whose headings stay in view."""
    sheet = book.add_worksheet(name)
    heading = book.add_format({"bold": True, "bottom": 1})
    decimals = book.add_format({"num_format": "0.0"})
    for k, (title, width) in enumerate(columns.items()):
        sheet.set_column(k, k, width)
        sheet.write_string(0, k, title, heading)
    for i, row in enumerate(rows, 1):
        for k, cell in enumerate(row):
            if isinstance(cell, str):
                sheet.write_string(i, k, cell)
            else:
                sheet.write_number(i, k, cell, decimals if isinstance(cell, float) else None)
    sheet.freeze_panes(1, 0)
    sheet.autofilter(0, 0, len(rows), len(columns) - 1)
    sheet.set_landscape()
    sheet.fit_to_pages(1, 0)
    sheet.repeat_rows(0)


def parts_page(title: str, parts: PartsList, cuts: Sequence[Cut]) -> str:
    """Return an HTML page of a parts list to be printed, with lengths to cut and masses.

    Args:
        title: of the page.
        parts: the parts list.
        cuts: lengths to cut.
    """
    tables = {
        "Parts": (list(PART_COLUMNS), [part_row(part) for part in parts.parts]),
        "Cuts": (list(CUT_COLUMNS), cut_rows(cuts)),
        "Masses": (list(MASS_COLUMNS), mass_rows(parts)),
    }
    return render_page("layflat.solids", "parts.html.j2", title=title, tables=tables)
