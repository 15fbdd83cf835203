"""Grammar of the messages that a page sends by its socket; others are ignored, and reported in one line.

A frame is one of Engine.IO with one of Socket.IO inside, as the scripts of NiceGUI's pages write them:
`3` (alive), `1` and `41` (end), `40` (begin), `42["event", {...}]` (event on the page).
"""

import asyncio
import json
import logging
import re
from collections.abc import Callable, Mapping
from math import isfinite
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs

if TYPE_CHECKING:
    from starlette.types import Message, Receive, Scope

LOG = logging.getLogger(__name__)
MESSAGES_PER_TURN = 4  # handled in one turn of the event loop, of many that came at once
MAX_REPORTED = 3  # malformed messages of a connection that are reported one by one
MAX_FRAME = 100_000  # characters of a message; a longer one takes long to parse and ends its connection
MAX_MALFORMED = 200  # malformed messages of a connection, which then ends: no page of ours sends any
FOR_LOG = "is a line for a log, which nobody keeps"  # problem of the one message that is ignored without a report
MAX_WORDS = 200  # characters of a value that is a name
CONTROL_FRAMES = frozenset({"1", "3", "40", "41"})
EVENT_FRAME = re.compile(r"42\d{0,9}(\[.*)", re.DOTALL)


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= MAX_WORDS


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**53


def _is_number_text(value: Any) -> bool:
    return value is None or _is_count(value) or (isinstance(value, str) and value.isascii() and value[:15].isdigit())


def _are_arguments(value: Any) -> bool:
    return isinstance(value, list) and all(one is None or (isinstance(one, str) and _is_json(one)) for one in value)


def _is_json(text: str) -> bool:
    """Return whether a text is JSON as `_read_json` accepts it."""
    try:
        _read_json(text)
    except (ValueError, RecursionError):
        return False
    return True


def _read_json(text: str) -> Any:
    """Parse JSON as strictly as the parser of NiceGUI does.

    Raises:
        ValueError: it is no JSON, or holds a number that is not finite or a lone surrogate.
        RecursionError: it is nested too deeply.
    """
    value = json.loads(text, parse_constant=_refuse, parse_float=_finite, parse_int=_whole)
    if "\\u" in text:
        json.dumps(value, ensure_ascii=False).encode()
    return value


def _refuse(constant: str) -> None:
    """Raise ValueError: a constant such as NaN is no JSON."""
    raise ValueError(constant)


def _finite(text: str) -> float:
    """Return the number that a text holds; raise ValueError if it is not finite."""
    if not isfinite(value := float(text)):
        raise ValueError(text)
    return value


def _whole(text: str) -> int:
    """Return the integer that a text holds; raise ValueError if it is too large for a float."""
    _finite(text)
    return int(text)


Checks = Mapping[str, Callable[[Any], bool]]
"""Checks of the values of an event or query, by their keys."""

Judge = Callable[[Mapping[str, Any]], str]
"""Function that returns the problem of an event's data; "" where there is none."""

EVENT_CHECKS: Mapping[str, Checks] = {
    "event": {"client_id": _is_text, "id": _is_count, "listener_id": _is_text, "args": _are_arguments},
    "ack": {"client_id": _is_text, "next_message_id": _is_count},
    "javascript_response": {"client_id": _is_text, "request_id": _is_text},
    "handshake": {"client_id": _is_text, "tab_id": _is_text, "document_id": _is_text},
}
QUERY_CHECKS: Checks = {
    "EIO": "4".__eq__, "transport": "websocket".__eq__, "client_id": _is_text, "tab_id": _is_text,
    "document_id": _is_text, "next_message_id": _is_number_text, "implicit_handshake": _is_text,
}  # fmt: skip
OPTIONAL_KEYS = frozenset({"client_id", "tab_id", "document_id", "next_message_id", "implicit_handshake"})


def frame_problem(frame: str | bytes | None, judge: Judge = lambda _: "") -> str:
    """Return the problem of a frame; "" where a page may send it.

    Args:
        frame: frame of Engine.IO.
        judge: returns the problem of the data of an event that follows the grammar; "" where there is none.
    """
    if not isinstance(frame, str):
        return "is not text"
    if frame in CONTROL_FRAMES or frame.startswith("40{"):
        return "" if frame in CONTROL_FRAMES or _is_json(frame[2:]) else "does not begin a connection"
    match = EVENT_FRAME.fullmatch(frame)
    if match is None:
        return "is no message of a page"
    try:
        event = _read_json(match[1])
    except (ValueError, RecursionError):
        return "is not JSON"
    return _problem_of_event(event, judge)


def _problem_of_event(event: list[Any], judge: Judge) -> str:
    """Return the reason to ignore an event of a page, empty for a valid one, `FOR_LOG` for one of the browser's log."""
    if len(event) != 2 or not isinstance(event[0], str) or not isinstance(event[1], dict):
        return "is not one event with its data"
    name, data = event
    if name == "log":  # of the browser's scripts; it may have any content
        return FOR_LOG
    if name not in EVENT_CHECKS:
        return f"is an unknown event {name[:30]!r}"
    wrong = [key for key, is_valid in EVENT_CHECKS[name].items() if not is_valid(data.get(key))]
    if not wrong and not _is_number_text(data.get("next_message_id")):
        wrong = ["next_message_id"]
    if wrong:
        return f"has no fitting {wrong[0]!r} in its event {name!r}"
    return judge(data) if name == "event" else ""


def socket_problem(scope: "Scope") -> str:
    """Return the problem of the query of a request for a socket; "" where a page may open it."""
    query = parse_qs(scope["query_string"].decode("latin-1"), keep_blank_values=True)
    if any(len(values) != 1 for values in query.values()):
        return "names a value twice"
    arguments = {key: values[0] for key, values in query.items()}
    wrong = [
        key
        for key, is_valid in QUERY_CHECKS.items()
        if not (is_valid(arguments[key]) if key in arguments else key in OPTIONAL_KEYS)
    ]
    if arguments.get("implicit_handshake") == "true":
        wrong += [key for key in OPTIONAL_KEYS - {"implicit_handshake"} if key not in arguments]
    return f"has no fitting {wrong[0]!r}" if wrong else ""


def filter_messages(receive: "Receive", judge: Judge) -> "Receive":
    """Return a `receive` that passes only messages that a page may send; others are logged and ignored.

    The first `MAX_REPORTED` of a connection are logged. A message that is too long, or the malformed one with number
    `MAX_MALFORMED`, ends the connection: "websocket.disconnect" is received in its place.

    Args:
        receive: receives all messages.
        judge: returns the problem of the values in an event, as for `frame_problem`.
    """
    malformed = count = 0

    async def receiving() -> "Message":
        """Receive the next message that a page may send, or a disconnection."""
        nonlocal malformed, count
        while True:
            count += 1
            if count % MESSAGES_PER_TURN == 0:
                await asyncio.sleep(0)
            message = await receive()
            if message["type"] != "websocket.receive":
                return message
            text = message.get("text")
            frame = text if text is not None else message.get("bytes")
            problem = "is too long" if frame is not None and len(frame) > MAX_FRAME else frame_problem(frame, judge)
            if not problem:
                return message
            if problem == FOR_LOG:
                continue
            malformed += 1
            if malformed <= MAX_REPORTED:
                more = "; further ones are not reported" if malformed == MAX_REPORTED else ""
                LOG.warning("a message that %s was ignored%s", problem, more)
            if malformed == MAX_MALFORMED or problem == "is too long":
                return {"type": "websocket.disconnect", "code": 1008}

    return receiving
