"""Log messages of the libraries that serve pages, in one line each: a person at a terminal reads no traceback."""

import logging
import sys
from pathlib import Path
from time import monotonic
from traceback import extract_tb

LIBRARIES = ("nicegui", "asyncio", "engineio", "engineio.server", "socketio", "socketio.server", "layflat.pages")
MAX_LENGTH = 300  # characters of a line
PAUSE = 1.0  # in which the same place is told once, s
KEPT = 256  # places that are remembered


class OneLineHandler(logging.Handler):
    """Writes a record as one line on stderr: its message, and the kind and place of its error."""

    def __init__(self) -> None:
        super().__init__()
        self._told: dict[str, float] = {}

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record, unless the same was written just before."""
        line, now = one_line(record), monotonic()
        if now - self._told.get(line, -PAUSE) < PAUSE:
            return
        if len(self._told) >= KEPT:
            self._told.clear()
        self._told[line] = now
        print(f"layflat: {line}", file=sys.stderr, flush=True)  # noqa: T201


def one_line(record: logging.LogRecord) -> str:
    """Return a record as a line without characters that a terminal obeys."""
    text = record.getMessage().partition("\n")[0]
    error = record.exc_info[1] if record.exc_info else None
    if error is not None:
        at = extract_tb(error.__traceback__)
        where = f" at {Path(at[-1].filename).name}:{at[-1].lineno}" if at else ""
        kind = f"{type(error).__name__}: {error}".partition("\n")[0]
        text = f"{kind}{where}" if text == str(error).partition("\n")[0] else f"{text} ({kind}{where})"
    plain = "".join(char if char.isprintable() else " " for char in text)
    return plain if len(plain) <= MAX_LENGTH else plain[:MAX_LENGTH] + "..."


def log_in_lines() -> None:
    """Give every library that serves pages the handler that logs in lines, in place of its own."""
    handler = OneLineHandler()
    for name in LIBRARIES:
        logger = logging.getLogger(name)
        logger.handlers[:] = [handler]
        logger.propagate = False
