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
    from layflat.solids.cost import Cost
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
PRICE_COLUMNS = {"price of one": 13, "price of all": 13}
"""Headings of the columns of prices in a parts list, and their widths in characters."""
COST_COLUMNS = {"of": 24, "price": 12}
"""Headings of the columns of the table of costs, and their widths in characters."""
BOOK_DATE = datetime(2000, 1, 1)  # date in every workbook: equal lists give equal files


def part_columns(cost: Cost | None = None) -> dict[str, int]:
    """Return the headings of the columns of a parts list, with prices if there is a cost, and their widths."""
    return PART_COLUMNS if cost is None else PART_COLUMNS | PRICE_COLUMNS


def part_row(part: ListedPart, cost: Cost | None = None) -> list[Cell]:
    """Return the cells of a part in the order of `part_columns`; those of a missing price are empty."""
    price = cost.each.get(part.number) if cost else None
    prices: list[Cell] = [] if price is None else [round(price, 2), round(part.quantity * price, 2)]
    joints = ", ".join(f"{name or 'arm'} {number}" for name, number in part.joints.items())
    uses = "" if part.name.startswith(part.names[0][:-1]) else "; ".join(part.names)
    return [part.number, part.name, part.making, part.material, part.stock, part.size, part.quantity,
            round(1e3 * part.mass_each, 2), round(1e3 * part.mass, 2), joints, uses,
            *(prices or ([""] * len(PRICE_COLUMNS) if cost else []))]  # fmt: skip


def mass_rows(parts: PartsList) -> list[list[Cell]]:
    """Return the cells of the masses of each joint, of made, of bought and of all parts."""
    masses = {name or "arm": mass for name, mass in parts.masses.items()}
    masses |= {"made parts": parts.made_mass, "bought parts": parts.bought_mass, "all": parts.mass}
    return [[name, round(1e3 * mass, 1)] for name, mass in masses.items()]


def cost_rows(cost: Cost) -> list[list[Cell]]:
    """Return the cells of the costs of each joint and of all parts, and the number of kinds without a price."""
    costs = {name or "arm": price for name, price in cost.joints.items()} | {"all": cost.total}
    rows: list[list[Cell]] = [[name, round(price, 2)] for name, price in costs.items()]
    return [*rows, ["kinds of parts without a price", len(cost.unpriced)]] if cost.unpriced else rows


def cut_rows(cuts: Sequence[Cut]) -> list[list[Cell]]:
    """Return the cells of lengths to cut; stock, material and length to buy stand in the first row of a stock."""
    rows: list[list[Cell]] = []
    for cut in cuts:
        for k, (name, length, number) in enumerate(cut.pieces):
            first = k == 0
            rows.append([cut.stock if first else "", cut.material if first else "", name, length, number,
                         cut.total if first else ""])  # fmt: skip
    return rows


Table = tuple[dict[str, int], list[list[Cell]]]  # columns with their widths, and rows


def list_tables(parts: PartsList, cuts: Sequence[Cut], cost: Cost | None = None) -> dict[str, Table]:
    """Return the tables of a parts list by their titles.

    Args:
        parts: the parts list.
        cuts: lengths to cut.
        cost: of the parts; default: without prices.
    """
    tables: dict[str, Table] = {
        "parts": (part_columns(cost), [part_row(part, cost) for part in parts.parts]),
        "cuts": (CUT_COLUMNS, cut_rows(cuts)),
        "masses": (MASS_COLUMNS, mass_rows(parts)),
    }
    return tables | ({"costs": (COST_COLUMNS, cost_rows(cost))} if cost else {})


def write_parts_csv(parts: PartsList, path: Path, cost: Cost | None = None) -> Path:
    """Write the rows of a parts list as CSV (RFC 4180).

    Args:
        parts: the parts list.
        path: of the file.
        cost: of the parts; default: without prices.

    Raises:
        OutputError: it can't be written.
    """
    text = StringIO()
    writer = csv.writer(text)
    writer.writerow(part_columns(cost))
    writer.writerows(part_row(part, cost) for part in parts.parts)
    with files.whole_file(path) as temporary:
        temporary.write_bytes(text.getvalue().encode())
    return path


def write_parts_xlsx(parts: PartsList, cuts: Sequence[Cut], path: Path, cost: Cost | None = None) -> Path:
    """Write a workbook with a sheet for each table; equal lists give equal bytes.

    Args:
        parts: the parts list.
        cuts: lengths to cut.
        path: of the file.
        cost: of the parts; default: without prices.

    Raises:
        MissingExtraError: the extra `cad` is not installed.
        OutputError: it can't be written.
    """
    xlsxwriter = extras.import_extra("cad", "xlsxwriter", where=str(path))
    with files.whole_file(path) as temporary, xlsxwriter.Workbook(temporary) as book:
        book.set_properties({"created": BOOK_DATE})
        for name, (columns, rows) in list_tables(parts, cuts, cost).items():
            _add_sheet(book, name, columns, rows)
    return path


def _add_sheet(book: Any, name: str, columns: dict[str, int], rows: Sequence[Sequence[Cell]]) -> None:
    """Add a sheet whose headings stay in view."""
    sheet = book.add_worksheet(name)
    heading = book.add_format({"bold": True, "bottom": 1})
    decimals = [book.add_format({"num_format": "0.00" if _is_price(title) else "0.0"}) for title in columns]
    for k, (title, width) in enumerate(columns.items()):
        sheet.set_column(k, k, width)
        sheet.write_string(0, k, title, heading)
    for i, row in enumerate(rows, 1):
        for k, cell in enumerate(row):
            if isinstance(cell, str):
                sheet.write_string(i, k, cell)
            else:
                sheet.write_number(i, k, cell, decimals[k] if isinstance(cell, float) else None)
    sheet.freeze_panes(1, 0)
    sheet.autofilter(0, 0, len(rows), len(columns) - 1)
    sheet.set_landscape()
    sheet.fit_to_pages(1, 0)
    sheet.repeat_rows(0)


def _is_price(title: str) -> bool:
    return title.startswith("price")


def parts_page(title: str, parts: PartsList, cuts: Sequence[Cut], cost: Cost | None = None) -> str:
    """Return an HTML page of a parts list to be printed, with lengths to cut and masses.

    Args:
        title: of the page.
        parts: the parts list.
        cuts: lengths to cut.
        cost: of the parts; default: without prices.
    """
    tables = {
        name.capitalize(): (list(columns), [2 if _is_price(one) else 1 for one in columns], rows)
        for name, (columns, rows) in list_tables(parts, cuts, cost).items()
    }
    return render_page("layflat.solids", "parts.html.j2", title=title, tables=tables)
