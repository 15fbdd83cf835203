"""Serve a small page in a process of its own, until its input ends or it gets SIGTERM; print the start link first.

Arguments: the port, and files of a certificate and its key where there are any.
"""

import signal
import sys
from collections.abc import Callable
from pathlib import Path
from threading import Event, Thread

from layflat.pages.server import Endpoint, serve


def root() -> None:
    from nicegui import ui

    said = ui.label("nothing yet")
    ui.button("Greet", on_click=lambda: said.set_text("hello from Python"))


def add_route_that_reads() -> None:
    from fastapi import Request
    from nicegui import app

    @app.post("/body")
    async def body(request: Request) -> int:
        return len(await request.body())


def say(words: str) -> None:
    print(words, flush=True)  # noqa: T201


def main(root: Callable[[], None]) -> None:
    stop = Event()

    def wait() -> None:
        sys.stdin.read()
        stop.set()

    Thread(target=wait, daemon=True).start()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    port, *files = sys.argv[1:]
    certificate, key = (Path(file) for file in files) if files else (None, None)
    serve(
        root,
        Endpoint(port=int(port), certificate=certificate, key=key),
        title="A page for tests",
        started=add_route_that_reads,
        ready=say,
        stopped=stop.is_set,
        ended=lambda: say("ended"),
    )


if __name__ == "__main__":
    main(root)
