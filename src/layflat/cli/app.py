"""The application, and what its commands share. Every command imports what it needs, when it runs."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.errors import InputError

if TYPE_CHECKING:
    from layflat.design import Finding
    from layflat.machine import Machine

app = typer.Typer(
    name="layflat",
    help="Design, simulate and control robot joints made of layflat hose.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

MachineName = Annotated[str, typer.Argument(metavar="NAME|FILE", help="built-in machine or description file")]
Out = Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="folder for the results")]

WIDTH = 100
"""Columns that a table may take."""


def print_table(columns: list[str], rows: list[list[str]], title: str = "") -> None:
    """Print a table that fits 100 columns."""
    from rich.console import Console  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415

    table = Table(title=title or None, title_justify="left", header_style="bold", show_edge=False)
    for column in columns:
        table.add_column(column, overflow="fold")
    for row in rows:
        table.add_row(*row)
    console = Console(highlight=False)
    console.width = min(console.width if console.is_terminal else WIDTH, WIDTH)
    console.print(table)


def print_findings(findings: Iterable[Finding]) -> None:
    """Print what the design rules found, if anything."""
    rows = [[f.severity, f.where, f.what, f.right] for f in findings]
    if rows:
        print_table(["severity", "where", "found", "what is right, or follows"], rows)


def known_joint(machine: Machine, joint: str) -> str:
    """A joint of a machine, by the name given to --joint.

    Raises:
        InputError: there is none of this name.
    """
    if joint not in machine.joints:
        raise InputError(f"{joint!r} is no joint here", where="--joint", right=f"give {' or '.join(machine.joints)}")
    return joint
