"""Guard of the pages: admits requests only with the start link, and only from pages of our own."""

import asyncio
import secrets
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from http import HTTPStatus
from time import monotonic
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, unquote_to_bytes

from layflat.pages.server.messages import Judge, filter_messages, socket_problem
from layflat.pages.server.place import Peer

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

ALLOWED_METHODS = ("GET", "HEAD", "POST")
CONTENT_POLICY = {
    "default-src": "'self'",
    # Pages of NiceGUI are built by scripts in their text, and Vue compiles its templates in the browser.
    "script-src": "'self' 'unsafe-inline' 'unsafe-eval'",
    "style-src": "'self' 'unsafe-inline'",
    "img-src": "'self' data: blob:",
    "object-src": "'none'",
    "frame-ancestors": "'none'",
    "form-action": "'self'",
    "base-uri": "'self'",
}
SECURITY_HEADERS = [
    (b"content-security-policy", "; ".join(f"{key} {value}" for key, value in CONTENT_POLICY.items()).encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
]
MESSAGE_PAGE = """<!doctype html>
<html lang="en-US"><head><meta charset="utf-8"><title>layflat</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">{head}
<style>body {{ font: 1.1rem/1.5 sans-serif; max-width: 36rem; margin: 15vh auto; padding: 0 1rem }}</style></head>
<body><main><h1>layflat</h1><p>{body}</p></main></body></html>
"""
ENTRY_PAGE = MESSAGE_PAGE.format(
    head='<meta http-equiv="refresh" content="0; url=/">', body='<a href="/">Go on to the page</a>'
).encode()
MIN_PAGE_INTERVAL = 0.04  # between two pages that are built, s
MAX_BODY_SIZE = 2**20  # bytes of a request's body or of a socket's message
SOCKET_PATH = "/_nicegui_ws"  # path of the pages' sockets


@dataclass(frozen=True)
class Refusal:
    """Refusal of a request: HTTP status, and message for a person."""

    status: int
    words: str


WRONG_HOST = Refusal(
    400, "The pages are not served at this address. Open the link that layflat printed when it started."
)
NO_PATH = Refusal(400, "There can be no page at this address.")
NO_METHOD = Refusal(405, f"Pages are requested with {', '.join(ALLOWED_METHODS)}.")
FOREIGN_ORIGIN = Refusal(403, "Another page asked for this one. Open the link that layflat printed when it started.")


def find_refusal(scope: "Scope", hosts: frozenset[str]) -> Refusal | None:
    """Return the first refusal that holds for a request whoever sent it: of host, path, method or origin; else None.

    Args:
        scope: ASGI scope of the request, `http` or `websocket`.
        hosts: hosts that it may name, with their ports, in lower case.
    """
    named = [host.lower() for host in header_values(scope, "host")]
    if len(named) != 1 or named[0] not in hosts:
        return WRONG_HOST
    if not _is_plain(scope["raw_path"]):
        return NO_PATH
    if scope["type"] == "http" and scope["method"] not in ALLOWED_METHODS:
        return NO_METHOD
    return FOREIGN_ORIGIN if _is_foreign(scope, named[0]) else None


def header_values(scope: "Scope", name: str) -> list[str]:
    """Return the values of a header of a request, in their order; `name` is in lower case."""
    return [value.decode("latin-1") for key, value in scope["headers"] if key.lower() == name.encode()]


def _is_plain(path: bytes) -> bool:
    """Return whether a path begins with "/", and has no "..", backslash or null, decoded up to three times.

    One that is encoded more often is not plain.
    """
    if not path.startswith(b"/"):
        return False
    for _ in range(4):
        if any(bad in path for bad in (b"..", b"\\", b"\0")):
            return False
        before, path = path, unquote_to_bytes(path)
        if path == before:
            return True
    return False


def _is_foreign(scope: "Scope", host: str) -> bool:
    """Return whether a request comes from a page of another origin; a followed link to a document is not foreign.

    A websocket is foreign without an Origin header, too; an HTTP request without one may be our own.
    """
    socket = scope["type"] == "websocket"
    origins = [origin.lower() for origin in header_values(scope, "origin")]
    secure = scope["scheme"] in ("https", "wss")
    if any(origin != f"{'https' if secure else 'http'}://{host}" for origin in origins) or (socket and not origins):
        return True
    if all(site in ("same-origin", "none") for site in header_values(scope, "sec-fetch-site")):
        return False
    is_navigation = header_values(scope, "sec-fetch-mode") == ["navigate"] and header_values(
        scope, "sec-fetch-dest"
    ) == ["document"]
    return socket or not is_navigation


def add_security_headers(send: "Send") -> "Send":
    """Return a `send` whose responses carry `SECURITY_HEADERS`, in place of the application's."""
    names = {name for name, _ in SECURITY_HEADERS}

    async def protecting(message: "Message") -> None:
        """Send a message, with the headers if it starts a response."""
        if message["type"] == "http.response.start":
            others = [(name, value) for name, value in message.get("headers", []) if name.lower() not in names]
            message = {**message, "headers": others + SECURITY_HEADERS}
        await send(message)

    return protecting


async def send_entry_page(send: "Send", cookie: str) -> None:
    """Send the page that sets the cookie and then loads the pages' root.

    A redirect is not enough: a browser that comes from another page does not send a strict cookie after one.
    """
    await _send_response(send, 200, ENTRY_PAGE, [(b"set-cookie", cookie.encode())])


async def refuse(send: "Send", refused: Refusal) -> None:
    """Send a refusal as a page with its status; its headers have the server close the connection."""
    extra_headers = [(b"connection", b"close")]
    if refused.status == HTTPStatus.METHOD_NOT_ALLOWED:
        extra_headers.append((b"allow", ", ".join(ALLOWED_METHODS).encode()))
    await _send_response(
        send, refused.status, MESSAGE_PAGE.format(head="", body=escape(refused.words)).encode(), extra_headers
    )


async def refuse_socket(scope: "Scope", receive: "Receive", send: "Send", refused: Refusal) -> None:
    """Refuse a websocket before it opens, with a page where the server can send one, else by closing it.

    Args:
        scope: ASGI scope of the socket.
        receive: receives its first message.
        send: sends to the browser.
        refused: refusal that is sent.
    """
    await receive()
    if "websocket.http.response" not in scope.get("extensions", {}):
        await send({"type": "websocket.close"})
        return

    async def as_socket(message: "Message") -> None:
        await send({**message, "type": f"websocket.{message['type']}"})

    await refuse(add_security_headers(as_socket), refused)


async def _send_response(send: "Send", status: int, body: bytes, more: list[tuple[bytes, bytes]]) -> None:
    """Send a whole response, which no browser stores: HTML body, and further headers."""
    headers = [
        (b"content-type", b"text/html; charset=utf-8"),
        (b"content-length", str(len(body)).encode()),
        (b"cache-control", b"no-store"),
        *more,
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})


