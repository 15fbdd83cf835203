"""Server loop of NiceGUI's pages, with guard, garbage collection and a monitor of slow handlers."""

import asyncio
import gc
import logging
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from time import monotonic
from typing import TYPE_CHECKING

from layflat import extras
from layflat.pages.server.guard import MAX_BODY_SIZE, Guard
from layflat.pages.server.logs import Turn, TurnMonitor, log_in_lines
from layflat.pages.server.place import Endpoint, Listener

if TYPE_CHECKING:
    from fastapi import FastAPI
    from uvicorn import Server

LOG = logging.getLogger(__name__)
COLLECTION_INTERVAL = 60.0  # between two full garbage collections, at least, s
COLLECTOR_THRESHOLDS = (2000, 10, 1_000_000)  # of the garbage collector: no automatic full collection
POLL_PERIOD = 0.05  # s
SHUTDOWN_TIMEOUT = 1  # for connections to end, s
RECONNECT_TIMEOUT = 3.0  # for a browser to come back to its page, s
MAX_HEAD_SIZE = 2**16  # bytes of a request's head, which holds all cookies of this computer

ALERT_HTML = (  # in place of NiceGUI's own message
    "<style>body > #esm-fallback { display: none }</style>"
    '<p role="alert" style="font: 1.1rem/1.5 sans-serif; max-width: 36rem; margin: 15vh auto; padding: 0 1rem">%s</p>'
)
NO_SCRIPTS = f"<noscript>{ALERT_HTML}</noscript>" % (
    "This page needs JavaScript. Switch it on for this address, then load the page again."
)
TOO_OLD = (
    f"""<script>
if (!window.WebSocket || !HTMLScriptElement.supports || !HTMLScriptElement.supports("importmap"))
  document.write('{ALERT_HTML}')
</script>"""
    % "This page needs a newer browser: Chrome or Edge 96, Firefox 108, Safari 16.4, or later ones."
)


def serve(
    root: Callable[[], object],
    place: Endpoint,
    *,
    title: str,
    ready: Callable[[str], object],
    stopped: Callable[[], bool],
    started: Callable[[], object] | None = None,
    ended: Callable[[], object] | None = None,
    idle: Callable[[], bool] = lambda: True,
) -> None:
    """Serve a page until `stopped` returns True; only once in a process, since NiceGUI keeps its pages.

    All functions are called in the one thread of the event loop.

    Args:
        root: builds the page of a browser tab, at the path `/`.
        place: endpoint at which it is served.
        title: title of the page.
        ready: called with the start link once it can be opened.
        stopped: called about every 50 ms; True ends the server. Signals are left to the caller.
        started: called once in the event loop, before `ready`.
        ended: called once in the event loop if `started` was due, whatever ends the server, with pages still open.
        idle: called now and then; True allows a pause of about 0.1 s for garbage collection.

    Raises:
        InputError: the endpoint can't be used.
        MissingExtraError: the extra `panel` is not installed.
    """
    extras.require("panel", "nicegui")
    from layflat.pages.server.values import value_problem  # noqa: PLC0415  # it needs the extra

    with place.listen() as listener:
        port = listener.getsockname()[1]
        app = _application(root, title)
        secure = place.certificate is not None
        guard = Guard(
            app, place.hosts(port), cookie=f"layflat-{port}", secure=secure, admit=listener.admit,
            judge=value_problem,
        )  # fmt: skip
        server = _server(guard, place)

        with TurnMonitor(report_slow_turn) as turns:

            def loop() -> asyncio.AbstractEventLoop:  # other loops accept in other ways
                return asyncio.SelectorEventLoop(turns.selector)

            async def run() -> None:
                """Serve the page in the event loop until `stopped` returns True."""
                async with _serve_browsers(app, server, listener, started, ended):
                    _spare_collector()
                    ready(f"{place.address(port)}/?token={guard.token}")
                    await asyncio.sleep(0)  # no caller waits for the work so far
                    turns.reports = True
                    await _watch(listener, turns, stopped, idle)

            with asyncio.Runner(loop_factory=loop) as runner:
                runner.run(run())


