"""Command that gives files of the last version the present names of keys: migrate."""

from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.common import count_noun
from layflat.cli.groups import app


@app.register("migrate", "mine.toml", "--dry-run mine.toml study.toml")
def migrate_files(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="files of the last version")],
    dry_run: Annotated[bool, typer.Option("--dry-run", help="print the changes, and write nothing")] = False,
) -> None:
    """Rewrite files of the last version with the keys of this one.

    Comments, order and format stay. If a file can't be understood, no file is changed.
    """
    from layflat.cli.migration import plan_migration  # noqa: PLC0415

    for plan in [plan_migration(path) for path in files]:
        for one in plan.renamed:
            typer.echo(f"{plan.path}: {'.'.join(map(str, one.steps))} -> {one.present}")
        if not plan.renamed:
            typer.echo(f"{plan.path}: nothing to rename")
            continue
        names = count_noun(len(plan.renamed), "name")
        if dry_run:
            typer.echo(f"{plan.path}: {names} would change")
            continue
        plan.write()
        typer.echo(f"{plan.path}: {names} changed")
