"""Pages that share the event loop: work in short pieces, and rounds of refreshes.

Nothing waits for more than one piece. The page that drives is refreshed ten times a second, all others as often as time
allows.
"""

import asyncio
import logging
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from time import monotonic

from nicegui import ui

LOG = logging.getLogger(__name__)
MAX_PIECE_TIME = 0.003  # of work without a pause, s
REFRESH_PERIOD = 0.1  # of the page that drives, s
MAX_ROUND_TIME = 0.03  # of a round, s: pages that look on wait for the next one after it
RESPONSE_TIME = 0.02  # in which a rig obeys a request, s: then pages show the effect
MIN_ROUND_GAP = 0.02  # between two rounds, s


class TurnQueue:
    """Queue of tasks that wait for their next piece of work: one at a time, in order.

    Each piece is followed by a pause of the same duration, which is left to all else.

    A renewal of a lease takes several turns of the event loop, so these must not all be long.
    """

    def __init__(self) -> None:
        self._waiting: deque[asyncio.Future[None]] = deque()

    async def wait(self) -> None:
        """Wait until it is this task's turn."""
        loop = asyncio.get_running_loop()
        future: asyncio.Future[None] = loop.create_future()
        self._waiting.append(future)
        if len(self._waiting) == 1:
            loop.call_soon(self._resume_first)
        await future

    def _resume_first(self) -> None:
        """Resume the first task; `_rest` follows behind it in the next turn of the loop."""
        future = self._waiting[0]
        if not future.done():  # its page may be closed
            future.set_result(None)
        # It goes on in the next turn; this is called in that turn as well, behind it.
        asyncio.get_running_loop().call_soon(self._rest, monotonic())

    def _rest(self, since: float) -> None:
        """Remove the first task, whose piece began at `since` (s), and resume the next after as long a pause."""
        self._waiting.popleft()
        if self._waiting:
            asyncio.get_running_loop().call_later(monotonic() - since, self._resume_first)


_queue = TurnQueue()


async def wait_for_browser() -> bool:
    """Wait until a browser has connected to the page that is built, then for a turn; return whether the page exists."""
    client = ui.context.client
    await client.connected()
    await _queue.wait()
    return not client.is_deleted


class Pieces:
    """Pieces of work in the event loop, with pauses between them; make it within the page that is built."""

    def __init__(self) -> None:
        self._client, self._since = ui.context.client, monotonic()

    async def pause(self) -> None:
        """Yield to other handlers if `MAX_PIECE_TIME` has passed.

        Raises:
            asyncio.CancelledError: the page was closed.
        """
        if monotonic() - self._since >= MAX_PIECE_TIME:
            await self.turn()

    async def turn(self) -> None:
        """Yield to other handlers in any case, as before work that may start on many pages at once; see `pause`."""
        await _queue.wait()
        if self._client.is_deleted:
            raise asyncio.CancelledError
        self._since = monotonic()


class Rounds:
    """Rounds of refreshes of all open pages, one page in each turn of the event loop; they end with the last page.

    Args:
        drives: returns whether the page of a key drives something, and so is refreshed first.
    """

    def __init__(self, drives: Callable[[str], bool] = lambda _: False) -> None:
        """Begin without pages; the first one starts the rounds."""
        self._drives = drives
        self._pages: dict[str, Callable[[], object]] = {}  # the page refreshed longest ago first
        self._task: asyncio.Task[None] | None = None
        self._hurry = asyncio.Event()

    def add(self, key: str, show: Callable[[], object]) -> None:
        """Refresh a page in every round from now on, by calling `show`; to be called in the event loop."""
        self._pages[key] = show
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._repeat_rounds())

    def remove(self, key: str) -> None:
        """Refresh a page no more."""
        self._pages.pop(key, None)

    def hurry(self) -> None:
        """Begin the next round after `RESPONSE_TIME`, so that pages soon show the effect of a request."""
        asyncio.get_running_loop().call_later(RESPONSE_TIME, self._hurry.set)

    async def _repeat_rounds(self) -> None:
        """Refresh the open pages every `REFRESH_PERIOD`, those that drive first, until none is left.

        The others are skipped in a round that takes longer than `MAX_ROUND_TIME`.
        """
        while self._pages:
            begun = monotonic()
            for key in sorted(self._pages, key=lambda one: not self._drives(one)):
                if not self._drives(key) and monotonic() - begun > MAX_ROUND_TIME:
                    break
                self._refresh_page(key)
                await asyncio.sleep(0)
            self._hurry.clear()
            with suppress(TimeoutError):
                await asyncio.wait_for(self._hurry.wait(), max(MIN_ROUND_GAP, begun + REFRESH_PERIOD - monotonic()))

    def _refresh_page(self, key: str) -> None:
        """Refresh a page, if it is still open, and move it to the end of the order; its errors are logged."""
        show = self._pages.pop(key, None)
        if show is None:  # it was closed meanwhile
            return
        self._pages[key] = show
        try:
            show()
        except Exception:  # one page that can't be shown must not stop the others
            LOG.exception("a page can't be refreshed")
