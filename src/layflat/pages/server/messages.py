"""Grammar of what a page sends by its socket: what does not follow it is ignored, and told in one line.

A frame is one of Engine.IO's with one of Socket.IO's inside, as the scripts of NiceGUI's pages write them:
`3` (alive), `1` and `41` (it ends), `40` (it begins), `42["event", {...}]` (what happened on the page).
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
TOGETHER = 4  # messages, of many that came at once, that share a turn of the event loop
MAX_TOLD = 3  # malformed messages of a connection that are told one by one
MAX_FRAME = 100_000  # characters of a message; a longer one, which takes long to be read, ends its connection
MAX_MALFORMED = 200  # of a connection, which then ends: no page of ours sends any
FOR_LOG = "is a line for a log, which nobody keeps"  # the one message of a page that is left out without a word
MAX_WORDS = 200  # characters of a value that names something
FIXED = frozenset({"1", "3", "40", "41"})
EVENT = re.compile(r"42\d{0,9}(\[.*)", re.DOTALL)


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= MAX_WORDS


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**53


def _is_number_text(value: Any) -> bool:
    return value is None or _is_count(value) or (isinstance(value, str) and value.isascii() and value[:15].isdigit())


def _are_arguments(value: Any) -> bool:
    return isinstance(value, list) and all(one is None or (isinstance(one, str) and _is_json(one)) for one in value)


def _is_json(text: str) -> bool:
    try:
        _read_json(text)
    except (ValueError, RecursionError):
        return False
    return True


def _read_json(text: str) -> Any:
    """Return what is written as JSON, as strictly as the parser of NiceGUI reads it.

    Raises:
        ValueError: it is no JSON, holds a number that is not finite, or half of a character.
        RecursionError: it is nested too deeply.
    """
    found = json.loads(text, parse_constant=_refuse, parse_float=_finite, parse_int=_whole)
    if "\\u" in text:
        json.dumps(found, ensure_ascii=False).encode()
    return found


def _refuse(constant: str) -> None:
    raise ValueError(constant)


def _finite(text: str) -> float:
    if not isfinite(value := float(text)):
        raise ValueError(text)
    return value


def _whole(text: str) -> int:
    _finite(text)
    return int(text)


Checks = Mapping[str, Callable[[Any], bool]]
"""Checks of the values that an event has to have, by their keys."""

Judge = Callable[[Mapping[str, Any]], str]
"""Returns what is wrong with the data of an event; "" where nothing is."""

EVENTS: Mapping[str, Checks] = {
    "event": {"client_id": _is_text, "id": _is_count, "listener_id": _is_text, "args": _are_arguments},
    "ack": {"client_id": _is_text, "next_message_id": _is_count},
    "javascript_response": {"client_id": _is_text, "request_id": _is_text},
    "handshake": {"client_id": _is_text, "tab_id": _is_text, "document_id": _is_text},
}
QUERY: Checks = {
    "EIO": "4".__eq__, "transport": "websocket".__eq__, "client_id": _is_text, "tab_id": _is_text,
    "document_id": _is_text, "next_message_id": _is_number_text, "implicit_handshake": _is_text,
}  # fmt: skip
OPTIONAL = frozenset({"client_id", "tab_id", "document_id", "next_message_id", "implicit_handshake"})


def problem_of(frame: str | bytes | None, judge: Judge = lambda _: "") -> str:
    """Return what is wrong with a frame; "" where it is one that a page may send.

    Args:
        frame: of Engine.IO.
        judge: returns what is wrong with the data of an event that follows the grammar; "" where nothing is.
    """
    if not isinstance(frame, str):
        return "is not text"
    if frame in FIXED or frame.startswith("40{"):
        return "" if frame in FIXED or _is_json(frame[2:]) else "does not begin a connection"
    found = EVENT.fullmatch(frame)
    if found is None:
        return "is no message of a page"
    try:
        event = _read_json(found[1])
    except (ValueError, RecursionError):
        return "is not JSON"
    return _problem_of_event(event, judge)


def _problem_of_event(event: list[Any], judge: Judge) -> str:
    if len(event) != 2 or not isinstance(event[0], str) or not isinstance(event[1], dict):
        return "is not one event with its data"
    name, data = event
    if name == "log":  # of the browser's scripts; anything may stand there
        return FOR_LOG
    if name not in EVENTS:
        return f"is an unknown event {name[:30]!r}"
    wrong = [key for key, fits in EVENTS[name].items() if not fits(data.get(key))]
    if not wrong and not _is_number_text(data.get("next_message_id")):
        wrong = ["next_message_id"]
    if wrong:
        return f"has no fitting {wrong[0]!r} in its event {name!r}"
    return judge(data) if name == "event" else ""


def problem_of_socket(scope: "Scope") -> str:
    """Return what is wrong with a request for a socket; "" where it is one that a page may open."""
    query = parse_qs(scope["query_string"].decode("latin-1"), keep_blank_values=True)
    if any(len(values) != 1 for values in query.values()):
        return "names a value twice"
    given = {key: values[0] for key, values in query.items()}
    wrong = [key for key, fits in QUERY.items() if not (fits(given[key]) if key in given else key in OPTIONAL)]
    if given.get("implicit_handshake") == "true":
        wrong += [key for key in OPTIONAL - {"implicit_handshake"} if key not in given]
    return f"has no fitting {wrong[0]!r}" if wrong else ""


def checked(receive: "Receive", judge: Judge) -> "Receive":
    """Return what receives the messages of a socket that a page may send; others are told, and ignored.

    Args:
        receive: receives all messages.
        judge: of the values in an event, as for `problem_of`.
    """
    malformed = count = 0

    async def receiving() -> "Message":
        nonlocal malformed, count
        while True:
            count += 1
            if count % TOGETHER == 0:
                await asyncio.sleep(0)
            message = await receive()
            if message["type"] != "websocket.receive":
                return message
            text = message.get("text")
            frame = text if text is not None else message.get("bytes")
            problem = "is too long" if frame is not None and len(frame) > MAX_FRAME else problem_of(frame, judge)
            if not problem:
                return message
            if problem == FOR_LOG:
                continue
            malformed += 1
            if malformed <= MAX_TOLD:
                more = "; further ones are not told" if malformed == MAX_TOLD else ""
                LOG.warning("a message that %s was ignored%s", problem, more)
            if malformed == MAX_MALFORMED or problem == "is too long":
                return {"type": "websocket.disconnect", "code": 1008}

    return receiving
