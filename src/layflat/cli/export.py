"""Command that exports a machine's laws to C, microcontrollers, simulators of others and browsers."""

from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.bars import in_background
from layflat.cli.common import MachineName, naming_options
from layflat.cli.completers import complete_choice, complete_target
from layflat.cli.groups import app


@app.register(
    "export", "paper-arm --target c --out paper-arm-c", "paper-arm --target cortex-m4f --precision single --out m4f"
)
def export_laws(
    machine: MachineName,
    target: Annotated[
        str,
        typer.Option(
            metavar="TARGET", help="such as c, c-source, fmu (docs/export.md)", autocompletion=complete_target
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="folder for the results, new or empty")],
    precision: Annotated[
        str,
        typer.Option(metavar="double|single", help="of numbers", autocompletion=complete_choice("double", "single")),
    ] = "double",
) -> None:
    """Export a machine's laws to C and other targets.

    Writes machine code or source, a header, the machine's parameters, an example that compiles as it is, and a README.
    """
    from layflat.export import export  # noqa: PLC0415

    with naming_options({"target": "--target", "out": "--out", "precision": "--precision"}):
        written = export(
            machine, target, out, precision=precision,
            wait_for=lambda work: in_background(work, "exporting", note="(it is compiled)"),
        )  # fmt: skip
    typer.echo(f"wrote {len(written)} files to {out}")
