"""The command that tunes controllers."""

from pathlib import Path
from textwrap import fill
from typing import Annotated

import typer

from layflat.cli.app import WIDTH, Device, MachineName, Out, app, print_table
from layflat.cli.bars import steps_bar
from layflat.errors import StoppedError


@app.command()
def tune(
    machine: MachineName,
    method: Annotated[
        str,
        typer.Option(
            metavar="global|phases", help="all at once, or as the paper its gains: joint by joint, phase by phase"
        ),
    ] = "global",
    start: Annotated[str, typer.Option("--from", metavar="neutral|current", help="values to begin with")] = "neutral",
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
    """Tune a controller: gains of the paper's, settings of the tracking one; needs the extra `tune`.

    Writes a description with the values found, and a page with what they do.

    What counts is how soon moves settle, on plants that differ, the worst of them and the nominal ones most. The
    paper's gains meet other payloads, supplies, losses and drifts; the tracking controller meets plants that are not
    what it believes. Ctrl-C ends the search; the best so far is kept.
    """
    from layflat.tune import begin  # noqa: PLC0415
    from layflat.tune.robust import fresh, validate, warnings  # noqa: PLC0415
    from layflat.tune.tuning import PAGE  # noqa: PLC0415

    tuning = begin(
        machine, out, method=method, start=start, seed=seed, generations=generations, over=over, device=device
    )
    from layflat.tune.page import figures_of, write_page  # noqa: PLC0415  # figures; what is asked was checked before

    with steps_bar("generations", tuning.generations) as advance:
        tuning.seek(
            lambda best, done, name: advance(done, now=f"{name or 'first values'}: best cost {best.cost:.2f} s")
        )
    tuned = tuning.keep()
    done = f"{len(tuning.history) - 1} of {tuning.generations} generations in {tuning.seconds:.1f} s"
    typer.echo(f"{done}\nwrote {tuning.path}")
    before = validate(tuning.base, tuning.meet) if tuning.was_complete else None
    after, measure = validate(tuned, tuning.meet), fresh(tuning.meet).measure
    columns = [f"settling within {measure.within}, coupling", "before", "after"]
    print_table(columns, figures_of(tuning, before, after), tuned.name)
    for line in (*warnings(before, after), measure.statement):
        typer.echo(fill(line, WIDTH))
    if tuning.kept:
        typer.echo(f"no better {tuning.law.values} were found: those that were there stay")
    typer.echo(f"wrote {write_page(tuning, tuned, before, after, out / PAGE)}")
    if tuning.stopped:
        raise StoppedError(done, out)
