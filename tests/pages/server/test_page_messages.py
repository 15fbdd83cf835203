"""Messages and requests that no page of ours makes are ignored or refused, each in a line at most."""

import json
import logging
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.exceptions import InvalidStatus

from layflat.pages.server.logs import MAX_LENGTH, format_record
from layflat.pages.server.messages import FOR_LOG, frame_problem
from tests.pages.server.serving import Served, serving
from tests.pages.visitor import Visitor

DEEP = "[" * 100_000
OF_ENGINE = ["", "x", "9", "0{}", "2", "2probe", "5", "4", "\0", "é" * 100, "1x", "4" + "2" * 1000]
OF_SOCKET = ["4x", "43", "44", "45", "451-[]", "46", "4/ns,", "40/other,", "40{", "40[1]", "420[", "429999999999999[]"]
OF_EVENTS = ["42", "42{}", "42[", "42[]", "42[1]", '42["event"]', '42["event",1]', '42["event",{},{}]', "42" + DEEP,
             '42["nope",{}]', '42["disconnect",{}]', '42["__class__",{}]', '42["event",{"a":NaN}]']  # fmt: skip
WRONG: dict[str, list[dict[str, Any]]] = {
    "event": [
        {}, {"client_id": 1}, {"id": "5"}, {"id": True}, {"id": -1}, {"id": 1e99}, {"listener_id": None}, {"args": 5},
        {"args": ["{"]}, {"args": [5]}, {"args": [DEEP]}, {"args": ["NaN"]}, {"args": {}},
    ],
    "ack": [{}, {"next_message_id": "a"}, {"next_message_id": []}, {"next_message_id": None}],
    "javascript_response": [{}, {"request_id": {}}],
    "handshake": [{}, {"tab_id": None}, {"document_id": ["x"]}, {"next_message_id": "x"}, {"client_id": "x" * 500}],
}  # fmt: skip
RIGHT: dict[str, dict[str, Any]] = {
    "event": {"client_id": "c", "id": 5, "listener_id": "x", "args": ["1", None, '{"a": [1.5]}']},
    "ack": {"client_id": "c", "next_message_id": 7},
    "javascript_response": {"client_id": "c", "request_id": "r", "result": [1]},
    "handshake": {"client_id": "c", "tab_id": "t", "document_id": "d", "old_tab_id": None, "next_message_id": 3},
}


def frame(name: str, data: Any) -> str:
    return "42" + json.dumps([name, data])


OF_DATA = [frame(name, RIGHT[name] | one if one else {}) for name, each in WRONG.items() for one in each]
MALFORMED = [*OF_ENGINE, *OF_SOCKET, *OF_EVENTS, *OF_DATA]
JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)
FRAMES = st.one_of(
    st.text(), st.binary(), st.text().map("42[".__add__), JSON.map(lambda one: frame("event", one)),
    st.tuples(st.sampled_from([*RIGHT, "log"]), JSON).map(lambda one: frame(*one)),
)  # fmt: skip


@pytest.mark.parametrize("text", MALFORMED, ids=range(len(MALFORMED)))
def test_what_no_page_sends_is_told_from_what_pages_send(text: str) -> None:
    assert frame_problem(text)


@pytest.mark.parametrize("text", ["1", "3", "40", '40{"token":"x"}', "41", *(frame(*one) for one in RIGHT.items())])
def test_what_pages_send_passes(text: str) -> None:
    assert frame_problem(text) == ""
    assert frame_problem(text.replace("42[", "4217[")) == ""


def test_what_is_no_text_and_what_is_for_a_log_does_not_pass() -> None:
    assert frame_problem(b"\xff") == frame_problem(None) == "is not text"
    assert frame_problem(frame("log", {"client_id": "c", "level": "error", "message": "\x1b[31m"})) == FOR_LOG


@given(FRAMES)
def test_any_frame_is_judged_without_an_error(text: str | bytes) -> None:
    assert isinstance(frame_problem(text), str)


def test_a_page_goes_on_while_others_send_what_they_should_not(tmp_path: Path) -> None:
    complaints: list[str] = []
    with serving(tmp_path, complaints=complaints) as served, Visitor(served.link) as visitor:
        visitor.until(lambda: any(visitor.named("Greet")))
        frames: list[str | bytes] = [*MALFORMED, b"\x04\0", b"\xff"]
        for text in frames:
            with visitor.socket({"client_id": visitor.client}) as line:
                line.send(text)
        (number, one), _ = visitor.find("Greet", "click")
        for listener in ("unknown", one["events"][0]["listener_id"]):
            data = {"client_id": visitor.client, "id": number, "listener_id": listener, "args": ["[1]", "{}"]}
            visitor.line.send(frame("event", data))
        refused_sockets(visitor)
        refused_requests(served)
        visitor.press("Greet")
        visitor.until(lambda: "hello from Python" in visitor.text)
    assert complaints
    assert all(line.startswith("layflat: ") and len(line) < 2 * MAX_LENGTH for line in complaints), complaints


def refused_sockets(visitor: Visitor) -> None:
    """Sockets that no page opens are refused."""
    whole = {"client_id": visitor.client, "implicit_handshake": "true", "tab_id": "t", "document_id": "d"}
    wrong = [{"EIO": "banana"}, {"transport": "polling"}, whole, whole | {"next_message_id": "abc"},
             {"client_id": "x" * 300}, {"implicit_handshake": "true"}]  # fmt: skip
    for query in wrong:
        with pytest.raises(InvalidStatus) as refused:
            visitor.socket(query)
        assert refused.value.response.status_code == 400


def refused_requests(served: Served) -> None:
    """Requests that no page makes get an answer."""
    requests: list[tuple[str, str, dict[str, str], int]] = [
        ("/_nicegui_ws/socket.io/?EIO=4&transport=polling", "GET", {}, 400),
        ("/_nicegui_ws/socket.io/?EIO=4&transport=polling&sid=x", "POST", {}, 400),
        ("/_nicegui/3.18.0/components/x", "GET", {}, 404),
        ("/_nicegui/3.18.0/components/%00", "GET", {}, 400),
        ("/" + "a/" * 2000, "GET", {}, 404),
        ("/?token=%ff", "GET", {}, 403),
        ("/", "GET", {"Accept": "text/markdown"}, 200),
        ("/", "GET", {"X-Forwarded-Prefix": '"><'}, 200),
        ("/favicon.ico", "GET", {"Range": "bytes=9-1"}, 400),
        ("/body", "POST", {"Content-Length": "-1"}, 400),
        ("/body", "POST", {"Transfer-Encoding": "banana"}, 400),
    ]
    for target, method, headers, status in requests:
        assert served.ask(target, served.allowed() | headers, method).status == status, (target, headers)


def test_an_error_of_a_library_is_one_line_that_no_terminal_obeys() -> None:
    try:
        raise ValueError("wrong\nin two lines \x1b[31m")
    except ValueError as error:
        record = logging.LogRecord("nicegui", 40, "x.py", 1, error, None, (type(error), error, error.__traceback__))
    line = format_record(record)
    assert line.startswith("ValueError: wrong at test_page_messages.py:")
    assert line.isprintable()
    record = logging.LogRecord("asyncio", 40, "x.py", 1, "Task \x1b failed\nfuture: ...%s", ("a" * 999,), None)
    assert format_record(record) == "Task   failed"
