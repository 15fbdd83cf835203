"""Command that designs in the browser: studio."""

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from layflat import extras
from layflat.cli.app import app, naming_options
from layflat.cli.panel import Browser, Certificate, CertificateKey, Host, PagePort
from layflat.cli.rig import stopping

Opened = Annotated[str, typer.Argument(metavar="NAME|FILE", help="built-in machine or description file")]


@app.command()
def studio(
    machine: Opened = "paper-arm",
    port: PagePort = 8080,
    host: Host = "127.0.0.1",
    certificate: Certificate = None,
    key: CertificateKey = None,
    browser: Browser = True,
) -> None:
    """Design in the browser: change a value, and see torque, strap and step response at once; needs the extra `panel`.

    Saves in the current folder and below it, under names that the page asks for. Each tab edits a design of its own.
    """
    from layflat.machine import load  # noqa: PLC0415
    from layflat.pages.server.place import Place  # noqa: PLC0415
    from layflat.pages.server.serve import serve  # noqa: PLC0415

    extras.require("panel", "nicegui", where="studio")
    described = load(machine)

    def ready(link: str) -> None:
        typer.echo(f"{described.name} at {link}; Ctrl-C ends it")
        if browser and not webbrowser.open(link):
            typer.echo("no browser was found: open the link in one")

    with naming_options({"host": "--host", "port": "--port", "certificate": "--certificate", "key": "--key"}):
        place = Place(host, port, certificate, key)
        from layflat.pages.studio.page import shared_worker, studio_page  # noqa: PLC0415  # it needs the extra

        worker, folder = shared_worker(), Path.cwd()
        with stopping() as stopped:
            serve(
                lambda: studio_page(machine, folder), place, title=f"layflat: {described.name}", ready=ready,
                stopped=stopped, started=worker.begin, ended=worker.end,
            )  # fmt: skip