NO_TOKEN = Refusal(
    403,
    "This page needs the link that layflat printed when it started. A link of an earlier start does not work any more.",
)
NO_SOCKET = Refusal(400, "Pages speak with this address by websocket.")
TOO_LARGE = Refusal(413, f"More than {MAX_BODY_SIZE // 2**20} MiB can't be sent to this page.")


class Guard:
    """ASGI middleware that lets through only HTTP requests and websockets of its own pages.

    A browser presents the token of the start link once, and a cookie from then on. Both are new for each guard.

    Args:
        app: application that is guarded.
        hosts: hosts that a request may name, with their ports, in lower case.
        cookie: name of the cookie; browsers share cookies among the ports of a host.
        secure: whether the pages are served by TLS.
        admit: called with the peer (address, port) of each connection whose request is let through.
        judge: returns the problem of the values in an event of a page; "" where there is none.

    Attributes:
        token: token of the start link, `/?token=...`.
    """

    def __init__(
        self, app: "ASGIApp", hosts: frozenset[str], *, cookie: str, secure: bool, admit: Callable[[Peer], object],
        judge: Judge,
    ) -> None:  # fmt: skip
        """Draw a new token and a new secret for the cookie."""
        self.app, self.token = app, secrets.token_urlsafe(32)
        self._hosts, self._cookie, self._secure = hosts, cookie, secure
        self._admit, self._judge = admit, judge
        self._secret = secrets.token_urlsafe(32)
        self._last_slot = 0.0  # time at which the last page is built, s, monotonic

    async def __call__(self, scope: "Scope", receive: "Receive", send: "Send") -> None:
        """Answer a request: refuse it, give the cookie to one with the right token, or pass it on to the application.

        Pages at the root are built at least `MIN_PAGE_INTERVAL` apart.
        """
        refused = find_refusal(scope, self._hosts)
        tokens = self._tokens(scope)
        if refused is None and not (
            _holds_secret(tokens, self.token) if tokens else _holds_secret(self._cookies(scope), self._secret)
        ):
            refused = NO_TOKEN
        if refused is None:
            refused = _refuse_wrong_protocol(scope)
        if refused is None and scope["client"]:
            self._admit(scope["client"])
        if scope["type"] == "websocket":
            if refused is None:
                await self.app(scope, filter_messages(receive, self._judge), send)
            else:
                await refuse_socket(scope, receive, send, refused)
        elif refused is not None:
            await refuse(add_security_headers(send), refused)
        elif tokens:
            flags = "; Secure" if self._secure else ""
            await send_entry_page(
                add_security_headers(send), f"{self._cookie}={self._secret}; HttpOnly; SameSite=Strict; Path=/{flags}"
            )
        else:
            if scope["path"] == "/":
                await self._wait_for_slot()
            await _serve_limited(self.app, scope, receive, add_security_headers(send))

    async def _wait_for_slot(self) -> None:
        """Wait until a page may be built: in the order of the requests, at least `MIN_PAGE_INTERVAL` apart."""
        now = monotonic()
        slot = self._last_slot = max(now, self._last_slot + MIN_PAGE_INTERVAL)
        await asyncio.sleep(slot - now)

    def _tokens(self, scope: "Scope") -> list[str]:
        """Return the tokens in the query of a GET request for the pages' root; none for any other request."""
        if scope["type"] != "http" or scope["method"] != "GET" or scope["path"] != "/":
            return []
        return parse_qs(scope["query_string"].decode("latin-1")).get("token", [])

    def _cookies(self, scope: "Scope") -> list[str]:
        """Return the values of all cookies of a request that have this guard's name."""
        pairs = [pair.strip().partition("=") for value in header_values(scope, "cookie") for pair in value.split(";")]
        return [value for name, _, value in pairs if name == self._cookie]


