"""The process that serves the page, as the run sees it."""

import os
import signal
import socket
import time
from collections import Counter
from collections.abc import Callable, Iterator
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest

from layflat.errors import InputError
from layflat.pages.cell.link import PageLink
from layflat.pages.cell.snapshot import PickFigures, RunStage, RunSubject
from layflat.pages.server import Endpoint

pytest.importorskip("nicegui", reason="needs the extra 'panel'")
ABOUT = RunSubject("few", "paper-arm", 0, 3, ("pick", "result"))


@pytest.fixture(scope="module")
def link() -> Iterator[PageLink]:
    with PageLink(ABOUT, Endpoint(port=0)) as found:
        yield found


class Visitor:
    """Somebody with the start link, or without."""

    def __init__(self, link: str) -> None:
        self._url, self.cookie = urlsplit(link), ""

    def ask(self, target: str) -> tuple[int, bytes]:
        line = HTTPConnection(str(self._url.hostname), self._url.port or 0, timeout=5.0)
        try:
            line.request("GET", target, headers={"Cookie": self.cookie} if self.cookie else {})
            answer = line.getresponse()
            self.cookie = (answer.headers["Set-Cookie"] or self.cookie).partition(";")[0]
            return answer.status, answer.read()
        finally:
            line.close()

    def enter(self) -> None:
        self.ask(f"{self._url.path}?{self._url.query}")


def until(condition: Callable[[], bool]) -> None:
    begun = time.monotonic()
    while not condition():
        assert time.monotonic() - begun < 10.0
        time.sleep(0.02)


def test_images_are_for_those_with_the_link(link: PageLink) -> None:
    link.show(stage=RunStage.PACKS, figures=PickFigures(Counter(correct=2)))
    guest, stranger = Visitor(link.link), Visitor(link.link)
    guest.enter()
    assert guest.ask("/run/camera.jpg")[0] == 404
    for number in range(50):
        link.image("camera", b"image %d" % number)
    until(lambda: guest.ask("/run/camera.jpg") == (200, b"image 49"))
    assert guest.ask("/run/passwd.jpg")[0] == 404
    assert stranger.ask("/run/camera.jpg")[0] == 403
    assert guest.ask("/")[0] == 200


def test_a_port_in_use_is_said_at_once() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port} can't be had") as raised:
            PageLink(ABOUT, Endpoint(port=port))
    assert raised.value.where == "port"


def test_a_run_goes_on_without_its_page() -> None:
    with PageLink(ABOUT, Endpoint(port=0)) as link:
        process = link._process.pid
        assert process is not None
        os.kill(process, signal.SIGKILL)
        link.wait()
        begun = time.monotonic()
        for number in range(100):
            link.image("overview", bytes(100_000))
            link.show(calibrated=number / 100)
        assert time.monotonic() - begun < 1.0
