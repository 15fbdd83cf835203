"""What of a request can be judged without knowing who sent it: its host, its path, its method and its origin."""

from dataclasses import dataclass
from typing import TYPE_CHECKING
from urllib.parse import unquote_to_bytes

if TYPE_CHECKING:
    from starlette.types import Scope

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
