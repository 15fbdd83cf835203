"""Small tables of results in HTML, as notebooks show them."""

from collections.abc import Iterable, Sequence
from html import escape


def html_table(caption: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return an HTML table; all texts are escaped.

    Args:
        caption: above the table.
        columns: heads of the columns, with units; empty: none are shown.
        rows: cells of each row.
    """
    heads = "".join(f"<th>{escape(column)}</th>" for column in columns)
    lines = ["<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows]
    head = f"<thead><tr>{heads}</tr></thead>" if columns else ""
    title = f'<caption style="caption-side: top; text-align: left">{escape(caption)}</caption>'
    return f"<table>{title}{head}<tbody>{''.join(lines)}</tbody></table>"
