"""Pages of NiceGUI, served until it is to end."""

import asyncio
import gc
import logging
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING

from layflat import extras
from layflat.pages.server.guard import LARGEST, Guard
from layflat.pages.server.logs import log_in_lines
from layflat.pages.server.place import Place
from layflat.pages.server.turns import Turn, TurnMonitor

if TYPE_CHECKING:
    from fastapi import FastAPI
    from uvicorn import Server

LOG = logging.getLogger(__name__)
TIDY = 60.0  # between two collections of all garbage, at least, s
SPARING = 2000, 10, 1_000_000  # thresholds of the collector of garbage: it never looks through everything by itself
POLL = 0.05  # s
GRACE = 1  # s, that connections have to end
RECONNECT = 3.0  # s, that a browser has to come back to the page it had
HEAD = 2**16  # bytes of a request's head; all cookies of this computer are in it

CANNOT = (  # in place of what NiceGUI has to say
    "<style>body > #esm-fallback { display: none }</style>"
    '<p role="alert" style="font: 1.1rem/1.5 sans-serif; max-width: 36rem; margin: 15vh auto; padding: 0 1rem">%s</p>'
)
NO_SCRIPTS = f"<noscript>{CANNOT}</noscript>" % (
    "This page needs JavaScript. Switch it on for this address, then load the page again."
)
TOO_OLD = (
    f"""<script>
if (!window.WebSocket || !HTMLScriptElement.supports || !HTMLScriptElement.supports("importmap"))
  document.write('{CANNOT}')
</script>"""
    % "This page needs a newer browser: Chrome or Edge 96, Firefox 108, Safari 16.4, or later ones."
)


def serve(
    root: Callable[[], object],
    place: Place,
    *,
    title: str,
    ready: Callable[[str], object],
    stopped: Callable[[], bool],
    started: Callable[[], object] | None = None,
    ended: Callable[[], object] | None = None,
    idle: Callable[[], bool] = lambda: True,
) -> None:
    """Serve a page until it is to end; once in a process, as NiceGUI keeps what it serves for all of it.

    All functions are called in the one thread of the event loop.

    Args:
        root: builds the page of a browser's tab, at the path `/`.
        place: where it is served.
        title: of the page.
        ready: told the start link, which lets a browser in, once it can be opened.
        stopped: asked about every 50 ms whether to end; signals are left to the caller.
        started: called once in the event loop, before `ready`.
        idle: asked now and then whether everything may be held up for a moment, to collect garbage.
        ended: called once in the event loop where `started` was due, whatever the reason, with pages still open.

    Raises:
        InputError: the place can't be had.
        MissingExtraError: what serves pages is not installed.
    """
    extras.require("panel", "nicegui")
    from layflat.pages.server.values import problem_of_value  # noqa: PLC0415  # it needs the extra

    with place.listen() as listener:
        port = listener.getsockname()[1]
        app = _application(root, title)
        secure = place.certificate is not None
        guard = Guard(
            app, place.hosts(port), cookie=f"layflat-{port}", secure=secure, admit=listener.admit,
            judge=problem_of_value,
        )  # fmt: skip
        server = _server(guard, place)

        with TurnMonitor(tell_slow_turn) as turns:

            def loop() -> asyncio.AbstractEventLoop:  # other loops accept in other ways
                return asyncio.SelectorEventLoop(turns.selector)

            async def run() -> None:
                async with app.router.lifespan_context(app):
                    await server.startup(sockets=[listener])
                    try:
                        if started is not None:
                            started()
                        _spare_collector()
                        ready(f"{place.address(port)}/?token={guard.token}")
                        await asyncio.sleep(0)  # nobody waits for what was done so far
                        turns.reports = True
                        due = monotonic() + TIDY
                        while not stopped():
                            listener.sweep()
                            await asyncio.sleep(POLL)
                            if monotonic() > due and idle():
                                await _tidy(turns)
                                due = monotonic() + TIDY
                    finally:
                        if ended is not None:
                            ended()
                        await server.shutdown(sockets=[listener])
                        logging.getLogger("nicegui").setLevel(
                            logging.CRITICAL
                        )  # what is slow to end ends with the rest

            with asyncio.Runner(loop_factory=loop) as runner:
                runner.run(run())


def tell_slow_turn(turn: Turn) -> None:
    """Log a turn of the event loop that people at the pages feel."""
    if turn.slow:
        LOG.warning("%s", turn)


def _spare_collector() -> None:
    """Exempt all present objects from garbage collection: each pass over them holds everything up for 0.3 s."""
    gc.collect()
    gc.freeze()
    # What pages have made since is looked through in small parts; as a whole, which takes 0.1 s, where nobody waits.
    gc.set_threshold(*SPARING)


async def _tidy(turns: TurnMonitor) -> None:
    """Collect all garbage, while nobody waits."""
    turns.reports = False
    gc.collect()
    await asyncio.sleep(0)
    turns.reports = True


def _server(guard: Guard, place: Place) -> "Server":
    """Return a server that prints nothing, and is started and stopped by hand: its own loop would take the signals."""
    import uvicorn  # noqa: PLC0415

    config = uvicorn.Config(
        guard, lifespan="off", log_config=None, log_level="critical", access_log=False,
        http="h11", h11_max_incomplete_event_size=HEAD, ws_max_size=LARGEST, ws_per_message_deflate=False,
        proxy_headers=False, server_header=False, timeout_graceful_shutdown=GRACE,
        ssl_certfile=place.certificate, ssl_keyfile=place.key,
    )  # fmt: skip
    config.load()
    server = uvicorn.Server(config)
    server.lifespan = config.lifespan_class(config)
    return server


def _application(root: Callable[[], object], title: str) -> "FastAPI":
    """Return an application with the page at its root, which writes nothing and asks nobody else for anything."""
    nicegui = extras.module("panel", "nicegui")
    ui = nicegui.ui
    from fastapi import FastAPI  # noqa: PLC0415

    for name in ("nicegui", "asyncio"):  # a page that is not there any more is nobody's concern
        logging.getLogger(name).setLevel(logging.ERROR)
    log_in_lines()
    nicegui.app.config.socket_io_js_transports = ["websocket"]  # the guard lets no other through
    app = FastAPI(openapi_url=None)
    nicegui.app.config.quasar_config["loadingBar"]["skipHijack"] = True  # a bar without a name for readers of screens
    ui.page("/", title=title)(root)
    ui.add_body_html(NO_SCRIPTS, shared=True)
    ui.add_body_html(TOO_OLD, shared=True)
    ui.run_with(
        app,
        title=title,
        language="en-US",
        reconnect_timeout=RECONNECT,
        gzip_middleware_factory=None,  # it would only cost time on one's own computer
        show_welcome_message=False,
    )
    return app