def _refuse_wrong_protocol(scope: "Scope") -> Refusal | None:
    """Return the refusal of HTTP on the socket's path, and of a WebSocket elsewhere or with a malformed query.

    None for a valid request.
    """
    of_socket = scope["path"].startswith(SOCKET_PATH)
    if scope["type"] == "http":
        return NO_SOCKET if of_socket else None
    problem = socket_problem(scope) if of_socket else "leads nowhere"
    return Refusal(400, f"This request for a socket {problem}.") if problem else None


def _holds_secret(values: list[str], secret: str) -> bool:
    """Return whether a secret is among some values, in a time that does not depend on how much is right."""
    return any(secrets.compare_digest(value.encode(), secret.encode()) for value in values)


async def _serve_limited(app: "ASGIApp", scope: "Scope", receive: "Receive", send: "Send") -> None:
    """Serve a request, and refuse it once its body exceeds `MAX_BODY_SIZE`, whatever its header states.

    An application that has begun its answer sees a disconnection instead; its errors after that are suppressed.
    """
    length = header_values(scope, "content-length")
    if length and int(length[0]) > MAX_BODY_SIZE:
        await refuse(send, TOO_LARGE)
        return
    received, answered, ended = 0, False, False

    async def counted() -> "Message":
        """Receive a message; refuse the request and report a disconnection once the body is too large."""
        nonlocal received, ended
        message = await receive()
        received += len(message.get("body", b""))
        if received <= MAX_BODY_SIZE:
            return message
        if not answered:
            await refuse(send, TOO_LARGE)
        ended = True
        return {"type": "http.disconnect"}

    async def answer(message: "Message") -> None:
        """Send a message of the application, unless the request was refused."""
        nonlocal answered
        if not ended:
            answered = True
            await send(message)

    try:
        await app(scope, counted, answer)
    except Exception:
        if not ended:
            raise
