"""Commands that identify machines and benches: excite, identify."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import MachineName, Out, app, naming_options, print_table
from layflat.cli.bars import bar, busy
from layflat.errors import InputError, StoppedError

if TYPE_CHECKING:
    from layflat.identify.fit import Fit
    from layflat.identify.identification import Identification

NOT_TRUSTED = 3  # exit status of a fit that hit a bound, did not converge, or does not predict


@app.command()
def excite(
    machine: MachineName,
    reach: Annotated[float, typer.Option(help="largest angle from the middle, share of the working stroke")] = 0.3,
    speed: Annotated[str, typer.Option(help="greatest rate of the demand")] = "300 deg/s",
    seed: Annotated[int, typer.Option(min=0, help="of sizes and order")] = 0,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="[NAME]-excite.csv")] = None,
) -> None:
    """Write a bench sequence from which a machine can be identified: demands for its controller."""
    from layflat.description import units as u  # noqa: PLC0415
    from layflat.files import check_file  # noqa: PLC0415
    from layflat.identify.excite import sequence  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.motion.demand_file import write_demand  # noqa: PLC0415

    described = load(machine)
    place = check_file(out or Path(f"{described.name}-excite.csv"))
    with naming_options({"reach": "--reach", "speed": "--speed"}):
        time, demand = sequence(described, reach=reach, speed=u.quantity(speed, u.ANGULAR_SPEED, "--speed"), seed=seed)
    path = write_demand(described, time, demand, place)
    typer.echo(f"wrote {path}: {time[-1]:.0f} s of steps, chirps, slow ramps, small moves and pauses")
    typer.echo(f"simulate it with `layflat simulate {machine} --demand {path}`; start with the joints at rest")


@app.command()
def identify(
    logs: Annotated[list[Path], typer.Argument(metavar="LOG...", help="CSV, Parquet, NetCDF or MCAP")],
    machine: Annotated[str, typer.Option(metavar="NAME|FILE", help="machine or test bench to begin with")],
    fit: Annotated[
        str | None, typer.Option(metavar="A,B", help="blocks, such as valve,hose; default: those of the bench")
    ] = None,
    validate: Annotated[
        list[Path] | None,
        typer.Option(metavar="LOG", help="validate with this log instead of the last third; repeatable"),
    ] = None,
    mapping: Annotated[
        Path | None, typer.Option(metavar="FILE", help="what the logs' columns are; not needed for our own names")
    ] = None,
    starts: Annotated[int, typer.Option(min=0, help="of the search, besides the description's own values")] = 32,
    seed: Annotated[int, typer.Option(min=0, help="of starts and intervals")] = 0,
    out: Out = Path("build/identify"),
) -> None:
    """Find the parameters that explain bench logs: a fitted description, and a page with what it is worth.

    Exit status 3 if a parameter hit its bound or the search did not converge: the file says so too. Ctrl-C ends the
    search: the best values so far are written and marked as partial.
    """
    from layflat.identify.identification import begin  # noqa: PLC0415
    from layflat.identify.report_text import write_page  # noqa: PLC0415

    with busy("reading"):
        session = begin(logs, machine, out, blocks=fit, validate=validate or [], mapping=mapping)
    with bar("compiling (for some seconds, the first time only)", 1.0, "TimeElapsedColumn") as update:
        found = session.fit(
            starts=starts, seed=seed, progress=lambda share, text: update(completed=share, description=text)
        )
    reports: list[str | None] = []
    # Each of these is done even if one before it fails: a long search is not lost.
    with ExitStack() as last:
        last.callback(lambda: typer.echo(f"wrote {write_page(session, found, session.path.with_suffix('.html'))}"))
        last.callback(lambda: typer.echo(f"wrote {_write_description(session, found)}"))
        last.callback(lambda: reports.append(_print(session, found)))
        last.callback(lambda: session.keep_figures(found))
    if found.partial:
        raise StoppedError(f"{found.simulations} simulated runs of the search", session.path)
    why = reports[0]
    if why:
        typer.echo(f"layflat: not to be trusted: {why}; the file says so", err=True)
        raise typer.Exit(NOT_TRUSTED)


def _write_description(session: "Identification", found: "Fit") -> Path:
    """Write the description that was found; raise InputError that names the figures where it can't hold them."""
    try:
        session.keep_description(found)
    except InputError as error:
        what = f"what was found is no description ({error})"
        raise InputError(what, where=str(session.path), right=f"all figures are in {session.figures_path}") from None
    return session.path


def _print(session: "Identification", found: "Fit") -> str | None:
    """Print all that the page says, and return why it is not to be trusted."""
    from layflat.identify import report_text as told  # noqa: PLC0415

    values = session.values(found)
    for title, columns, rows in (told.issue_section(session.issues), *told.sections(found, values)):
        if rows:
            print_table(columns, rows, title)
            typer.echo()
    for remark in found.remarks:
        typer.echo(remark)
    typer.echo(" ".join(filter(None, (told.expected(found), told.prediction(found), told.count_identified(values)))))
    return told.untrusted(found, values)
