"""Much of a page is built piece by piece, so that nothing else waits for more than one piece."""

import asyncio
from time import monotonic

from nicegui import ui

PIECE = 0.005  # time after which a pause is due, s


class Pieces:
    """Pauses between pieces of work in the event loop; make it within the page that is built."""

    def __init__(self) -> None:
        self._client, self._since = ui.context.client, monotonic()

    async def pause(self) -> None:
        """Yield to other handlers, if it is time for that; cancel the work where the page is gone."""
        if monotonic() - self._since < PIECE:
            return
        await asyncio.sleep(0)
        if self._client.is_deleted:
            raise asyncio.CancelledError
        self._since = monotonic()
