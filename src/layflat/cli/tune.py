"""The command that tunes controllers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import WIDTH, MachineName, Out, app, print_table

if TYPE_CHECKING:
    from layflat.tune import Progress, Tuning
    from layflat.tune.search import Found


@app.command()
def tune(
    machine: MachineName,
    method: Annotated[
        str,
        typer.Option(
            metavar="global|phases", help="all gains at once, or as the paper: joint by joint, phase by phase"
        ),
    ] = "global",
    start: Annotated[str, typer.Option("--from", metavar="neutral|current", help="gains to begin with")] = "neutral",
    generations: Annotated[
        int | None, typer.Option(help="of the search, in all; as many as the method needs where not given")
    ] = None,
    seed: Annotated[int, typer.Option(help="of the search; the same seed finds the same gains")] = 1,
    out: Out = Path("build/tune"),
) -> None:
    """Find a controller's gains: a description with them, and a page with what they do.

    What counts is how soon moves settle, over payloads, supplies, losses and drifts that differ, the worst of them and
    the nominal ones most. Ctrl-C ends the search; the best gains so far are kept.
    """
    from layflat.tune import begin  # noqa: PLC0415
    from layflat.tune.cost import STATEMENT  # noqa: PLC0415
    from layflat.tune.page import figures_of, write_page  # noqa: PLC0415
    from layflat.tune.verdict import verdict  # noqa: PLC0415

    tuning = begin(machine, out, method=method, start=start, seed=seed, generations=generations)
    with _progress(tuning) as advance:
        tuning.seek(advance)
    tuned = tuning.keep()
    done = f"{len(tuning.told) - 1} of {tuning.generations} generations in {tuning.seconds:.1f} s"
    typer.echo(f"layflat: stopped after {done}" if tuning.stopped else done, err=tuning.stopped)
    typer.echo(f"wrote {tuning.path}")
    before = verdict(tuning.base) if tuning.has_gains else None
    after = verdict(tuned)
    print_table(["settling within 0.3 deg", "before", "after"], figures_of(tuning.machine, before, after), tuned.name)
    typer.echo(fill(STATEMENT, WIDTH))
    if tuning.kept:
        typer.echo("no better gains were found: those that were there stay")
    typer.echo(f"wrote {write_page(tuning, tuned, before, after, out / 'tuning.html')}")
    if tuning.stopped:
        raise typer.Exit(130)


@contextmanager
def _progress(tuning: Tuning) -> Iterator[Progress]:
    """A bar over the generations, with the best cost so far."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn  # noqa: PLC0415

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("compiling (for some seconds, the first time only)", total=tuning.generations)

        def advance(best: Found, done: int, name: str) -> None:
            bar.update(task, completed=done, description=f"{name or 'first gains'}: best cost {best.cost:.2f} s")

        yield advance
