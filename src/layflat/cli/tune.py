"""Command that tunes controllers."""

from pathlib import Path
from textwrap import fill
from typing import Annotated

import typer

from layflat.cli.bars import steps_bar
from layflat.cli.common import WIDTH, Device, MachineName, Out, naming_options, print_table
from layflat.cli.completers import complete_choice
from layflat.cli.groups import app
from layflat.errors import StoppedError


@app.register("tune", "paper-arm", "mine.toml --from current --generations 20")
def tune_controller(
    machine: MachineName,
    method: Annotated[
        str,
        typer.Option(
            metavar="global|phases",
            help="all at once, or as the paper its gains: joint by joint, phase by phase",
            autocompletion=complete_choice("global", "phases"),
        ),
    ] = "global",
    start: Annotated[
        str,
        typer.Option(
            "--from",
            metavar="neutral|current",
            help="values to begin with",
            autocompletion=complete_choice("neutral", "current"),
        ),
    ] = "neutral",
    generations: Annotated[
        int | None, typer.Option(help="of the search, in all; default: as many as the method needs")
    ] = None,
    over: Annotated[
        str, typer.Option(metavar="cloud", help="conditions with every machine that the paper allows, not one alone")
    ] = "",
    seed: Annotated[int, typer.Option(help="of the search; the same seed finds the same")] = 1,
    device: Device = "cpu",
    out: Out = Path("build/tune"),
) -> None:
    """Tune the gains or settings of a controller.

    Needs the extra `tune`. Writes a description with the values found, and a page with what they do.

    What counts is how soon moves settle, on plants that differ, the worst of them and the nominal ones most. The
    paper's gains meet other payloads, supplies, losses and drifts; the tracking controller meets plants that are not
    what it believes. Ctrl-C ends the search; the best so far is kept.
    """
    from layflat.tune import REPORT_FILE, begin_tuning, finish_tuning  # noqa: PLC0415
    from layflat.tune.robust import coupling_warnings, validation_conditions  # noqa: PLC0415

    options = {name: f"--{name}" for name in ("method", "generations", "seed", "over", "device")}
    with naming_options(options | {"start": "--from"}):
        tuning = begin_tuning(
            machine, out, method=method, start=start, seed=seed, generations=generations, over=over, device=device
        )
    from layflat.tune.page import write_page  # noqa: PLC0415  # figures; what is asked was checked before

    with steps_bar("generations", tuning.generations) as advance:
        tuning.search(
            lambda best, done, name: advance(done, now=f"{name or 'first values'}: best cost {best.cost:.2f} s")
        )
    result = finish_tuning(tuning)
    done = f"{len(tuning.history) - 1} of {tuning.generations} generations in {tuning.seconds:.1f} s"
    typer.echo(f"{done}\nwrote {tuning.path}")
    print_table(result.columns, result.comparison_rows(), result.machine.name)
    statement = validation_conditions(tuning.make_conditions).measure.statement
    for line in (*coupling_warnings(result.before, result.after), statement):
        typer.echo(fill(line, WIDTH))
    if tuning.unchanged:
        typer.echo(f"no better {tuning.law.values} were found: those that were there stay")
    typer.echo(f"wrote {write_page(result, out / REPORT_FILE)}")
    if tuning.stopped:
        raise StoppedError(done, out)
