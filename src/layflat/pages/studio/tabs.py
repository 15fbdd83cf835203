"""Sessions of browser tabs: a page that is loaded again, or comes back after a sleep, finds its design as it was."""

import asyncio
from collections import OrderedDict
from collections.abc import Callable

from nicegui import Client

from layflat.pages.studio.session import Session

MOST = 20  # sessions that are kept of tabs that are closed
PATIENCE = 1.0  # that the page before has to go, where a page is loaded again, s
POLLS = 20


class Tabs:
    """Sessions by tab."""

    def __init__(self) -> None:
        self._known: OrderedDict[str, tuple[Session, Client]] = OrderedDict()

    async def session(self, client: Client, begin: Callable[[], Session]) -> Session:
        """Return the session of a connected client's tab; one that another page shows is not shared.

        A tab that was duplicated has the name of the first, whose page does not go.

        Args:
            client: of the page.
            begin: begins a session.

        Raises:
            LayflatError: as `begin`.
        """
        tab = client.tab_id or client.id
        session, before = self._known.get(tab, (None, None))
        for _ in range(POLLS):
            if before is None or not before.has_socket_connection:
                break
            await asyncio.sleep(PATIENCE / POLLS)
        if session is None or before is None or before.has_socket_connection:
            session = begin()
        session.leave()
        self._known[tab] = (session, client)
        self._known.move_to_end(tab)
        while len(self._known) > MOST:
            self._known.popitem(last=False)
        return session
