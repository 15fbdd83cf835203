"""Where pages are served: the address, the port, and the certificate that any but this computer asks for."""

import errno
import os
import socket
import ssl
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path

from layflat.errors import InputError
from layflat.pages.server.connections import Listener

HERE = "127.0.0.1"
USUAL_PORTS = {"http": 80, "https": 443}


@dataclass(frozen=True)
class Place:
    """Where pages are served; other computers reach them only under a certificate.

    Args:
        host: an address of this computer, or its name; 127.0.0.1, ::1 and localhost are for people at it alone.
        port: 0: any that is free.
        certificate: PEM file, for TLS.
        key: of the certificate, PEM file, without a password.

    Raises:
        InputError: others would reach the host and there is no certificate, or certificate and key can't be used.
    """

    host: str = HERE
    port: int = 8080
    certificate: Path | None = None
    key: Path | None = None

    def __post_init__(self) -> None:
        if self.certificate is not None and self.key is not None:
            _check_pair(self.certificate, self.key)
        elif self.certificate is not None or self.key is not None:
            missing = "key" if self.key is None else "certificate"
            raise InputError("is missing", where=missing, right="give both a certificate and its key, or neither")
        elif not self.alone:
            right = f"give a certificate and its key, or {HERE} for this computer alone"
            raise InputError(f"{self.host!r} can be reached from other computers", where="host", right=right)
        if self.host in ("", "*", "0.0.0.0", "::"):
            right = "give the address or name by which others reach this computer"
            raise InputError(f"{self.host!r} is not an address that a browser can open", where="host", right=right)

    @property
    def alone(self) -> bool:
        """Whether only this computer reaches it."""
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
        """Return a socket that listens there.

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
        return f"{self.scheme}://{_shown(self._address)}:{port}"

    def hosts(self, port: int) -> frozenset[str]:
        """Return what a request for the pages at a port may name as its host."""
        names = {_shown(self._address)}
        if self.alone:
            names |= {_shown(self.host), HERE, "localhost", "[::1]"}
        with_port = {f"{name}:{port}" for name in names}
        return frozenset(with_port | names if port == USUAL_PORTS[self.scheme] else with_port)

    @property
    def _address(self) -> str:
        # With the name a browser might try ::1 first, where another person's program may wait for the token.
        return HERE if self.host.lower() == "localhost" else self.host

    def _not_here(self, error: Exception) -> InputError:
        what = f"{self.host!r} can't be had ({_reason(error)})"
        return InputError(what, where="host", right="give an address of this computer, or its name")


def _shown(host: str) -> str:
    """Return a host as it stands in addresses of pages."""
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
        # With an empty password one that asks for it is refused; nobody is asked.
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, key, password="")
    except OSError as error:
        right = "give a certificate and its key, PEM, the key without a password"
        what = f"can't be used with the key {str(key)!r} ({_reason(error)})"
        raise InputError(what, where=str(certificate), right=right) from None


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
