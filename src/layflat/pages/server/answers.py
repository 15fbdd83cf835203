"""Answers of our own with the headers that every answer bears, and what of a request can be judged by itself."""

from dataclasses import dataclass
from html import escape
from http import HTTPStatus
from typing import TYPE_CHECKING
from urllib.parse import unquote_to_bytes

if TYPE_CHECKING:
    from starlette.types import Message, Receive, Scope, Send

METHODS = ("GET", "HEAD", "POST")


@dataclass(frozen=True)
class Refusal:
    """That a request is refused: the status of HTTP, and what a person is told."""

    status: int
    words: str


ELSEWHERE = Refusal(
    400, "The pages are not served at this address. Open the link that layflat printed when it started."
)
NO_PATH = Refusal(400, "There can be no page at this address.")
NO_METHOD = Refusal(405, f"Pages are asked for with {', '.join(METHODS)}.")
FOREIGN = Refusal(403, "Another page asked for this one. Open the link that layflat printed when it started.")


def refusal(scope: "Scope", hosts: frozenset[str]) -> Refusal | None:
    """Return why a request is refused whoever sent it, or None.

    Args:
        scope: of the request, `http` or `websocket`.
        hosts: that it may name, with their ports, in lower case.
    """
    named = [host.lower() for host in headers(scope, "host")]
    if len(named) != 1 or named[0] not in hosts:
        return ELSEWHERE
    if not _is_plain(scope["raw_path"]):
        return NO_PATH
    if scope["type"] == "http" and scope["method"] not in METHODS:
        return NO_METHOD
    return FOREIGN if _is_foreign(scope, named[0]) else None


def headers(scope: "Scope", name: str) -> list[str]:
    """Return the values of a header of a request."""
    return [value.decode("latin-1") for key, value in scope["headers"] if key.lower() == name.encode()]


def _is_plain(path: bytes) -> bool:
    """Return whether a path leads downwards only, however often it was encoded."""
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
    """Return whether another page asked for this one, except by leading a person to it."""
    socket = scope["type"] == "websocket"
    origins = [origin.lower() for origin in headers(scope, "origin")]
    secure = scope["scheme"] in ("https", "wss")
    if any(origin != f"{'https' if secure else 'http'}://{host}" for origin in origins) or (socket and not origins):
        return True
    if all(site in ("same-origin", "none") for site in headers(scope, "sec-fetch-site")):
        return False
    led = headers(scope, "sec-fetch-mode") == ["navigate"] and headers(scope, "sec-fetch-dest") == ["document"]
    return socket or not led


POLICY = {
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
HEADERS = [
    (b"content-security-policy", "; ".join(f"{key} {value}" for key, value in POLICY.items()).encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
]
PAGE = """<!doctype html>
<html lang="en-US"><head><meta charset="utf-8"><title>layflat</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">{head}
<style>body {{ font: 1.1rem/1.5 sans-serif; max-width: 36rem; margin: 15vh auto; padding: 0 1rem }}</style></head>
<body><main><h1>layflat</h1><p>{body}</p></main></body></html>
"""
ENTRY = PAGE.format(
    head='<meta http-equiv="refresh" content="0; url=/">', body='<a href="/">Go on to the page</a>'
).encode()


def protected(send: "Send") -> "Send":
    """Return what sends with the headers that protect a page, in place of those that the application set."""
    names = {name for name, _ in HEADERS}

    async def protecting(message: "Message") -> None:
        if message["type"] == "http.response.start":
            own = [(name, value) for name, value in message.get("headers", []) if name.lower() not in names]
            message = {**message, "headers": own + HEADERS}
        await send(message)

    return protecting


async def enter(send: "Send", cookie: str) -> None:
    """Send the page that gives a browser its cookie and goes on by itself.

    A redirect would not do: a browser that comes from another page does not send a strict cookie after one.
    """
    await _send(send, 200, ENTRY, [(b"set-cookie", cookie.encode())])


async def refuse(send: "Send", refused: Refusal) -> None:
    """Send a page that says why a request is refused; the connection ends with it."""
    more = [(b"connection", b"close")]
    if refused.status == HTTPStatus.METHOD_NOT_ALLOWED:
        more.append((b"allow", ", ".join(METHODS).encode()))
    await _send(send, refused.status, PAGE.format(head="", body=escape(refused.words)).encode(), more)


async def refuse_socket(scope: "Scope", receive: "Receive", send: "Send", refused: Refusal) -> None:
    """Refuse a websocket before it opens, with a page where the server can send one."""
    await receive()
    if "websocket.http.response" not in scope.get("extensions", {}):
        await send({"type": "websocket.close"})
        return

    async def as_socket(message: "Message") -> None:
        await send({**message, "type": f"websocket.{message['type']}"})

    await refuse(protected(as_socket), refused)


async def _send(send: "Send", status: int, body: bytes, more: list[tuple[bytes, bytes]]) -> None:
    headers = [
        (b"content-type", b"text/html; charset=utf-8"),
        (b"content-length", str(len(body)).encode()),
        (b"cache-control", b"no-store"),
        *more,
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
