import pytest
from websockets.exceptions import InvalidStatus

from tests.pages.server.serving import Served


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "LocalHost", "[::1]"])
def test_this_computer_may_be_named_in_each_way(served: Served, host: str) -> None:
    assert served.ask("/", served.allowed(Host=f"{host}:{served.port}")).status == 200


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "127.0.0.2", "localhost@evil.example", ""])
def test_a_foreign_host_is_refused_in_words(served: Served, host: str) -> None:
    for name in (f"{host}:{served.port}", host):
        answer = served.ask("/", served.allowed(Host=name))
        assert answer.status == 400
        assert "Open the link that layflat printed" in answer.text


@pytest.mark.parametrize("port", ["", ":1", ":80"])
def test_another_port_or_none_is_refused(served: Served, port: str) -> None:
    assert served.ask("/", served.allowed(Host=f"127.0.0.1{port}")).status == 400


@pytest.mark.parametrize("origin", ["http://evil.example", "https://127.0.0.1:{port}", "http://127.0.0.1:1", "null"])
def test_a_foreign_origin_is_refused(served: Served, origin: str) -> None:
    foreign = origin.format(port=served.port)
    for method in ("GET", "POST"):
        answer = served.ask("/body", served.allowed(Origin=foreign), method)
        assert answer.status == 403
        assert "Another page asked for this one" in answer.text
    with pytest.raises(InvalidStatus) as refused:
        served.socket(origin=foreign)
    assert refused.value.response.status_code == 403
    assert b"Another page asked for this one" in (refused.value.response.body or b"")


def test_our_own_origin_is_let_through(served: Served) -> None:
    assert served.ask("/body", served.allowed(Origin=served.origin), "POST", b"four").text == "4"
    with served.socket() as socket:
        assert str(socket.recv(timeout=5.0)).startswith("0{")


def test_a_socket_needs_an_origin_and_a_host_of_ours(served: Served) -> None:
    with pytest.raises(InvalidStatus, match="403"):
        served.socket(origin="")
    with pytest.raises(InvalidStatus, match="400"):
        served.socket(host="evil.example", origin=f"http://evil.example:{served.port}")


@pytest.mark.parametrize("site", ["cross-site", "same-site", "anything"])
def test_another_site_may_only_lead_a_person_here(served: Served, site: str) -> None:
    for mode, dest in (("no-cors", "script"), ("cors", "empty"), ("navigate", "iframe"), ("", "")):
        more = {"Sec_Fetch_Site": site, "Sec_Fetch_Mode": mode, "Sec_Fetch_Dest": dest}
        assert served.ask("/", served.allowed(**more)).status == 403
    led = served.allowed(Sec_Fetch_Site=site, Sec_Fetch_Mode="navigate", Sec_Fetch_Dest="document")
    assert served.ask("/", led).status == 200


@pytest.mark.parametrize(
    "path",
    [
        "/../etc/passwd",
        "/_nicegui/../../pyproject.toml",
        "/%2e%2e/etc/passwd",
        "/.%2E/etc/passwd",
        "/%252e%252e/etc/passwd",
        "/%25252e%25252e/etc/passwd",
        "/%2525252525252e/etc/passwd",
        "/..%2fetc%2fpasswd",
        "/a\\b",
        "/a%5cb",
        "/a%255Cb",
        "/a%00b",
        "/a%2500b",
        "http://evil.example/",
        "*",
    ],
)
def test_a_path_that_leads_elsewhere_is_refused(served: Served, path: str) -> None:
    assert served.ask(path, served.allowed()).status == 400


def test_an_encoded_path_that_is_plain_is_let_through(served: Served) -> None:
    assert served.ask("/%62ody", served.allowed(), "POST", b"four").text == "4"
    assert served.ask("/not%20there", served.allowed()).status == 404


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "BREW"])
def test_other_methods_are_refused(served: Served, method: str) -> None:
    answer = served.ask("/", served.allowed(), method)
    assert answer.status == 405
    assert answer.headers["Allow"] == "GET, HEAD, POST"
