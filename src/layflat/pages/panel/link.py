"""A rig that is brought up, watched, and brought up again once it is gone, while pages that show it stay open."""

import threading
from collections.abc import Callable
from enum import Enum
from pathlib import Path

from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.rig.driver import Driver
from layflat.rig.lease import Lease
from layflat.rig.recorded import Recorded
from layflat.rig.safety.states import State
from layflat.rig.session import LoopError, Session, Snapshot

NOT_AT_REST = "The rig has to be at rest, without air: press Vent, and wait."
LOOKS = 0.1  # between two looks whether the rig is still there, s
AGAIN = 2.0  # after which one that is gone is tried again, s

Reached = Callable[[Machine], tuple[Callable[[], Driver], str]]
"""What gives the driver of a machine's rig, as the loop's process makes it, and the rig's address."""


class Standing(Enum):
    """State of the link."""

    CONNECTING = "connecting"
    OPEN = "open"
    GONE = "gone"
    LENT = "lent"  # something else has the rig: a check


class RigLink:
    """The link to one rig, kept by a thread of its own. Attributes may be read from any thread.

    Attributes:
        machine: what the rig is.
        standing: of the link.
        trouble: what the rig said when it went, or what the last attempt met; empty where nothing is wrong.
        place: of the log that is being written, or was last.
    """

    def __init__(self, machine: Machine, reached: Reached, folder: Path, lease: Lease) -> None:
        self.machine, self.standing, self.trouble = machine, Standing.CONNECTING, ""
        self.place = folder
        self._reached, self._folder, self._lease = reached, folder, lease
        self._recorded: Recorded | None = None
        self._over, self._anew, self._free = threading.Event(), threading.Event(), threading.Event()
        self._free.set()
        self._lending = threading.Lock()
        self._thread = threading.Thread(target=self._keep, name="layflat-link")
        self._thread.start()

    @property
    def session(self) -> Session | None:
        """The session, while the link is open."""
        rig = self._recorded
        return rig.session if rig is not None and self.standing is Standing.OPEN else None

    @property
    def recording(self) -> bool:
        """True while every cycle is recorded."""
        rig = self._recorded
        return rig is not None and rig.recording

    def snapshot(self) -> Snapshot | None:
        """The last cycle; None where there is none."""
        session = self.session
        try:
            return session.snapshot() if session is not None else None
        except ValueError:  # its memory was closed meanwhile
            return None

    @property
    def at_rest(self) -> bool:
        """True while the rig is connected and without air, so that it may be released."""
        shot = self.snapshot()
        return shot is not None and shot.state in {State.OFF, State.STOPPED, State.FAULT} and not shot["air"]

    def change(self, machine: Machine) -> None:
        """Go on with another controller, in a new session and log (LayflatError: the rig is not at rest)."""
        if not self.at_rest:
            raise LayflatError(NOT_AT_REST)
        self.machine = machine
        self._anew.set()

    def lend(self) -> None:
        """Release the rig, and wait until it is free for somebody else; `take_back` ends that.

        Raises:
            LayflatError: it is not at rest, or somebody else has it.
        """
        with self._lending:
            if not self.at_rest or not self._free.is_set():
                raise LayflatError(NOT_AT_REST if self._free.is_set() else "Another check has the rig: wait for it.")
            self._free.clear()
        self._anew.set()
        while self.standing is not Standing.LENT and not self._over.wait(LOOKS):
            pass

    def take_back(self) -> None:
        """Connect again."""
        self._free.set()

    def close(self) -> None:
        """Stop the rig, let out the air, finish the log."""
        self._over.set()
        self._free.set()
        self._thread.join()

    def _keep(self) -> None:
        while not self._over.is_set():
            if not self._free.is_set():
                self.standing = Standing.LENT
                self._free.wait()
                continue
            self.standing = Standing.CONNECTING
            self._anew.clear()
            try:
                self._open()
            except (LayflatError, OSError) as error:
                self.standing, self.trouble = Standing.GONE, str(error)
                self._over.wait(AGAIN)

    def _open(self) -> None:
        machine = self.machine
        driver, address = self._reached(machine)
        self._folder.mkdir(parents=True, exist_ok=True)
        with Recorded.in_folder(machine, driver, address, self._folder, f"{machine.name}-panel", self._lease) as rig:
            self.place = rig.place
            self._recorded, self.standing, self.trouble = rig, Standing.OPEN, ""
            try:
                self._watch(rig)
            finally:
                # Who looks on must not meet memory that is being closed.
                self.standing = Standing.CONNECTING
        self._recorded = None

    def _watch(self, rig: Recorded) -> None:
        while not self._over.wait(LOOKS) and not self._anew.is_set():
            rig.session.check()
            if not rig.recording and self.at_rest:
                raise LoopError("the recorder is gone")
