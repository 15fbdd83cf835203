"""pymodbus's client, as prompt as a control cycle needs it."""

from __future__ import annotations

import socket
import time
from select import select

from pymodbus.client import ModbusTcpClient
from pymodbus.exceptions import ConnectionException

LARGEST = 4096
"""Bytes taken at once."""


class PromptClient(ModbusTcpClient):
    """A client that keeps one deadline for a whole reply, and forgets stale bytes before it asks.

    pymodbus's own `recv` waits anew for every piece. Here a reply that trickles is as late as one that is lost. After
    either the connection stays: the stale reply is dropped when it comes, by its transaction's number at the latest.

    Args:
        host: a number, such as "127.0.0.1".
        port: of TCP.
        patience: after which a reply is lost, s.
    """

    def __init__(self, host: str, port: int, patience: float) -> None:
        super().__init__(host, port=port, timeout=patience, retries=0)
        self.patience = patience
        self.waited_in_vain = False
        self._deadline = 0.0

    def open(self, patience: float) -> None:
        """Connect.

        Raises:
            OSError: nobody takes the connection within `patience`.
        """
        self.socket = socket.create_connection((self.comm_params.host, self.comm_params.port), timeout=patience)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.setblocking(False)

    def connect(self) -> bool:
        """Connect anew if the device has hung up, as promptly as everything else."""
        if self.socket is None:
            try:
                self.open(self.patience)
            except OSError:
                return False
        return True

    def send(self, request: bytes, addr: tuple[str, int] | None = None) -> int:  # noqa: ARG002  (as pymodbus calls it)
        """Send a whole request; what had come before it is stale."""
        if self.socket is None:
            raise ConnectionException(str(self))
        try:
            while self._take():
                pass
            sent = self.socket.send(request)
        except OSError:
            self.close()
            raise ConnectionException(str(self)) from None
        self._deadline = time.monotonic() + self.patience
        self.waited_in_vain = False
        return sent

    def recv(self, size: int | None) -> bytes:  # noqa: ARG002  (what there is; the framer knows how much it takes)
        """What has come by the deadline; nothing if nothing has."""
        left = self._deadline - time.monotonic()
        if self.socket is None or left <= 0 or not select([self.socket], [], [], left)[0]:
            self.waited_in_vain = True
            return b""
        try:
            return self._take()
        except OSError:
            self.close()
            raise ConnectionException(str(self)) from None

    def _take(self) -> bytes:
        assert self.socket is not None
        try:
            data = self.socket.recv(LARGEST)
        except BlockingIOError:
            return b""
        if not data:
            raise ConnectionResetError
        return data
