"""Commands that identify machines and benches: excite, identify."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import MachineName, Out, app, print_table
from layflat.errors import InputError

if TYPE_CHECKING:
    from layflat.identify.fit.search import Progress

NOT_TRUSTED = 3
"""Exit status of a fit at a bound, or that came to no end."""


@app.command()
def excite(
    machine: MachineName,
    reach: Annotated[float, typer.Option(help="largest angle from the middle, share of the working stroke")] = 0.3,
    speed: Annotated[str, typer.Option(help="greatest rate of the demand")] = "300 deg/s",
    seed: Annotated[int, typer.Option(help="of sizes and order")] = 0,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="[NAME]-excite.csv")] = None,
) -> None:
    """Write a bench sequence from which a machine can be identified: demands for its controller."""
    from layflat.identify.excite import sequence  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.machine import units as u  # noqa: PLC0415
    from layflat.sim.demand_file import write_demand  # noqa: PLC0415

    described = load(machine)
    time, demand = sequence(described, reach=reach, speed=u.quantity(speed, u.ANGULAR_SPEED, "--speed"), seed=seed)
    path = write_demand(described, time, demand, out or Path(f"{described.name}-excite.csv"))
    typer.echo(f"wrote {path}: {time[-1]:.0f} s of steps, chirps, slow ramps, small moves and pauses")
    typer.echo(f"simulate it with `layflat simulate {machine} --demand {path}`; start with the joints at rest")


@app.command()
def identify(
    logs: Annotated[list[Path], typer.Argument(metavar="LOG...", help="CSV, Parquet, NetCDF or MCAP")],
    machine: Annotated[str, typer.Option(metavar="NAME|FILE", help="machine or bench to begin with")],
    fit: Annotated[
        str | None, typer.Option(metavar="A,B", help="blocks, such as valve,hose; the usual where not given")
    ] = None,
    validate: Annotated[
        list[Path] | None,
        typer.Option(metavar="LOG", help="judge by this log in place of the last third; repeatable"),
    ] = None,
    mapping: Annotated[
        Path | None, typer.Option(metavar="FILE", help="what the logs' columns are; not needed for our own names")
    ] = None,
    starts: Annotated[int | None, typer.Option(help="of the search, besides the description's own values")] = None,
    seed: Annotated[int, typer.Option(help="of starts and intervals")] = 0,
    out: Out = Path("build/identify"),
) -> None:
    """Find the parameters that explain bench logs: a fitted description, and a page with what it is worth.

    Exit status 3 if a value ran into the end of its range or the search came to no end: the file says so too.
    """
    from layflat.identify.identification import begin  # noqa: PLC0415
    from layflat.identify.page import QUALITY_COLUMNS, doubtful_row, quality_row, value_row, write_page  # noqa: PLC0415

    if starts is not None and starts < 0:
        raise InputError(f"{starts} is out of range", where="--starts", right="give 0 or more")
    with _busy("reading"):
        session = begin(logs, machine, out, blocks=fit, validate=validate or [], mapping=mapping)
    for name, findings in session.findings.items():
        rows = [[f.severity, f.channel, f.text, f.right] for f in findings]
        if rows:
            print_table(["severity", "channel", "found", "what is right, or follows"], rows, name)
            typer.echo()
    with _progress() as progress:
        found = session.fit(starts=starts, seed=seed, progress=progress)
    session.keep(found)
    values = session.values(found)
    told = [value_row(value) for value in values if value.told]
    print_table(["value", "found", "95 %", "before"], told, "what the logs tell")
    doubtful = [doubtful_row(value) for value in values if not value.told]
    if doubtful:
        typer.echo()
        columns = ["value", "fits best", "95 %", "why", "what would tell it"]
        print_table(columns, doubtful, "what they do not tell")
    typer.echo()
    print_table(QUALITY_COLUMNS, [quality_row(quality) for quality in found.qualities()], "how well it predicts")
    typer.echo(f"wrote {session.path}")
    typer.echo(f"wrote {write_page(session, found, session.path.with_suffix('.html'))}")
    if not found.trusted:
        at = [value.path for value in values if value.at_bound]
        why = f"{at[0]} is at the end of its range" if at else "the search came to no end"
        typer.echo(f"layflat: not to be trusted: {why}; the file says so", err=True)
        raise typer.Exit(NOT_TRUSTED)


@contextmanager
def _busy(what: str) -> Iterator[None]:
    from rich.console import Console  # noqa: PLC0415

    with Console(stderr=True).status(what):
        yield


@contextmanager
def _progress() -> Iterator[Progress]:
    """A bar that is never behind: a search may end sooner than it could."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("compiling (for some seconds, the first time only)", total=1.0)
        yield lambda share, text: bar.update(task, completed=share, description=text)
