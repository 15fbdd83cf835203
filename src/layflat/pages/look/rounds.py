"""Refreshing of pages: the one that drives ten times a second, all others as often as time allows."""

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from time import monotonic

LOG = logging.getLogger(__name__)
EVERY = 0.1  # between two pictures for the page that drives, s
OTHERS = 0.03  # time of a round after which pages that look on wait for the next one, s
ANSWERED = 0.02  # time in which a rig obeys, s
REST = 0.02  # between two rounds, at least, s


class Rounds:
    """Shows pages what is so, one in each turn of the event loop; ends with the last page.

    Args:
        drives: whether the page of a key drives something, and so is shown first.
    """

    def __init__(self, drives: Callable[[str], bool] = lambda _: False) -> None:
        self._drives = drives
        self._pages: dict[str, Callable[[], object]] = {}  # the one that was shown longest ago stands first
        self._task: asyncio.Task[None] | None = None
        self._hurry = asyncio.Event()

    def add(self, key: str, show: Callable[[], object]) -> None:
        """Show a page what is so, from now on; to be called in the event loop."""
        self._pages[key] = show
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._go())

    def remove(self, key: str) -> None:
        """Show a page nothing more."""
        self._pages.pop(key, None)

    def hurry(self) -> None:
        """Show pages soon what somebody has just asked for."""
        asyncio.get_running_loop().call_later(ANSWERED, self._hurry.set)

    async def _go(self) -> None:
        while self._pages:
            begun = monotonic()
            for key in sorted(self._pages, key=lambda one: not self._drives(one)):
                if not self._drives(key) and monotonic() - begun > OTHERS:
                    break
                self._show(key)
                await asyncio.sleep(0)
            self._hurry.clear()
            with suppress(TimeoutError):
                await asyncio.wait_for(self._hurry.wait(), max(REST, begun + EVERY - monotonic()))

    def _show(self, key: str) -> None:
        show = self._pages.pop(key, None)
        if show is None:  # it went meanwhile
            return
        self._pages[key] = show
        try:
            show()
        except Exception:  # one page that can't be shown must not stop the others
            LOG.exception("a page can't be shown what is so")
