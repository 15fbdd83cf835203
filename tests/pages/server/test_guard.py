import http.client
import socket
from collections.abc import Iterator

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.connection import Connection

from tests.pages.server.serving import Served


def test_the_start_link_gives_a_cookie_and_goes_on_by_itself(served: Served) -> None:
    answer = served.ask(f"/?token={served.token}")
    assert answer.status == 200
    assert '<meta http-equiv="refresh" content="0; url=/">' in answer.text
    assert answer.headers["Cache-Control"] == "no-store"
    cookie, *flags = answer.headers["Set-Cookie"].split("; ")
    assert cookie.startswith(f"layflat-{served.port}=")
    assert served.token not in cookie
    assert flags == ["HttpOnly", "SameSite=Strict", "Path=/"]


def test_with_the_cookie_the_page_is_served(served: Served) -> None:
    answer = served.ask("/", {"Cookie": f"other=1; {served.cookie()}; more=a=b"})
    assert answer.status == 200
    assert '<html lang="en-US">' in answer.text
    assert "A page for tests" in answer.text
    assert "width=device-width" in answer.text


@pytest.mark.parametrize("path", ["/", "/favicon.ico", "/_nicegui/3.18.0/static/nicegui.js", "/not-there", "/body"])
def test_nothing_is_served_without_the_cookie(served: Served, path: str) -> None:
    wrong = served.cookie()[:-1] + "~"
    for headers in ({}, {"Cookie": wrong}, {"Cookie": f"layflat-{served.port}=" + served.token}, {"Cookie": ";;=é"}):
        answer = served.ask(path, headers)
        assert answer.status == 403
        assert "A link of an earlier start does not work any more" in answer.text
        assert answer.headers["Set-Cookie"] is None


@pytest.mark.parametrize("token", ["", "wrong", "{token}x", "%00", "%C3%A9"])
def test_a_wrong_token_lets_nobody_in(served: Served, token: str) -> None:
    answer = served.ask("/?token=" + token.format(token=served.token))
    assert answer.status == 403
    assert answer.headers["Set-Cookie"] is None


def test_the_token_opens_the_front_door_only(served: Served) -> None:
    assert served.ask(f"/favicon.ico?token={served.token}").status == 403
    for method in ("HEAD", "POST"):
        assert served.ask(f"/?token={served.token}", method=method).status == 403


def test_a_socket_needs_the_cookie(served: Served) -> None:
    for cookie in ("", f"layflat-{served.port}=wrong"):
        with pytest.raises(InvalidStatus) as refused:
            served.socket(cookie=cookie)
        assert refused.value.response.status_code == 403
        assert b"earlier start" in (refused.value.response.body or b"")


def test_a_large_body_is_refused_by_its_length(served: Served) -> None:
    assert served.ask("/body", served.allowed(), "POST", bytes(2**20)).text == str(2**20)
    line = http.client.HTTPConnection("127.0.0.1", served.port, timeout=5.0)
    line.putrequest("POST", "/body")
    for name, value in served.allowed(Content_Length=str(2**20 + 1)).items():
        line.putheader(name, value)
    line.endheaders()
    answer = line.getresponse()
    assert answer.status == 413
    assert b"More than 1 MiB" in answer.read()
    line.close()


def test_a_large_body_is_refused_while_it_streams(served: Served) -> None:
    head = "POST /body HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nCookie: {}\r\nTransfer-Encoding: chunked\r\n\r\n"
    with socket.create_connection(("127.0.0.1", served.port), timeout=5.0) as line:
        line.sendall(head.format(served.port, served.cookie()).encode())
        line.sendall(b"%x\r\n" % (2**20 + 1) + bytes(2**20 + 1))
        assert line.recv(2**16).startswith(b"HTTP/1.1 413 ")


def test_a_body_without_end_is_cut_off(served: Served) -> None:
    sent = 0

    def pieces() -> Iterator[bytes]:
        nonlocal sent
        while True:
            sent += 2**16
            yield bytes(2**16)

    line = http.client.HTTPConnection("127.0.0.1", served.port, timeout=5.0)
    with pytest.raises(OSError, match=r"Broken pipe|reset"):
        line.request("POST", "/body", pieces(), served.allowed(), encode_chunked=True)
    assert 2**20 < sent < 2**24
    line.close()


@pytest.mark.parametrize("size", [10**6 + 1, 2**20 + 1])
def test_a_large_message_closes_the_socket(served: Served, size: int) -> None:
    def spoken(page: Connection) -> None:
        page.send("4" * size)
        page.recv(timeout=5.0)

    with served.socket() as page:
        page.recv(timeout=5.0)
        with pytest.raises(ConnectionClosed):
            spoken(page)
    assert served.ask("/", served.allowed()).status == 200
