"""The command that reproduces the paper."""

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.app import WIDTH, Out, app, print_table
from layflat.cli.bars import steps_bar
from layflat.errors import StoppedError

if TYPE_CHECKING:
    from layflat.experiments import Reproduction


@app.command()
def reproduce(
    machine: Annotated[
        str, typer.Option("--machine", "-m", metavar="NAME|FILE", help="the arm under test")
    ] = "paper-arm",
    out: Out = Path("build/reproduce"),
    cloud: Annotated[
        bool, typer.Option("--cloud", help="with every member of the machine's cloud, too: tells spreads (minutes)")
    ] = False,
    questions: Annotated[
        bool, typer.Option("--questions", help="run the studies of the paper's open questions, too (minutes)")
    ] = False,
) -> int:
    """Reproduce the paper: its experiments and claims.

    Performs the experiments, evaluates the claims, writes report.html and claims.json.

    With --cloud it does so with every machine that the paper allows, and writes cloud.json: what each number spreads
    over.

    Claims that need what the machine lacks are listed as not evaluated, with the reason. Ctrl-C ends it; what was
    evaluated until then is kept. The report shows the open questions whose studies are done below the folder.
    """
    from layflat.parallel import aside  # noqa: PLC0415

    with aside("layflat.experiments.report:perform", machine) as others:  # before the imports, which take as long there
        from layflat.experiments import bench, reproduce, write_claims, write_report  # noqa: PLC0415
        from layflat.experiments.questions import QUESTIONS, answers, ask  # noqa: PLC0415
        from layflat.experiments.report import COLUMNS, figures, table  # noqa: PLC0415
        from layflat.experiments.reproduction import ORDER  # noqa: PLC0415
        from layflat.files import check_folder  # noqa: PLC0415
        from layflat.machine.listing import listing  # noqa: PLC0415
        from layflat.machine.loader import tables  # noqa: PLC0415

        on = bench(machine)
        check_folder(out, "claims.json", "report.html", *(["cloud.json"] if cloud else []), costly=True)
        for number, name in enumerate(QUESTIONS if questions else (), 1):
            with steps_bar(f"question {number} of {len(QUESTIONS)}, {name}") as advance:
                ask(name, out / "questions" / name, advance)
        with steps_bar("claims", len(ORDER)) as advance:
            found = reproduce(on, advance, others, figures)
    write_claims(found, out / "claims.json")
    every = listing(*tables(machine))
    assumed = [line for line in every if line.source in {"assumed", "calibrated", "identified", "given"}]
    answered = answers(out / "questions")
    report = write_report(found, assumed, out / "report.html", answered)
    print_table(list(COLUMNS), table(found.claims))
    typer.echo(f"{found.summary}; wrote {report}")
    for one in answered:
        typer.echo(f"\n{one.title}\n{fill(one.finding, WIDTH)}")
    if cloud and not found.stopped:
        _over_cloud(machine, found, out)
    if found.stopped:
        raise StoppedError(f"{len(found.evaluated)} of {len(ORDER)} claims", out)
    return 0 if found.agrees else 1


def _over_cloud(machine: str, found: "Reproduction", out: Path) -> None:
    """Repeat the experiments with every member of a cloud, and show what each number spreads over."""
    from layflat.experiments.spread import over, spread_table, spreads, write_spreads  # noqa: PLC0415
    from layflat.machine.exchanged import members  # noqa: PLC0415

    names, claims = members(machine), []
    try:
        with steps_bar("members of the cloud", len(names)) as advance:
            for one in over(names):
                claims.append(one)
                advance(len(claims))
    except KeyboardInterrupt:
        if not claims:
            raise StoppedError(f"0 of {len(names)} members", out) from None
    told = spreads(claims)
    print_table(
        ["claim", "quantity", "simulated", "5 to 95 % of the cloud", "unit", "agree"], spread_table(found, told)
    )
    typer.echo(f"{len(claims)} of {len(names)} members; wrote {write_spreads(told, len(claims), out / 'cloud.json')}")
    if len(claims) < len(names):
        raise StoppedError(f"{len(claims)} of {len(names)} members", out)