@asynccontextmanager
async def _serve_browsers(
    app: "FastAPI", server: "Server", listener: Listener,
    started: Callable[[], object] | None, ended: Callable[[], object] | None,
) -> AsyncIterator[None]:  # fmt: skip
    """Start application and server on a listener, then call `started`; at the end call `ended` and shut both down."""
    async with app.router.lifespan_context(app):
        await server.startup(sockets=[listener])
        try:
            if started is not None:
                started()
            yield
        finally:
            if ended is not None:
                ended()
            await server.shutdown(sockets=[listener])
            logging.getLogger("nicegui").setLevel(logging.CRITICAL)  # slow tasks end with the rest


async def _watch(listener: Listener, turns: TurnMonitor, stopped: Callable[[], bool], idle: Callable[[], bool]) -> None:
    """Wait until `stopped` returns True, polled every `POLL_PERIOD`; until then sweep the listener.

    Garbage is collected while `idle` returns True, every `COLLECTION_INTERVAL` at most.
    """
    due = monotonic() + COLLECTION_INTERVAL
    while not stopped():
        listener.sweep()
        await asyncio.sleep(POLL_PERIOD)
        if monotonic() > due and idle():
            await _collect_garbage(turns)
            due = monotonic() + COLLECTION_INTERVAL


def report_slow_turn(turn: Turn) -> None:
    """Log a turn of the event loop that people at the pages feel."""
    if turn.is_slow:
        LOG.warning("%s", turn)


def _spare_collector() -> None:
    """Exempt all present objects from garbage collection, each pass over which takes 0.3 s; switch full ones off."""
    gc.collect()
    gc.freeze()
    # Young objects of pages are collected in small parts; a full collection, of 0.1 s, happens where no page waits.
    gc.set_threshold(*COLLECTOR_THRESHOLDS)


async def _collect_garbage(turns: TurnMonitor) -> None:
    """Collect all garbage, without a report of this slow turn; later turns are reported."""
    turns.reports = False
    gc.collect()
    await asyncio.sleep(0)
    turns.reports = True


def _server(guard: Guard, place: Endpoint) -> "Server":
    """Return a server that prints nothing and that its caller starts and stops: its own loop would take signals."""
    import uvicorn  # noqa: PLC0415

    config = uvicorn.Config(
        guard, lifespan="off", log_config=None, log_level="critical", access_log=False,
        http="h11", h11_max_incomplete_event_size=MAX_HEAD_SIZE, ws_max_size=MAX_BODY_SIZE,
        ws_per_message_deflate=False, proxy_headers=False, server_header=False,
        timeout_graceful_shutdown=SHUTDOWN_TIMEOUT,
        ssl_certfile=place.certificate, ssl_keyfile=place.key,
    )  # fmt: skip
    config.load()
    server = uvicorn.Server(config)
    server.lifespan = config.lifespan_class(config)
    return server


def _application(root: Callable[[], object], title: str) -> "FastAPI":
    """Return an application with the page at its root; it prints nothing and loads nothing from other hosts.

    It changes NiceGUI's global configuration and the log handlers of all libraries that serve pages.
    """
    nicegui = extras.import_extra("panel", "nicegui")
    ui = nicegui.ui
    from fastapi import FastAPI  # noqa: PLC0415

    for name in ("nicegui", "asyncio"):  # a page that was closed needs no report
        logging.getLogger(name).setLevel(logging.ERROR)
    log_in_lines()
    nicegui.app.config.socket_io_js_transports = ["websocket"]  # the guard lets no other through
    app = FastAPI(openapi_url=None)
    nicegui.app.config.quasar_config["loadingBar"]["skipHijack"] = True  # a bar without a name for screen readers
    ui.page("/", title=title)(root)
    ui.add_body_html(NO_SCRIPTS, shared=True)
    ui.add_body_html(TOO_OLD, shared=True)
    ui.run_with(
        app,
        title=title,
        language="en-US",
        reconnect_timeout=RECONNECT_TIMEOUT,
        gzip_middleware_factory=None,  # it would only cost time on one's own computer
        show_welcome_message=False,
    )
    return app
