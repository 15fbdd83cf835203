"""Serial line of a microcontroller with a device behind it, on a pseudo-terminal."""

import asyncio
import os
from contextlib import suppress
from pathlib import Path

from layflat.errors import OutputError
from layflat.machine.model import Machine
from layflat.rig import frames
from layflat.rig.device.exchange import DeviceStation
from layflat.rig.device.virtual import ReplyFault, VirtualDevice
from layflat.rig.wire import WireError


class SerialStation(DeviceStation):
    """Station that answers frames on a pseudo-terminal."""

    def __init__(self, device: VirtualDevice, machine: Machine) -> None:
        super().__init__(device, machine, machine.interface.serial.timeout)
        self._decoder = frames.Decoder()
        self._link: Path | None = None

    def listen(self, link: Path | None = None) -> str:
        """Open a terminal and start to serve; return its path, or that of the link to it, which replaces another link.

        Raises:
            OutputError: the link can't be created.
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
                what = f"can't be made ({error.strerror})"
                raise OutputError(what, where=str(link), right="give a name that is free") from None
            self._link = link
        asyncio.get_running_loop().add_reader(self._near, self._answer_frames)
        return str(link or path)

    def close(self) -> None:
        """Stop serving, close the terminal and remove the link."""
        asyncio.get_running_loop().remove_reader(self._near)
        os.close(self._near)
        os.close(self._terminal)
        self._near = self._terminal = -1  # a late reply finds no file, rather than another one
        if self._link is not None:
            self._link.unlink(missing_ok=True)

    def _answer_frames(self) -> None:
        """Answer the frames that have arrived, unless the link is silent."""
        with suppress(BlockingIOError):
            for frame in self._decoder.feed(os.read(self._near, 4096)):
                if not self.device.link.silent:
                    self._answer(frame)

    def _answer(self, frame: frames.SerialFrame) -> None:
        """Answer an identify or command frame, with the failure of the link that is due.

        Other frames, and commands that are invalid or not later than the last one, get no answer.
        """
        spoil = self.device.link.next()
        try:
            if frame.kind == frames.IDENTIFY_FRAME:
                kind, words = frames.IDENTITY_FRAME, self._identify()
            elif frame.kind == frames.COMMAND_FRAME and self._obey(frame.sequence, frames.unpack_words(frame.payload)):
                kind, words = frames.READING_FRAME, self._read()
            else:
                return
        except WireError:
            return
        number = (frame.sequence - (spoil is ReplyFault.SEQUENCE)) & 0xFFFF
        reply = frames.encode(kind, number, frames.pack_words(words))
        self._send(reply, spoil, len(reply) // 2, self._write)

    def _write(self, reply: bytes) -> None:
        """Write a reply to the terminal; one that can't be written is lost."""
        with suppress(OSError):  # full, since nobody reads, or closed since: as lost as a reply can be
            os.write(self._near, reply)
