"""What a page sends to keep its operator's lease alive, and to jog; see minder.js."""

from collections.abc import Callable
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

Jogs = list[tuple[int, int]]
"""Joints that are being jogged, by their numbers, and which way: -1 or 1."""


class Minder(Element, component="minder.js"):
    """An element that shows nothing, and minds the rig as long as its page is alive and in view."""

    def __init__(self, renewed: Callable[[int, Jogs], object], stopped: Callable[[], object]) -> None:
        """Take what is called with the last beat seen and what is jogged, and what is called for Escape."""
        super().__init__()
        self.on("renew", lambda event: renewed(*_read(event)))
        self.on("stop", lambda _: stopped())

    def beat(self, number: int) -> None:
        """Let the page see a beat."""
        self.run_method("beat", number)


def _read(event: GenericEventArguments) -> tuple[int, Jogs]:
    """Return what a renewal says; what makes no sense jogs nothing."""
    args: Any = event.args
    try:
        jogs = [(int(joint), 1 if int(way) > 0 else -1) for joint, way in (one.split(":") for one in args["jogs"])]
        return int(args["beat"]), jogs
    except (TypeError, KeyError, ValueError, AttributeError):
        return 0, []
