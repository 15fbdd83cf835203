"""Command that writes an arm for other tools: arm-model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.app import MachineName, app
from layflat.errors import InputError


@app.command()
def arm_model(
    machine: MachineName,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="ends in .xml (MJCF) or .urdf")],
) -> None:
    """Write a machine's arm for other tools: MJCF (MuJoCo) or URDF."""
    from layflat.bridge import to_mjcf, to_urdf  # noqa: PLC0415
    from layflat.files import whole_file  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415

    writers = {".xml": to_mjcf, ".urdf": to_urdf}
    if out.suffix not in writers:
        raise InputError(
            f"{out.name!r} has an unknown format", where="--out", right="give a name such as arm.xml or arm.urdf"
        )
    text = writers[out.suffix](load(machine))
    with whole_file(out) as temporary:
        temporary.write_text(text, encoding="utf-8")
    typer.echo(f"wrote {out}")
