"""The command that reproduces the paper."""

from pathlib import Path
from textwrap import fill
from typing import Annotated

import typer

from layflat.cli.app import WIDTH, Out, app, print_table
from layflat.cli.bars import steps_bar
from layflat.errors import StoppedError


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
    """Reproduce the paper: its experiments and claims.

    Performs the experiments, evaluates the claims, writes report.html and claims.json.

    Claims that need what the machine lacks are listed as not evaluated, with the reason. Ctrl-C ends it; what was
    evaluated until then is kept. The report shows the open questions whose studies are done below the folder.
    """
    from layflat.experiments import bench, reproduce, write_claims, write_report  # noqa: PLC0415
    from layflat.experiments.questions import QUESTIONS, answers, ask  # noqa: PLC0415
    from layflat.experiments.report import COLUMNS, table  # noqa: PLC0415
    from layflat.experiments.reproduction import ORDER  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine.listing import listing  # noqa: PLC0415
    from layflat.machine.loader import tables  # noqa: PLC0415

    on = bench(machine)
    check_folder(out)
    for number, name in enumerate(QUESTIONS if questions else (), 1):
        with steps_bar(f"question {number} of {len(QUESTIONS)}, {name}") as advance:
            ask(name, out / "questions" / name, advance)
    with steps_bar("claims", len(ORDER)) as advance:
        found = reproduce(on, advance)
    write_claims(found, out / "claims.json")
    every = listing(*tables(machine))
    assumed = [line for line in every if line.source in {"assumed", "calibrated", "identified", "given"}]
    answered = answers(out / "questions")
    report = write_report(found, assumed, out / "report.html", answered)
    print_table(list(COLUMNS), table(found.claims))
    typer.echo(f"{found.summary}; wrote {report}")
    for one in answered:
        typer.echo(f"\n{one.title}\n{fill(one.finding, WIDTH)}")
    if found.stopped:
        raise StoppedError(f"{len(found.evaluated)} of {len(ORDER)} claims", out)
    return 0 if found.agrees else 1
