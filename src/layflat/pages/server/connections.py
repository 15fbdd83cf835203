"""A listening socket that keeps its connections few: strangers can't take the place of the people at the pages."""

import socket
from contextlib import suppress
from dataclasses import dataclass, field
from time import monotonic
from typing import Any

MOST = 64  # connections at a time
PATIENCE = 5.0  # s, until a connection has shown that it is of somebody who may see the pages

Peer = tuple[str, int]


@dataclass
class Connection:
    """One that is open."""

    socket: socket.socket
    since: float = field(default_factory=monotonic)  # s
    admitted: bool = False

    def end(self) -> None:
        """Let whoever serves it see its end, and close it."""
        with suppress(OSError):  # the other side went away
            self.socket.shutdown(socket.SHUT_RDWR)


class Listener(socket.socket):
    """A socket whose connections are at most `MOST`; those not admitted make room, the oldest first.

    It counts what it accepts, since with TLS a server hears of a connection only once hands have been shaken.

    Args:
        family: of its address.
    """

    def __init__(self, family: int) -> None:
        super().__init__(family, socket.SOCK_STREAM)
        self._open: dict[Peer, Connection] = {}
        self._accepted = False

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept a connection, at most one in a turn of the event loop: it is heard before others push it out.

        Raises:
            BlockingIOError: there is none, or this turn has had its one.
            ConnectionAbortedError: there was no room for it.
        """
        if self._accepted:
            self._accepted = False
            raise BlockingIOError
        accepted, peer = super().accept()
        self._accepted = True
        self._open = {peer: one for peer, one in self._open.items() if one.socket.fileno() >= 0}
        if len(self._open) >= MOST and not self._make_room():
            accepted.close()
            raise ConnectionAbortedError
        self._open[peer[:2]] = Connection(accepted)
        return accepted, peer

    def admit(self, peer: Peer) -> None:
        """Keep the connection of somebody who may see the pages."""
        if peer in self._open:
            self._open[peer].admitted = True

    def sweep(self) -> None:
        """End connections of strangers that have been open too long; to be called often."""
        now = monotonic()
        for one in self._open.values():
            if not one.admitted and now - one.since > PATIENCE:
                one.end()

    def _make_room(self) -> bool:
        oldest = next((peer for peer, one in self._open.items() if not one.admitted), None)
        if oldest is None:
            return False
        self._open.pop(oldest).end()
        return True
