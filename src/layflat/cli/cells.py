"""Command about cell descriptions: cells."""

from __future__ import annotations

from typing import Annotated

import typer

from layflat.cli.app import app, print_table


@app.command()
def cells(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="print its file, to start from")] = None,
) -> None:
    """List the built-in packing cells, or print one."""
    from layflat.cell.file import load, names, text  # noqa: PLC0415

    if name is not None:
        typer.echo(text(name), nl=False)
        return
    described = [load(one) for one in names()]
    rows = [[cell.name, cell.machine.name, ", ".join(cell.container), cell.title] for cell in described]
    print_table(["cell", "machine", "containers", "title"], rows)
