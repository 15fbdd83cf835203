"""The process that serves the page of a run."""

from multiprocessing.connection import Connection

from layflat.errors import InputError
from layflat.pages.cell.snapshot import About, Requests
from layflat.pages.server.place import Place
from layflat.pages.server.serve import serve


def serve_run(about: About, place: Place, pipe: Connection, asked: Requests) -> None:
    """Serve until the other side of the pipe is gone; its first message is the start link, or what is wrong."""
    from layflat.pages.cell.desk import Desk  # noqa: PLC0415  # they need the extra
    from layflat.pages.cell.page import run_page  # noqa: PLC0415

    desk = Desk(about, asked)
    try:
        serve(
            lambda: run_page(desk),
            place,
            title=f"layflat: {about.cell}",
            started=lambda: desk.follow(pipe),
            ready=lambda link: pipe.send(("ready", link)),
            stopped=lambda: desk.over,
        )
    except InputError as error:
        pipe.send(("failed", (error.what, error.where, error.right)))
