"""A server of the small page, and plain requests to it."""

import os
import signal
import socket
import ssl
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPMessage, HTTPSConnection
from pathlib import Path
from urllib.parse import urlsplit

from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

PAGE = Path(__file__).parent / "page.py"
ELEMENTS = PAGE.with_name("elements.py")
SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"


@dataclass(frozen=True)
class Answer:
    status: int
    headers: HTTPMessage
    text: str


@dataclass(frozen=True)
class Served:
    link: str
    process: subprocess.Popen[str]
    trusted: ssl.SSLContext | None = None

    @property
    def origin(self) -> str:
        return self.link.partition("/?")[0]

    @property
    def port(self) -> int:
        port = urlsplit(self.link).port
        assert port is not None
        return port

    @property
    def token(self) -> str:
        return self.link.partition("token=")[2]

    def ask(
        self,
        target: str = "/",
        headers: Mapping[str, str] | None = None,
        method: str = "GET",
        body: bytes | Iterable[bytes] | None = None,
    ) -> Answer:
        """What the server answers; nothing is sent but what is given, and the host."""
        given = {"Host": f"127.0.0.1:{self.port}"} | dict(headers or {})
        if self.trusted is None:
            line = HTTPConnection("127.0.0.1", self.port, timeout=5.0)
        else:
            line = HTTPSConnection("127.0.0.1", self.port, timeout=5.0, context=self.trusted)
        try:
            line.request(method, target, body, given)
            answer = line.getresponse()
            return Answer(answer.status, answer.headers, answer.read().decode(errors="replace"))
        finally:
            line.close()

    def cookie(self) -> str:
        """What a browser has once it opened the start link."""
        return self.ask(f"/?token={self.token}").headers["Set-Cookie"].partition(";")[0]

    def allowed(self, **more: str) -> dict[str, str]:
        """Headers of a request by somebody who opened the start link, with more of them."""
        return {"Cookie": self.cookie()} | {name.replace("_", "-"): value for name, value in more.items()}

    def socket(self, origin: str | None = None, cookie: str | None = None, host: str = "127.0.0.1") -> ClientConnection:
        """A websocket, by default as the page opens it; '' leaves a header out."""
        origin = self.origin if origin is None else origin
        cookie = self.cookie() if cookie is None else cookie
        return connect(
            f"ws://{host}:{self.port}{SOCKET}",
            sock=socket.create_connection(("127.0.0.1", self.port)),
            origin=Origin(origin) if origin else None,
            additional_headers={"Cookie": cookie} if cookie else {},
            open_timeout=5.0,
            max_size=None,
            proxy=None,
        )

    def descriptors(self) -> int:
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))  # noqa: PTH208

    def terminate(self) -> None:
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(10.0)


def lines_of(said: str) -> list[str]:
    """What a server said, but for slow turns: others on the computer may take its processor."""
    return [line for line in said.splitlines() if "the pages were held up for" not in line]


@contextmanager
def serving(
    folder: Path, port: int = 0, files: tuple[Path, Path] | None = None, complaints: list[str] | None = None,
    page: Path = PAGE,
) -> Iterator[Served]:  # fmt: skip
    """A server whose working folder is the one given; it says nothing but its link and its end, and its complaints."""
    command = [sys.executable, str(page), str(port), *map(str, files or ())]
    pipe, paths = subprocess.PIPE, os.pathsep.join([str(PAGE.parents[3]), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"PYTHONPATH": paths}
    with subprocess.Popen(
        command, cwd=folder, stdin=pipe, stdout=pipe, stderr=pipe, text=True, env=environment
    ) as process:
        assert process.stdout is not None
        link = process.stdout.readline().strip()
        trusted = ssl.create_default_context(cafile=files[0]) if files else None
        try:
            yield Served(link, process, trusted)
        finally:
            said, lines = process.communicate(timeout=10.0)
        found = lines_of(lines)
        if complaints is not None:
            complaints += found
            found = []
        assert (process.returncode, said, found) == (0, "ended\n", [])
