"""Much of a page is built piece by piece, so that nothing else waits for more than one piece."""

import asyncio
from collections import deque
from time import monotonic

from nicegui import ui

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
