"""The command that runs parameter studies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import Out, app, print_table

if TYPE_CHECKING:
    from layflat.study import Study


@app.command()
def study(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="what to vary, in TOML")],
    out: Out = Path("build/study"),
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="of a Dask cluster that does the work")
    ] = None,
) -> None:
    """Run a parameter study: a table of metrics, a row a run. A stopped study goes on where it was."""
    from layflat.study import read, run  # noqa: PLC0415
    from layflat.study.folder import ChangedError  # noqa: PLC0415

    described = read(file)
    try:
        with _progress() as advance:
            table = run(described, out, scheduler=scheduler, progress=advance)
    except ChangedError as error:
        typer.echo(f"layflat: {error}", err=True)
        for line in error.differences:
            typer.echo(f"  {line}", err=True)
        raise typer.Exit(2) from None
    except KeyboardInterrupt:
        typer.echo("layflat: stopped; the same command goes on from here", err=True)
        raise typer.Exit(130) from None
    _print_summary(described, out)
    typer.echo(f"wrote {table}")


def _print_summary(described: Study, out: Path) -> None:
    from layflat.study.summary import SHARES, summary  # noqa: PLC0415

    found = summary(out, described.metrics)
    rows = [
        [name, unit, *(f"{value:.4g}" if abs(value) != float("inf") else "not settled" for value in values)]
        for name, (unit, values) in found.quantiles.items()
    ]
    columns = ["metric", "unit", *(f"{100 * share:g} %" for share in SHARES)]
    title = f"{described.name}: {described.samples} samples, {found.runs} runs; this share of them lies below"
    print_table(columns, rows, title)
    if found.settled is not None:
        typer.echo(f"{100 * found.settled:.1f} % settled in every move")
    typer.echo(f"{found.diverged} of {found.runs} runs diverged")


@contextmanager
def _progress() -> Iterator[Callable[[int, int], None]]:
    """A bar over the runs."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn  # noqa: PLC0415

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("runs (compiles for some seconds the first time)", total=None)

        def advance(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total, description="runs" if done else None)

        yield advance
