"""The command that compares controllers: beyond."""

from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.app import Out, app, print_table
from layflat.cli.bars import steps_bar


@app.command()
def beyond(
    machine: Annotated[str, typer.Argument(metavar="[NAME|FILE]", help="the arm")] = "paper-arm-fast",
    quick: Annotated[bool, typer.Option("--quick", help="with an eighth of the runs")] = False,
    out: Out = Path("build/beyond"),
) -> None:
    """Compare a machine's own controller with the tracking law, and with what is best.

    Steps, belts, unknown payloads and plants that differ from what the controllers believe; the law without each of its
    parts; rest, stiffness, and openings found offline as a bound. Writes beyond.html and beyond.json.
    """
    from layflat.experiments.beyond.comparison import QUICK, Effort, comparison  # noqa: PLC0415
    from layflat.experiments.beyond.report import COLUMNS, numbers, rows, write_numbers, write_page  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415

    found = comparison(machine, QUICK if quick else Effort())
    check_folder(out, "beyond.html", "beyond.json", costly=True)
    stages = found.stages()
    with steps_bar("comparing", len(stages)) as advance:
        for done, (what, work) in enumerate(stages):
            advance(done, now=what)
            work()
    page, told = write_page(found, out / "beyond.html"), write_numbers(found, out / "beyond.json")
    print_table(list(COLUMNS), rows(found.settling), f"{found.machine.name}: steps of 40 deg, tip within 2 mm for good")
    others = [[name, "-" if value is None else f"{value:.4g}"] for name, value in numbers(found).items()]
    print_table(["name in beyond.json", "value"], others)
    typer.echo(f"wrote {page}\nwrote {told}")
