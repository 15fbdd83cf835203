import resource
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack
from threading import Thread

import pytest

from layflat.pages.server import Endpoint, place
from layflat.pages.server.place import MAX_CONNECTIONS, Listener
from tests.pages.server.serving import Served

FLOOD = 1000


@pytest.fixture
def listener() -> Iterator[Listener]:
    with Endpoint(port=0).listen() as made:
        yield made


def connected(listener: Listener) -> tuple[socket.socket, socket.socket]:
    """Both ends of a connection: of who comes, and of who serves."""
    coming = socket.create_connection(listener.getsockname(), timeout=5.0)
    listener.setblocking(True)
    serving, _ = listener.accept()
    with pytest.raises(BlockingIOError):
        listener.accept()
    return coming, serving


def is_ended(coming: socket.socket) -> bool:
    coming.settimeout(0.02)
    try:
        return coming.recv(1) == b""
    except TimeoutError:
        return False


def test_strangers_that_stay_silent_are_sent_away(listener: Listener, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(place, "ADMISSION_TIMEOUT", 0.05)
    stranger, serving = connected(listener)
    known, kept = connected(listener)
    with stranger, serving, known, kept:
        listener.admit(known.getsockname())
        listener.sweep()
        assert not is_ended(stranger)
        time.sleep(0.06)
        listener.sweep()
        assert is_ended(stranger)
        assert not is_ended(known)


def test_the_oldest_stranger_makes_room(listener: Listener) -> None:
    with ExitStack() as ends:
        coming = []
        for count in range(MAX_CONNECTIONS + 2):
            one, serving = connected(listener)
            ends.enter_context(one)
            ends.enter_context(serving)
            coming.append(one)
            if count == 0:
                listener.admit(one.getsockname())
        assert [is_ended(one) for one in coming[:4]] == [False, True, True, False]


def test_there_is_no_room_among_those_who_may_stay(listener: Listener) -> None:
    with ExitStack() as ends:
        for _ in range(MAX_CONNECTIONS):
            one, serving = connected(listener)
            ends.enter_context(one)
            ends.enter_context(serving)
            listener.admit(one.getsockname())
        late = ends.enter_context(socket.create_connection(listener.getsockname()))
        with pytest.raises(ConnectionAbortedError):
            listener.accept()
        assert is_ended(late)
        serving.close()
        with pytest.raises(BlockingIOError):  # the turn's one was the late one
            listener.accept()
        for end in connected(listener):
            ends.enter_context(end)


@pytest.fixture
def many_files() -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < FLOOD + 200:
        pytest.skip(f"needs {FLOOD + 200} open files, may have {hard}")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, FLOOD + 200), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_a_flood_locks_nobody_out(served: Served, many_files: None) -> None:
    allowed, before = served.allowed(), served.descriptors()
    idle: list[socket.socket] = []

    def flood() -> None:
        for _ in range(FLOOD):
            one = socket.socket()
            idle.append(one)
            one.setblocking(False)
            one.connect_ex(("127.0.0.1", served.port))

    longest, most = 0.0, 0
    with served.socket() as page:
        page.recv(timeout=5.0)
        coming = Thread(target=flood)
        coming.start()
        asked = 0
        while coming.is_alive() or asked < 10:
            since = time.monotonic()
            assert served.ask("/favicon.ico", allowed).status == 200
            assert page.ping().wait(1.0)
            longest, most = max(longest, time.monotonic() - since), max(most, served.descriptors())
            asked += 1
        coming.join()
        assert len(idle) == FLOOD
    for one in idle:
        one.close()
    assert longest < 1.0
    assert most < before + MAX_CONNECTIONS + 10
