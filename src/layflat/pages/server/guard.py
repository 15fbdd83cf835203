"""Access to the pages: only with the start link, and only from pages of our own."""

import asyncio
import secrets
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING
from urllib.parse import parse_qs

from layflat.pages.server.answers import Refusal, enter, headers, protected, refusal, refuse, refuse_socket
from layflat.pages.server.connections import Peer
from layflat.pages.server.messages import Judge, checked, problem_of_socket

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

SLOT = 0.04  # from one page that is made to the next, s
LARGEST = 2**20  # bytes of a body or of a message
UNKNOWN = Refusal(
    403,
    "This page needs the link that layflat printed when it started. A link of an earlier start does not work any more.",
)
SOCKETS = "/_nicegui_ws"  # path of the pages' sockets
NO_SOCKET = Refusal(400, "Pages speak with this address by websocket.")
TOO_LARGE = Refusal(413, f"More than {LARGEST // 2**20} MiB can't be sent to this page.")


class Guard:
    """Stands before an application: lets through, of HTTP and of websockets, what its own pages ask for.

    A browser shows the token of the start link once and then has a cookie. Both are made anew with each guard.

    Args:
        app: what it guards.
        hosts: that a request may name, with their ports, in lower case.
        cookie: its name; browsers share cookies among the ports of a host.
        secure: whether the pages are served by TLS.
        admit: told of each connection, by the address and port it comes from, whose request is let through.
        judge: returns what is wrong with the values in an event of a page; "" where nothing is.

    Attributes:
        token: of the start link, `/?token=...`.
    """

    def __init__(
        self, app: "ASGIApp", hosts: frozenset[str], *, cookie: str, secure: bool, admit: Callable[[Peer], object],
        judge: Judge,
    ) -> None:  # fmt: skip
        self.app, self.token = app, secrets.token_urlsafe(32)
        self._hosts, self._cookie, self._secure = hosts, cookie, secure
        self._admit, self._judge = admit, judge
        self._secret = secrets.token_urlsafe(32)
        self._last_slot = 0.0  # in which the last page was made, or will be, s, monotonic

    async def __call__(self, scope: "Scope", receive: "Receive", send: "Send") -> None:
        """Serve a request, as ASGI asks."""
        refused = refusal(scope, self._hosts)
        tokens = self._tokens(scope)
        if refused is None and not (_is(tokens, self.token) if tokens else _is(self._cookies(scope), self._secret)):
            refused = UNKNOWN
        if refused is None:
            refused = _misused(scope)
        if refused is None and scope["client"]:
            self._admit(scope["client"])
        if scope["type"] == "websocket":
            if refused is None:
                await self.app(scope, checked(receive, self._judge), send)
            else:
                await refuse_socket(scope, receive, send, refused)
        elif refused is not None:
            await refuse(protected(send), refused)
        elif tokens:
            flags = "; Secure" if self._secure else ""
            await enter(protected(send), f"{self._cookie}={self._secret}; HttpOnly; SameSite=Strict; Path=/{flags}")
        else:
            if scope["path"] == "/":
                await self._wait_for_slot()
            await _serve_limited(self.app, scope, receive, protected(send))

    async def _wait_for_slot(self) -> None:
        """Wait until a page may be made: those that are asked for at the same time are made one after the other."""
        now = monotonic()
        slot = self._last_slot = max(now, self._last_slot + SLOT)
        await asyncio.sleep(slot - now)

    def _tokens(self, scope: "Scope") -> list[str]:
        """Return the tokens that a request enters with."""
        if scope["type"] != "http" or scope["method"] != "GET" or scope["path"] != "/":
            return []
        return parse_qs(scope["query_string"].decode("latin-1")).get("token", [])

    def _cookies(self, scope: "Scope") -> list[str]:
        pairs = [pair.strip().partition("=") for value in headers(scope, "cookie") for pair in value.split(";")]
        return [value for name, _, value in pairs if name == self._cookie]


def _misused(scope: "Scope") -> Refusal | None:
    """Return why a request of somebody who may see the pages is none that a page makes."""
    of_socket = scope["path"].startswith(SOCKETS)
    if scope["type"] == "http":
        return NO_SOCKET if of_socket else None
    problem = problem_of_socket(scope) if of_socket else "leads nowhere"
    return Refusal(400, f"This request for a socket {problem}.") if problem else None


def _is(given: list[str], secret: str) -> bool:
    """Return whether a secret was given, in a time that does not tell how much of it was right."""
    return any(secrets.compare_digest(one.encode(), secret.encode()) for one in given)


async def _serve_limited(app: "ASGIApp", scope: "Scope", receive: "Receive", send: "Send") -> None:
    """Serve a request whose body may not be too large, whatever it says of its length."""
    length = headers(scope, "content-length")
    if length and int(length[0]) > LARGEST:
        await refuse(send, TOO_LARGE)
        return
    received, answered, ended = 0, False, False

    async def counted() -> "Message":
        nonlocal received, ended
        message = await receive()
        received += len(message.get("body", b""))
        if received <= LARGEST:
            return message
        if not answered:
            await refuse(send, TOO_LARGE)
        ended = True
        return {"type": "http.disconnect"}

    async def answer(message: "Message") -> None:
        nonlocal answered
        if not ended:
            answered = True
            await send(message)

    try:
        await app(scope, counted, answer)
    except Exception:
        if not ended:
            raise
