"""The command that reproduces the paper."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import fill
from typing import Annotated

import typer

from layflat.cli.app import WIDTH, Out, app, print_table


@app.command()
def reproduce(
    machine: Annotated[
        str, typer.Option("--machine", "-m", metavar="NAME|FILE", help="the arm under test")
    ] = "paper-arm",
    out: Out = Path("build/reproduce"),
    questions: Annotated[
        bool, typer.Option("--questions", help="run the studies of the paper's open questions, too (minutes)")
    ] = False,
) -> int:
    """Reproduce the paper: perform its experiments, judge its claims, write report.html and claims.json.

    The report shows the open questions whose studies are done below the folder.
    """
    from layflat.experiments import bench, reproduce, write_claims, write_report  # noqa: PLC0415
    from layflat.experiments.questions import answers  # noqa: PLC0415
    from layflat.experiments.report import lines  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine.listing import listing  # noqa: PLC0415

    on = bench(machine)
    check_folder(out)
    if questions:
        _ask(out / "questions")
    with _progress() as advance:
        found = reproduce(on, advance)
        assumed = [line for line in listing(machine) if line.source in {"assumed", "calibrated", "identified", "given"}]
        write_claims(found, out / "claims.json")
        answered = answers(out / "questions")
        report = write_report(found, assumed, out / "report.html", answered)
    rows = [[c.id, c.where, "\n".join(lines(c)), c.unit, "yes" if c.agrees else "NO"] for c in found.claims]
    print_table(["claim", "where", "simulated", "unit", "agrees"], rows)
    typer.echo(f"{sum(c.agrees for c in found.claims)} of {len(found.claims)} claims agree; wrote {report}")
    for one in answered:
        typer.echo(f"\n{one.title}\n{fill(one.finding, WIDTH)}")
    return 0 if found.agrees else 1


def _ask(out: Path) -> None:
    """Run the studies of the open questions, or what is left of them."""
    from layflat.cli.study import runs_bar  # noqa: PLC0415
    from layflat.experiments.questions import QUESTIONS, ask  # noqa: PLC0415

    for number, name in enumerate(QUESTIONS, 1):
        with runs_bar(f"question {number} of {len(QUESTIONS)}, {name}") as advance:
            ask(name, out / name, advance)


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """A bar over the experiments."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    from layflat.experiments import EXPERIMENTS  # noqa: PLC0415

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("compiling (the first time only)", total=len(EXPERIMENTS) + 1)

        def advance(name: str) -> None:
            bar.update(task, advance=1, description=f"done: {name}")

        yield advance
