"""A microcontroller's serial line with a device behind it, on a pseudo-terminal."""

from __future__ import annotations

import asyncio
import os
from pathlib import Path

from layflat.errors import OutputError
from layflat.machine.model import Machine
from layflat.rig.device.exchange import LATE, Device, Exchange
from layflat.rig.device.link import Spoil
from layflat.rig.wire import frames
from layflat.rig.wire.converter import WireError


class SerialStation:
    """Answers frames.

    Args:
        device: what is behind it.
        machine: its description.
    """

    def __init__(self, device: Device, machine: Machine) -> None:
        self._exchange = Exchange(device, machine)
        self._patience = machine.interface.serial.timeout
        self._decoder = frames.Decoder()
        self._link: Path | None = None

    def listen(self, link: Path | None = None) -> str:
        """Open a terminal and serve from now on.

        Args:
            link: a name under which it can be found too.

        Returns:
            The terminal's path, or that of the link.

        Raises:
            OutputError: the link can't be made.
        """
        self._near, self._terminal = os.openpty()
        import tty  # noqa: PLC0415  # not on every system

        tty.setraw(self._terminal)
        os.set_blocking(self._near, False)
        path = os.ttyname(self._terminal)
        if link is not None:
            try:
                if link.is_symlink():
                    link.unlink()
                link.symlink_to(path)
            except OSError as error:
                self.close()
                raise OutputError(
                    f"can't be made ({error.strerror})", where=str(link), right="give a name that is free"
                ) from None
            self._link = link
        asyncio.get_running_loop().add_reader(self._near, self._hear)
        return path if link is None else str(link)

    def close(self) -> None:
        """Serve no more, and leave nothing behind."""
        asyncio.get_running_loop().remove_reader(self._near)
        os.close(self._near)
        os.close(self._terminal)
        self._near = self._terminal = -1  # a late reply finds no file, rather than another one
        if self._link is not None:
            self._link.unlink(missing_ok=True)

    def _hear(self) -> None:
        try:
            data = os.read(self._near, 4096)
        except BlockingIOError:
            return
        for frame in self._decoder.feed(data):
            self._answer(frame)

    def _answer(self, frame: frames.Frame) -> None:
        link = self._exchange.device.link
        if link.silent:
            return
        spoil = link.next()
        behind = int(spoil is Spoil.SEQUENCE)
        if frame.kind == frames.ASK:
            kind, words = frames.TELL, self._exchange.identity()
        elif frame.kind == frames.COMMAND and self._obeyed(frame):
            kind, words = frames.READING, self._exchange.reading()
        else:
            return
        reply = frames.encode(kind, (frame.sequence - behind) & 0xFFFF, frames.as_bytes(words))
        if spoil is Spoil.CRC:
            # Another byte than it was, and no zero.
            middle = len(reply) // 2
            reply = reply[:middle] + bytes([reply[middle] % 255 + 1]) + reply[middle + 1 :]
        if spoil is Spoil.LATE:
            asyncio.get_running_loop().call_later(LATE * self._patience, self._send, reply)
        elif spoil is not Spoil.LOST:
            self._send(reply)

    def _obeyed(self, frame: frames.Frame) -> bool:
        try:
            return self._exchange.obey(frame.sequence, frames.as_words(frame.payload))
        except WireError:
            return False

    def _send(self, reply: bytes) -> None:
        try:
            os.write(self._near, reply)
        except OSError:
            # Full, since nobody reads, or closed since: as lost as a reply can be.
            return
