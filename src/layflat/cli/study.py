"""Commands about parameter studies: studies, study."""

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import WIDTH, Device, app, counted, print_table
from layflat.cli.bars import steps_bar

if TYPE_CHECKING:
    from layflat.study import Study


@app.command()
def studies(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="print its file, to start from")] = None,
) -> None:
    """List the built-in studies, or print one."""
    from layflat.study import names, read  # noqa: PLC0415
    from layflat.study.study import STUDIES  # noqa: PLC0415

    if name is not None:
        typer.echo(STUDIES.text(name), nl=False)
        return
    described = [read(one) for one in names()]
    print_table(["study", "runs", "what it asks"], [[s.name, str(s.rows), s.file.title] for s in described])


@app.command()
def study(
    file: Annotated[str, typer.Argument(metavar="NAME|FILE", help="built-in study, or what to vary, in TOML")],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="for the results; default: build/study/NAME")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="of a Dask cluster that does the work")
    ] = None,
    device: Device = "cpu",
) -> None:
    """Run a parameter study; needs the extra `study`.

    Writes a table of metrics, a row a run, and a figure. A stopped study continues where it was. Runs of up to a minute
    are computed in single precision, unless the file says precision = "double".
    """
    from layflat.study import names, read, run, table  # noqa: PLC0415
    from layflat.study.folder import ChangedError  # noqa: PLC0415
    from layflat.study.results import draw, write_figure  # noqa: PLC0415

    described = read(file)
    place = out or Path("build/study") / described.name
    try:
        with steps_bar("runs") as advance:
            path = run(described, place, scheduler=scheduler, device=device, progress=advance)
    except ChangedError as error:
        typer.echo(f"layflat: {error}", err=True)
        for line in error.differences:
            typer.echo(f"  {line}", err=True)
        raise typer.Exit(2) from None
    _print_summary(described, place)
    typer.echo(f"wrote {path} and .csv")
    if file not in names():
        typer.echo(f"wrote {write_figure(draw(described, table(place)), place)} and .png")
        return
    from layflat.experiments.questions import answer  # noqa: PLC0415  # one of the paper's open questions

    found = answer(file, place)
    typer.echo(f"wrote {place / 'figure.svg'} and .png\n\n{fill(found.finding, WIDTH)}")


def _print_summary(described: "Study", out: Path) -> None:
    from layflat.study.results import SHARES, summary  # noqa: PLC0415

    found = summary(out, described.metrics)
    rows = [
        [name, unit, *(f"{value:.4g}" if abs(value) != float("inf") else "not settled" for value in values)]
        for name, (unit, values) in found.quantiles.items()
    ]
    columns = ["metric", "unit", *(f"{100 * share:g} %" for share in SHARES)]
    made = f"{counted(found.runs, 'run')} in {described.precision} precision"
    title = f"{described.name}: {counted(described.samples, 'sample')}, {made}; this share of them lies below"
    print_table(columns, rows, title)
    if found.settled is not None:
        typer.echo(f"{100 * found.settled:.1f} % settled in every move")
    typer.echo(f"{found.diverged} of {counted(found.runs, 'run')} diverged")
