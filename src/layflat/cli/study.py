"""Commands that list, show and run parameter studies."""

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import steps_bar
from layflat.cli.common import WIDTH, Device, count_noun, naming_options, print_table
from layflat.cli.completers import complete_name
from layflat.cli.groups import studies

if TYPE_CHECKING:
    from layflat.study import Study


@studies.register("list", "")
def list_studies() -> None:
    """List the built-in studies."""
    from layflat.study import read_study, study_names  # noqa: PLC0415

    described = [read_study(one) for one in study_names()]
    print_table(["study", "runs", "what it asks"], [[s.name, str(s.rows), s.file.title] for s in described])


@studies.register("show", "valves > study.toml")
def show_study(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="built-in study", autocompletion=complete_name("study", files=False))
    ],
) -> None:
    """Print the file of a study, to start from."""
    from layflat.study.study import STUDY_LIBRARY  # noqa: PLC0415

    typer.echo(STUDY_LIBRARY.text(name), nl=False)


@studies.register("run", "valves", "study.toml --out build/mine")
def run_parameter_study(
    file: Annotated[
        str,
        typer.Argument(
            metavar="NAME|FILE", help="built-in study, or what to vary, in TOML", autocompletion=complete_name("study")
        ),
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="for the results; default: build/study/NAME")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="of a Dask cluster that does the work")
    ] = None,
    device: Device = "cpu",
) -> None:
    """Run a parameter study.

    Needs the extra `study`. Writes a table of metrics, a row a run, and a figure. A stopped study continues where it
    was. Runs of up to a minute are computed in single precision, unless the file says precision = "double".
    """
    from layflat.study import read_study, run_study, study_names, study_table  # noqa: PLC0415
    from layflat.study.folder import ChangedError  # noqa: PLC0415
    from layflat.study.results import draw_study, write_figure  # noqa: PLC0415

    described = read_study(file)
    place = out or Path("build/study") / described.name
    try:
        with naming_options({"scheduler": "--scheduler", "device": "--device"}), steps_bar("runs") as advance:
            path = run_study(described, place, scheduler=scheduler, device=device, progress=advance)
    except ChangedError as error:
        typer.echo(f"layflat: {error}, or --force to replace it", err=True)
        for line in error.differences:
            typer.echo(f"  {line}", err=True)
        raise typer.Exit(2) from None
    _print_summary(described, place)
    typer.echo(f"wrote {path} and .csv")
    if file not in study_names():
        typer.echo(f"wrote {write_figure(draw_study(described, study_table(place)), place)} and .png")
        return
    from layflat.experiments.questions import answer_question  # noqa: PLC0415  # one of the paper's open questions

    answered = answer_question(file, place)
    typer.echo(f"wrote {place / 'figure.svg'} and .png\n\n{fill(answered.finding, WIDTH)}")


def _print_summary(described: "Study", out: Path) -> None:
    """Print the quantiles of a study's metrics, and how many runs settled and diverged."""
    from layflat.study.results import SUMMARY_LEVELS, summarize_study  # noqa: PLC0415

    result = summarize_study(out, described.metrics)
    rows = [
        [name, unit, *(f"{value:.4g}" if abs(value) != float("inf") else "not settled" for value in values)]
        for name, (unit, values) in result.quantiles.items()
    ]
    columns = ["metric", "unit", *(f"{100 * share:g} %" for share in SUMMARY_LEVELS)]
    runs = f"{count_noun(result.runs, 'run')} in {described.precision} precision"
    title = f"{described.name}: {count_noun(described.samples, 'sample')}, {runs}; this share of them lies below"
    print_table(columns, rows, title)
    if result.settled is not None:
        typer.echo(f"{100 * result.settled:.1f} % settled in every move")
    if described.prices is not None:
        from layflat.cli.build import report_unpriced  # noqa: PLC0415  # of few studies
        from layflat.solids.cost import cost_of  # noqa: PLC0415
        from layflat.solids.totals import list_built_parts  # noqa: PLC0415

        for variant in described.variants:
            report_unpriced(cost_of(list_built_parts(variant.machine), described.prices))
    typer.echo(f"{result.diverged} of {count_noun(result.runs, 'run')} diverged")
