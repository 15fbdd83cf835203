"""A visitor of a page that speaks the protocol of its browser: presses and types by name, reads texts, minds a rig.

It does what a page's scripts do, without a browser that would take a processor for itself.
"""

import json
import re
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from html import unescape
from http.client import HTTPConnection
from typing import Any, Self
from urllib.parse import quote, urlencode, urlsplit
from uuid import uuid4

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

RENEWAL = 0.05  # between two renewals of the lease, as of minder.js, s
SILENT = 1.0  # without a beat, after which a page renews nothing, s
Found = dict[str, Any]


def opened(link: str) -> tuple[str, str]:
    """Origin and cookie of somebody who opened the start link."""
    address = urlsplit(link)
    line = HTTPConnection(str(address.hostname), address.port, timeout=20.0)
    line.request("GET", f"/?{address.query}")
    cookie = line.getresponse().headers["Set-Cookie"].partition(";")[0]
    line.close()
    return f"{address.scheme}://{address.netloc}", cookie


def page_text(origin: str, cookie: str, path: str = "/") -> str:
    """The page as it is served."""
    address = urlsplit(origin)
    line = HTTPConnection(str(address.hostname), address.port, timeout=20.0)
    line.request("GET", path, headers={"Cookie": cookie})
    text = line.getresponse().read().decode()
    line.close()
    return text


class Visitor:
    """A page of one's own; `with Visitor(link) as visitor: visitor.press("Start")`."""

    def __init__(self, link: str) -> None:
        self.link = link
        self.origin, self.cookie = opened(link)
        text = page_text(self.origin, self.cookie)
        raw = re.search(r"parseElements\(String\.raw`(.*?)`\)", text, re.DOTALL)
        query = re.search(r"query: (\{.*?\}),?\n", text)
        assert raw, text
        assert query, text
        self.elements: dict[int, Found] = {int(key): one for key, one in json.loads(unescape(raw[1])).items()}
        self.query = json.loads(query[1].replace("True", "true").replace("'", '"'))
        self.client = str(self.query["client_id"])
        self.tab = {"tab_id": str(uuid4()), "document_id": str(uuid4())}
        self.messages: list[tuple[str, Any]] = []  # all but updates
        self.beat, self.minds, self.jogs = 0, True, list[str]()
        self.heard_at = -SILENT  # the last beat, s, monotonic
        self._drawn = set[int]()  # charts
        self.heard = threading.Condition()
        self._over = threading.Event()

    def __enter__(self) -> Self:
        """Open the socket; again where it was closed, as a browser does that comes back."""
        self.line = self.socket({**self.query, **self.tab, "implicit_handshake": "true"})
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._listen, self._renew)]
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self.line.close()

    def socket(self, query: Found) -> ClientConnection:
        """One more socket, as by this page."""
        words = urlencode({"EIO": 4, "transport": "websocket", **query}, quote_via=quote)
        address = urlsplit(self.origin)
        line = connect(
            f"ws://{address.netloc}/_nicegui_ws/socket.io/?{words}",
            sock=socket.create_connection((str(address.hostname), address.port or 80)),
            origin=Origin(self.origin), additional_headers={"Cookie": self.cookie}, open_timeout=20.0, max_size=None,
            proxy=None, compression=None,
        )  # fmt: skip
        line.recv(10.0)
        line.send("40")
        return line

    def _listen(self) -> None:
        with suppress(ConnectionClosed):
            for text in self.line:
                if text == "2":
                    self.line.send("3")
                elif isinstance(text, str) and text.startswith("42"):
                    self._take(*json.loads(text[2:]))

    def _take(self, name: str, data: Any = None) -> None:
        with self.heard:
            if name == "update":
                ones = [(int(key), one) for key, one in data.items() if key != "_id" and one]
                drawn = [key for key, one in ones if self._listener(one, "chart:rendered")]
                for key, one in data.items():
                    if key == "_id":
                        continue
                    if one is None:
                        self.elements.pop(int(key), None)
                    else:
                        self.elements[int(key)] = one
            elif name == "run_javascript" and (beat := re.search(r'"beat", ?\[?(\d+)', data["code"])):
                self.beat, self.heard_at = int(beat[1]), time.monotonic()
            else:
                self.messages.append((name, data))
            self.heard.notify_all()
        for key in drawn if name == "update" else ():
            if key not in self._drawn:
                self._drawn.add(key)
                self.emit((key, self.elements[key]), "chart:rendered", None)

    def _renew(self) -> None:
        found: tuple[int, Found] | None = None
        while not self._over.wait(RENEWAL):
            if found is None and self.heard_at > 0.0:
                found = next((one for one in self.each() if self._listener(one[1], "renew")), None)
            if self.minds and found is not None and time.monotonic() - self.heard_at < SILENT:
                with suppress(ConnectionClosed):
                    self.emit(found, "renew", {"beat": self.beat, "jogs": self.jogs})

    def each(self) -> list[tuple[int, Found]]:
        """All elements, by number."""
        with self.heard:
            return sorted(self.elements.items())

    @staticmethod
    def _listener(one: Found, kind: str) -> str | None:
        return next((event["listener_id"] for event in one.get("events", []) if event["type"] == kind), None)

    def emit(self, found: tuple[int, Found], kind: str, *args: Any) -> None:
        """Let an element tell of an event."""
        listener = self._listener(found[1], kind)
        assert listener, (kind, found)
        values = [json.dumps(arg) for arg in args]
        self.say("event", {"id": found[0], "client_id": self.client, "listener_id": listener, "args": values})

    def say(self, name: str, data: Any) -> None:
        """Send an event of the socket."""
        self.line.send("42" + json.dumps([name, data]))

    def find(self, name: str, *kinds: str) -> tuple[tuple[int, Found], str]:
        """The first element of a name (label, text or hint) that listens to one of some kinds of events."""
        for found in self.named(name):
            for kind in kinds:
                if self._listener(found[1], kind):
                    return found, kind
        raise AssertionError(f"no {name!r} that listens to {kinds}")

    def named(self, name: str) -> Iterator[tuple[int, Found]]:
        """All elements of a name."""
        for number, one in self.each():
            props = one.get("props", {})
            if name in (props.get("aria-label"), props.get("label"), one.get("text"), props.get("placeholder")):
                yield number, one

    def press(self, name: str) -> None:
        """Press a button."""
        self.emit(*self.find(name, "click"))

    def enter(self, name: str, value: Any) -> None:
        """Put a value into a field, a slider or a box."""
        self.emit(*self.find(name, "update:modelValue", "update:value"), value)

    def enabled(self, name: str) -> bool:
        """Whether a button can be pressed."""
        return not self.find(name, "click")[0][1].get("props", {}).get("disable")

    @property
    def text(self) -> str:
        """All texts on the page, a line each."""
        return "\n".join(str(one["text"]) for _, one in self.each() if one.get("text"))

    def text_of(self, style: str) -> str:
        """The text of the first element of a class."""
        return next((str(one.get("text", "")) for _, one in self.each() if style in one.get("class", [])), "")

    def until(self, condition: Callable[[], bool], seconds: float = 20.0) -> float:
        """Wait for what the page tells; returns how long it took, s."""
        begun = time.monotonic()
        while not condition():
            left = begun + seconds - time.monotonic()
            assert left > 0.0, self.text
            with self.heard:
                self.heard.wait(min(left, 0.02))
        return time.monotonic() - begun
