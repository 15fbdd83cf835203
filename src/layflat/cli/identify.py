"""Commands that identify machines and benches."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import bar, busy
from layflat.cli.common import MachineName, Out, naming_options, print_table
from layflat.cli.completers import complete_name
from layflat.cli.groups import app
from layflat.errors import InputError, StoppedError

if TYPE_CHECKING:
    from layflat.identify.fit import Fit
    from layflat.identify.identification import Identification

NOT_TRUSTED = 3  # exit status of a fit that hit a bound, did not converge, or does not predict


@app.register("excite", "paper-arm", "paper-arm --reach 0.2 --out excite.csv")
def write_excitation(
    machine: MachineName,
    reach: Annotated[float, typer.Option(help="largest angle from the middle, share of the working stroke")] = 0.3,
    speed: Annotated[str, typer.Option(help="greatest rate of the demand")] = "300 deg/s",
    seed: Annotated[int, typer.Option(min=0, help="of sizes and order")] = 0,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="[NAME]-excite.csv")] = None,
) -> None:
    """Write demands from which a machine can be identified."""
    from layflat.description import units as u  # noqa: PLC0415
    from layflat.files import check_file  # noqa: PLC0415
    from layflat.identify.excite import plan_sequence  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.motion.demand_file import write_demand  # noqa: PLC0415

    described = load(machine)
    place = check_file(out or Path(f"{described.name}-excite.csv"))
    with naming_options({"reach": "--reach", "speed": "--speed"}):
        time, demand = plan_sequence(
            described, reach=reach, speed=u.quantity(speed, u.ANGULAR_SPEED, "--speed"), seed=seed
        )
    path = write_demand(described, time, demand, place)
    typer.echo(f"wrote {path}: {time[-1]:.0f} s of steps, chirps, slow ramps, small moves and pauses")
    typer.echo(f"simulate it with `layflat simulate {machine} --demand {path}`; start with the joints at rest")


@app.register("identify", "log.csv --machine paper-arm", "log.csv --machine mine.toml --fit valve,hose")
def identify_machine(
    logs: Annotated[list[Path], typer.Argument(metavar="LOG...", help="CSV, Parquet, NetCDF or MCAP")],
    machine: Annotated[
        str,
        typer.Option(
            metavar="NAME|FILE",
            help="machine or test bench to begin with",
            autocompletion=complete_name("machine", "bench"),
        ),
    ],
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
    """Identify the parameters that explain bench logs.

    Writes a fitted description, and a page on how far it is to be trusted. Exit status 3 if a parameter hit its bound
    or the search did not converge: the file says so too. Ctrl-C ends the search: the best values so far are written
    and marked as partial.
    """
    from layflat.identify.identification import prepare_identification  # noqa: PLC0415
    from layflat.identify.report_text import write_page  # noqa: PLC0415

    with naming_options({"blocks": "--fit", "joints": "--machine"}):
        with busy("reading"):
            session = prepare_identification(logs, machine, out, blocks=fit, validate=validate or [], mapping=mapping)
        with bar("compiling (for some seconds, the first time only)", 1.0, "TimeElapsedColumn") as update:
            result = session.fit(
                starts=starts, seed=seed, progress=lambda share, text: update(completed=share, description=text)
            )
    reports: list[str | None] = []
    # Each of these is done even if one before it fails: a long search is not lost.
    with ExitStack() as last:
        last.callback(lambda: typer.echo(f"wrote {write_page(session, result, session.path.with_suffix('.html'))}"))
        last.callback(lambda: typer.echo(f"wrote {_write_description(session, result)}"))
        last.callback(lambda: reports.append(_print_fit(session, result)))
        last.callback(lambda: session.write_figures(result))
    if result.partial:
        raise StoppedError(f"{result.simulations} simulated runs of the search", session.path)
    why = reports[0]
    if why:
        typer.echo(f"layflat: not to be trusted: {why}; the file says so", err=True)
        raise typer.Exit(NOT_TRUSTED)


def _write_description(session: "Identification", fit: "Fit") -> Path:
    """Write the fitted description and return its path.

    Raise InputError, with the path of the figures, if the values make no valid description.
    """
    try:
        session.write_description(fit)
    except InputError as error:
        what = f"the fitted values make no valid description ({error})"
        raise InputError(what, where=str(session.path), right=f"all figures are in {session.figures_path}") from None
    return session.path


def _print_fit(session: "Identification", fit: "Fit") -> str | None:
    """Print the content of the page, and return the reason not to trust the fit; None if there is none."""
    from layflat.identify import report_text as texts  # noqa: PLC0415

    values = session.values(fit)
    for title, columns, rows in (texts.issue_table(session.issues), *texts.report_tables(fit, values)):
        if rows:
            print_table(columns, rows, title)
            typer.echo()
    for remark in fit.remarks:
        typer.echo(remark)
    typer.echo(
        " ".join(
            filter(
                None,
                (texts.describe_expected_errors(fit), texts.describe_prediction(fit), texts.count_identified(values)),
            )
        )
    )
    return texts.distrust_reason(fit, values)
