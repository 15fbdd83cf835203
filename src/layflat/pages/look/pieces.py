"""Building of long pages piece by piece, and refreshing in rounds: nothing waits for more than a piece of one page."""

import asyncio
import logging
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from time import monotonic

from nicegui import ui

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


PIECE = 0.003  # time after which a pause is due, s


class Queue:
    """Tasks that wait for their next piece; one goes on at a time, in order, and leaves as much time to all else.

    A renewal of a lease takes several turns of the event loop on its way, so these must not all be long.
    """

    def __init__(self) -> None:
        self._waiting: deque[asyncio.Future[None]] = deque()

    async def wait(self) -> None:
        """Wait for the next turn in which nobody else goes on."""
        loop = asyncio.get_running_loop()
        future: asyncio.Future[None] = loop.create_future()
        self._waiting.append(future)
        if len(self._waiting) == 1:
            loop.call_soon(self._release)
        await future

    def _release(self) -> None:
        future = self._waiting[0]
        if not future.done():  # its page may be gone
            future.set_result(None)
        # It goes on in the next turn; this is called in that turn as well, behind it.
        asyncio.get_running_loop().call_soon(self._rest, monotonic())

    def _rest(self, since: float) -> None:
        self._waiting.popleft()
        if self._waiting:
            asyncio.get_running_loop().call_later(monotonic() - since, self._release)


_queue = Queue()


async def arrived() -> bool:
    """Wait until the browser of the page that is built is there, and for a turn; return whether it still is then."""
    client = ui.context.client
    await client.connected()
    await _queue.wait()
    return not client.is_deleted


class Pieces:
    """Pauses between pieces of work in the event loop; make it within the page that is built."""

    def __init__(self) -> None:
        self._client, self._since = ui.context.client, monotonic()

    async def pause(self) -> None:
        """Yield to other handlers, if it is time for that; cancel the work where the page is gone."""
        if monotonic() - self._since >= PIECE:
            await self.turn()

    async def turn(self) -> None:
        """Yield to other handlers, as at the beginning of work that may begin at many places at once; see `pause`."""
        await _queue.wait()
        if self._client.is_deleted:
            raise asyncio.CancelledError
        self._since = monotonic()
