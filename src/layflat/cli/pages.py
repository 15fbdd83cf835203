"""What commands that serve a page share: where it is served, and the link that is printed and opened."""

import webbrowser
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.cli.app import naming_options

if TYPE_CHECKING:
    from layflat.machine import Machine
    from layflat.pages.server.place import Place

OPTIONS = {name: f"--{name}" for name in ("host", "port", "certificate", "key")}


@dataclass(frozen=True)
class PageOptions:
    """Options about the page of a command (see `expanded`)."""

    port: Annotated[int, typer.Option(min=0, max=65535, help="of the page; 0 is any that is free")] = 8080
    host: Annotated[str, typer.Option(help="address by which browsers reach this computer")] = "127.0.0.1"
    certificate: Annotated[
        Path | None, typer.Option(metavar="FILE", help="PEM, for other addresses than this computer's")
    ] = None
    key: Annotated[Path | None, typer.Option(metavar="FILE", help="of the certificate, PEM")] = None
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="open the page")] = True

    @property
    def given(self) -> str:
        """The first option that is not at its default; empty where all are."""
        others = (one.name for one in fields(self) if getattr(self, one.name) != one.default)
        return next((OPTIONS.get(name, "--no-browser") for name in others), "")

    def place(self) -> "Place":
        """Return where the page is served; raise InputError naming the option if it can't be."""
        from layflat.pages.server.place import Place  # noqa: PLC0415

        with naming_options(OPTIONS):
            return Place(self.host, self.port, self.certificate, self.key)

    def serve(
        self, root: Callable[[], object], place: "Place", machine: "Machine", stopped: Callable[[], bool], **more: Any
    ) -> None:
        """Serve the page of a machine, say where, and open it; see `layflat.pages.server.serve`."""
        from layflat.pages.server.serve import serve  # noqa: PLC0415

        def ready(link: str) -> None:
            self.tell(machine.name, link)

        with naming_options(OPTIONS):
            serve(root, place, title=f"layflat: {machine.name}", ready=ready, stopped=stopped, **more)

    def tell(self, name: str, link: str) -> None:
        """Say where the page of something is, and open it."""
        print_link(name, link)
        if self.browser and not webbrowser.open(link):
            typer.echo("no browser was found: open the link in one")


def print_link(name: str, link: str) -> None:
    """Print the link of something's page, alone on its line: who copies the line has the link and nothing else."""
    typer.echo(f"{name} is at the link below; Ctrl-C ends it")
    typer.echo(link)
