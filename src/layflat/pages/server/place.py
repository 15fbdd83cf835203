"""Endpoint of the pages: host, port and certificate; without a certificate only this computer reaches it.

The listening socket limits its connections: strangers can't displace the people at the pages.
"""

import errno
import os
import socket
import ssl
from contextlib import suppress
from dataclasses import dataclass, field
from ipaddress import ip_address
from pathlib import Path
from time import monotonic
from typing import Any

from layflat.errors import InputError

MAX_CONNECTIONS = 64  # open at a time
ADMISSION_TIMEOUT = 5.0  # for the first admitted request of a connection, s

Peer = tuple[str, int]
LOOPBACK_ADDRESS = "127.0.0.1"
USUAL_PORTS = {"http": 80, "https": 443}


@dataclass
class Connection:
    """Open connection of a listener."""

    socket: socket.socket
    since: float = field(default_factory=monotonic)  # s
    is_admitted: bool = False

    def end(self) -> None:
        """Shut the connection down, so that its server notices."""
        with suppress(OSError):  # the other side went away
            self.socket.shutdown(socket.SHUT_RDWR)


class Listener(socket.socket):
    """Listening socket with at most `MAX_CONNECTIONS`; those not admitted make room, the oldest first.

    It counts accepted sockets itself, since with TLS a server learns of a connection only after the handshake.

    Args:
        family: address family of the socket.
    """

    def __init__(self, family: int) -> None:
        super().__init__(family, socket.SOCK_STREAM)
        self._open: dict[Peer, Connection] = {}
        self._accepted = False

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept a connection, at most one in a turn of the event loop, so that it is read before others displace it.

        Raises:
            BlockingIOError: there is none, or one was accepted in this turn.
            ConnectionAbortedError: all `MAX_CONNECTIONS` are admitted; it was closed.
        """
        if self._accepted:
            self._accepted = False
            raise BlockingIOError
        accepted, peer = super().accept()
        self._accepted = True
        self._open = {peer: connection for peer, connection in self._open.items() if connection.socket.fileno() >= 0}
        if len(self._open) >= MAX_CONNECTIONS and not self._make_room():
            accepted.close()
            raise ConnectionAbortedError
        self._open[peer[:2]] = Connection(accepted)
        return accepted, peer

    def admit(self, peer: Peer) -> None:
        """Mark the connection of a peer as admitted, if it is open: it is not ended to make room, nor by `sweep`."""
        if peer in self._open:
            self._open[peer].is_admitted = True

    def sweep(self) -> None:
        """End connections that were not admitted within `ADMISSION_TIMEOUT`; to be called often."""
        now = monotonic()
        for connection in self._open.values():
            if not connection.is_admitted and now - connection.since > ADMISSION_TIMEOUT:
                connection.end()

    def _make_room(self) -> bool:
        """Close the oldest connection that was not admitted; return False if there is none."""
        oldest = next((peer for peer, connection in self._open.items() if not connection.is_admitted), None)
        if oldest is None:
            return False
        self._open.pop(oldest).end()
        return True


@dataclass(frozen=True)
class Endpoint:
    """Endpoint at which pages are served; other computers reach it only with a certificate.

    Args:
        host: address or name of this computer; 127.0.0.1, ::1 and localhost are reached from this computer alone.
        port: 0 for any that is free.
        certificate: PEM file, for TLS.
        key: key of the certificate, PEM file, without a password.

    Raises:
        InputError: other computers would reach the host without a certificate, the host is a wildcard such as 0.0.0.0,
            or certificate and key can't be used or one of them is missing.
    """

    host: str = LOOPBACK_ADDRESS
    port: int = 8080
    certificate: Path | None = None
    key: Path | None = None

    def __post_init__(self) -> None:
        """Raise InputError for a host, certificate or key that can't be used, see the class."""
        if self.certificate is not None and self.key is not None:
            _check_pair(self.certificate, self.key)
        elif self.certificate is not None or self.key is not None:
            missing = "key" if self.key is None else "certificate"
            raise InputError("is missing", where=missing, right="give both a certificate and its key, or neither")
        elif not self.is_loopback:
            right = f"give a certificate and its key, or {LOOPBACK_ADDRESS} for this computer alone"
            raise InputError(f"{self.host!r} can be reached from other computers", where="host", right=right)
        if self.host in ("", "*", "0.0.0.0", "::"):
            right = "give the address or name by which others reach this computer"
            raise InputError(f"{self.host!r} is not an address that a browser can open", where="host", right=right)

    @property
    def is_loopback(self) -> bool:
        """True if the host is localhost or a loopback address."""
        if self.host.lower() == "localhost":
            return True
        try:
            return ip_address(self.host).is_loopback
        except ValueError:
            return False

    @property
    def scheme(self) -> str:
        """The scheme of its addresses: https, or http."""
        return "http" if self.certificate is None else "https"

    def listen(self) -> Listener:
        """Return a non-blocking socket that listens at the endpoint.

        Raises:
            InputError: the host is not this computer, or the port is in use.
        """
        try:
            family, *_, address = socket.getaddrinfo(self._address, None, type=socket.SOCK_STREAM)[0]
            listener = Listener(family)
        except (OSError, UnicodeError) as error:
            raise self._not_here(error) from None
        try:
            if os.name == "posix":  # elsewhere it would let another program take the port over
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind((address[0], self.port, *address[2:]))
            listener.listen()
        except (OSError, OverflowError) as error:
            listener.close()
            if getattr(error, "errno", None) == errno.EADDRNOTAVAIL:
                raise self._not_here(error) from None
            right = "give another, or 0 for any that is free"
            raise InputError(f"port {self.port} can't be had ({_reason(error)})", where="port", right=right) from None
        listener.setblocking(False)
        return listener

    def address(self, port: int) -> str:
        """Return the address of the pages at a port, without a slash at its end."""
        return f"{self.scheme}://{_url_host(self._address)}:{port}"

    def hosts(self, port: int) -> frozenset[str]:
        """Return the hosts that a request for the pages at a port may name, in lower case, as "host:port".

        At the usual port of the scheme, a host may be named without the port, too.
        """
        names = {_url_host(self._address)}
        if self.is_loopback:
            names |= {_url_host(self.host), LOOPBACK_ADDRESS, "localhost", "[::1]"}
        with_port = {f"{name}:{port}" for name in names}
        return frozenset(with_port | names if port == USUAL_PORTS[self.scheme] else with_port)

    @property
    def _address(self) -> str:
        # With the name a browser might try ::1 first, where another person's program may wait for the token.
        return LOOPBACK_ADDRESS if self.host.lower() == "localhost" else self.host

    def _not_here(self, error: Exception) -> InputError:
        """Return the error for a host that is no address of this computer."""
        what = f"{self.host!r} can't be had ({_reason(error)})"
        return InputError(what, where="host", right="give an address of this computer, or its name")


def _url_host(host: str) -> str:
    """Return a host as it is written in a URL: lower case, IPv6 in brackets."""
    try:
        address = ip_address(host)
    except ValueError:
        return host.lower()
    return f"[{address}]" if address.version == 6 else str(address)


def _check_pair(certificate: Path, key: Path) -> None:
    """Check that a certificate and its key can be used; raise InputError otherwise."""
    for name, path in (("certificate", certificate), ("key", key)):
        if not path.is_file():
            raise InputError("no such file", where=str(path), right=f"give the path of the {name}, PEM")
    try:
        # With an empty password an encrypted key is refused, without a question at the terminal.
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, key, password="")
    except OSError as error:
        right = "give a certificate and its key, PEM, the key without a password"
        what = f"can't be used with the key {str(key)!r} ({_reason(error)})"
        raise InputError(what, where=str(certificate), right=right) from None


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
