"""A Modbus station that answers each request with bytes put together by hand."""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections.abc import Callable
from contextlib import suppress

from layflat.rig.wire import Identity
from tests.rig.devices import ARM, patient

HASTY = patient(ARM, 0.03)
READING = [0x0004, 1638, 2048, 2048, 1000, 3000]
"""E-stop pressed, supply, both joints' angle and pressure."""

Reply = Callable[[bytes], bytes]


def good(request: bytes) -> bytes:
    """The right reply to function 3 and 23."""
    number, _, _, unit, function = struct.unpack_from(">HHHBB", request)
    words = Identity.for_machine(ARM).words() if function == 3 else [*struct.unpack_from(">H", request, 17), *READING]
    body = struct.pack(f">BBB{len(words)}H", unit, function, 2 * len(words), *words)
    return struct.pack(">HHH", number, 0, len(body)) + body


class Server:
    """Answers each request with what `reply` makes of it."""

    def __init__(self) -> None:
        self.reply: Reply = good
        self.first = 1000
        """Bytes that are sent at once; the others follow."""
        self.requests: list[bytes] = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                connection, _ = self._listener.accept()
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                with connection, suppress(OSError):
                    while request := connection.recv(1000):
                        self.requests.append(request)
                        reply = self.reply(request)
                        connection.sendall(reply[: self.first])
                        if reply[self.first :]:
                            time.sleep(2e-3)
                            connection.sendall(reply[self.first :])

    def close(self) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
