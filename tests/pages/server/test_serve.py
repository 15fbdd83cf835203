import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed

from layflat.pages.server.place import MAX_CONNECTIONS
from tests.pages.browsers import chromium
from tests.pages.server.serving import SOCKET, Served, serving
from tests.pages.server.test_place import certificate

pytest.importorskip("nicegui", reason="needs the extra 'panel'")


def test_it_ends_soon_with_a_page_open_and_leaves_nothing(tmp_path: Path) -> None:
    with serving(tmp_path) as first:
        cookie = first.cookie()
        with first.socket() as page, socket.create_connection(("127.0.0.1", first.port)):
            page.recv(timeout=5.0)
            since = time.monotonic()
            first.terminate()  # left to whoever called `serve`
            assert time.monotonic() - since < 2.0
            with pytest.raises(ConnectionClosed):
                page.recv(timeout=5.0)
    assert list(tmp_path.iterdir()) == []
    with serving(tmp_path, port=first.port) as second:
        assert second.ask(f"/?token={first.token}").status == 403
        assert second.ask("/", {"Cookie": cookie}).status == 403
        assert second.ask("/", second.allowed()).status == 200


def test_pages_are_served_by_tls(tmp_path: Path) -> None:
    with serving(tmp_path, files=certificate(tmp_path)) as served:
        assert served.link.startswith("https://127.0.0.1:")
        assert served.ask(f"/?token={served.token}").headers["Set-Cookie"].endswith("; Secure")
        assert served.ask("/", served.allowed(Origin=served.origin)).status == 200
        assert served.ask("/", served.allowed(Origin=served.origin.replace("https", "http"))).status == 403
        before = served.descriptors()
        idle = [socket.create_connection(("127.0.0.1", served.port)) for _ in range(2 * MAX_CONNECTIONS)]
        assert served.ask("/", served.allowed()).status == 200
        assert served.descriptors() < before + MAX_CONNECTIONS + 10
        for one in idle:
            one.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


def test_a_browser_opens_the_link_and_its_clicks_reach_python(served: Served, browser: Any) -> None:
    context = browser.new_context()
    page = context.new_page()
    complaints: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(served.link)
    page.get_by_role("button", name="Greet").click()
    page.get_by_text("hello from Python").wait_for(timeout=5000)
    assert page.url == served.origin + "/"
    assert page.title() == "A page for tests"
    assert complaints == []
    assert all(url.startswith(served.origin + "/") for url in asked)
    assert [(one["httpOnly"], one["sameSite"]) for one in context.cookies()] == [(True, "Strict")]
    assert page.evaluate("document.cookie") == ""
    context.close()


def test_a_browser_without_scripts_is_told(served: Served, browser: Any) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(served.link)
    page.wait_for_url(served.origin + "/", timeout=5000)
    told = page.locator("body").inner_text().strip()
    assert told == "This page needs JavaScript. Switch it on for this address, then load the page again."
    context.close()


def test_a_browser_that_is_too_old_is_told(served: Served, browser: Any) -> None:
    context = browser.new_context()
    page = context.new_page()
    page.add_init_script("delete HTMLScriptElement.supports")
    page.goto(served.link)
    page.wait_for_url(served.origin + "/", timeout=5000)
    assert "This page needs a newer browser: " in page.locator("body").inner_text()
    context.close()


def test_another_page_can_neither_show_nor_ask_it(served: Served, browser: Any) -> None:
    context = browser.new_context()
    page = context.new_page()
    page.goto(served.link)
    page.get_by_text("nothing yet").wait_for(timeout=5000)
    page.route("http://localhost:9/", lambda route: route.fulfill(body="<p>another page</p>", content_type="text/html"))
    page.goto("http://localhost:9/")
    fetched = f"fetch('{served.origin}/', {{credentials: 'include'}}).then(() => 'answered', () => 'refused')"
    assert page.evaluate(fetched) == "refused"
    address = served.origin.replace("http", "ws") + SOCKET
    opened = f"""new Promise(done => {{
      const socket = new WebSocket('{address}');
      socket.onopen = () => done('open'); socket.onerror = () => done('refused');
    }})"""
    assert page.evaluate(opened) == "refused"
    context.close()
