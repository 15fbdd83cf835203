"""The command that tunes controllers."""

from pathlib import Path
from textwrap import fill
from typing import Annotated

import typer

from layflat.cli.app import WIDTH, MachineName, Out, app, print_table
from layflat.cli.bars import steps_bar
from layflat.errors import StoppedError


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
        int | None, typer.Option(help="of the search, in all; default: as many as the method needs")
    ] = None,
    over: Annotated[
        str, typer.Option(metavar="cloud", help="conditions with every machine that the paper allows, not one alone")
    ] = "",
    seed: Annotated[int, typer.Option(help="of the search; the same seed finds the same gains")] = 1,
    out: Out = Path("build/tune"),
) -> None:
    """Find a controller's gains; needs the extra `tune`.

    Writes a description with the gains, and a page with what they do.

    What counts is how soon moves settle, over payloads, supplies, losses and drifts that differ, the worst of them and
    the nominal ones most. Ctrl-C ends the search; the best gains so far are kept.
    """
    from layflat.tune import begin  # noqa: PLC0415
    from layflat.tune.conditions import STATEMENT  # noqa: PLC0415
    from layflat.tune.validation import validate, warnings  # noqa: PLC0415

    tuning = begin(machine, out, method=method, start=start, seed=seed, generations=generations, over=over)
    from layflat.tune.page import figures_of, write_page  # noqa: PLC0415  # figures; what is asked was checked before

    with steps_bar("generations", tuning.generations) as advance:
        tuning.seek(lambda best, done, name: advance(done, now=f"{name or 'first gains'}: best cost {best.cost:.2f} s"))
    tuned = tuning.keep()
    done = f"{len(tuning.history) - 1} of {tuning.generations} generations in {tuning.seconds:.1f} s"
    typer.echo(f"{done}\nwrote {tuning.path}")
    before = validate(tuning.base, tuning.spread) if tuning.has_gains else None
    after = validate(tuned, tuning.spread)
    columns = ["settling within 0.3 deg, coupling", "before", "after"]
    print_table(columns, figures_of(tuning.machine, before, after), tuned.name)
    for line in (*warnings(before, after), STATEMENT):
        typer.echo(fill(line, WIDTH))
    if tuning.kept:
        typer.echo("no better gains were found: those that were there stay")
    typer.echo(f"wrote {write_page(tuning, tuned, before, after, out / 'tuning.html')}")
    if tuning.stopped:
        raise StoppedError(done, out)
