"""Command that designs in the browser: studio."""

from pathlib import Path
from typing import Annotated

import typer

from layflat import extras
from layflat.cli.app import app, expanded
from layflat.cli.pages import PageOptions
from layflat.cli.rig import stopping

Opened = Annotated[str, typer.Argument(metavar="NAME|FILE", help="built-in machine or description file")]


@app.command()
@expanded
def studio(page: PageOptions, machine: Opened = "paper-arm") -> None:
    """Design in the browser: change a value, and see torque, strap and step response at once; needs the extra `panel`.

    Saves in the current folder and below it, under names that the page asks for. Each tab edits a design of its own.
    """
    from layflat.machine import load  # noqa: PLC0415

    extras.require("panel", "nicegui", where="studio")
    described, place = load(machine), page.place()
    from layflat.pages.studio.page import shared_worker, studio_page  # noqa: PLC0415  # it needs the extra

    worker, folder = shared_worker(), Path.cwd()
    with stopping() as stopped:
        page.serve(
            lambda: studio_page(machine, folder), place, described, stopped, started=worker.begin, ended=worker.end
        )
