"""Link to a rig: connects, watches, and connects again after a loss, while pages that show the rig stay open."""

import threading
from collections.abc import Callable
from enum import Enum
from pathlib import Path

from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.rig.driver import Driver
from layflat.rig.recorded import RecordedSession
from layflat.rig.safety.faults import RigState
from layflat.rig.session import HostLease, RigLoopError, RigSession, RigSnapshot

NOT_AT_REST = "The rig has to be at rest, without air: press Vent, and wait."
LINK_CHECK_PERIOD = 0.1  # of the checks that the rig is still connected, s
RETRY_DELAY = 2.0  # before the next attempt to connect, s

RigConnector = Callable[[Machine], tuple[Callable[[], Driver], str]]
"""Function of a machine that returns a factory of the rig's driver, called in the loop's process, and its address."""


class LinkState(Enum):
    """State of the link."""

    CONNECTING = "connecting"
    OPEN = "open"
    GONE = "gone"
    LENT = "lent"  # something else has the rig: a check


class RigLink:
    """Link to one rig, kept by a thread of its own. Attributes may be read from any thread.

    Attributes:
        machine: machine of the rig, with its present controller.
        state: state of the link.
        trouble: message of the error that ended the link or the last attempt; empty where nothing is wrong.
        log_path: path of the log that is written, or was written last.
    """

    def __init__(self, machine: Machine, connect: RigConnector, folder: Path, lease: HostLease) -> None:
        """Start the thread that connects; logs are written to `folder`."""
        self.machine, self.state, self.trouble = machine, LinkState.CONNECTING, ""
        self.log_path = folder
        self._connect, self._folder, self._lease = connect, folder, lease
        self._recorded: RecordedSession | None = None
        self._over, self._anew, self._free = threading.Event(), threading.Event(), threading.Event()
        self._free.set()
        self._lending = threading.Lock()
        self._thread = threading.Thread(target=self._keep_connected, name="layflat-link")
        self._thread.start()

    @property
    def session(self) -> RigSession | None:
        """Session of the rig; None while the link is not open."""
        rig = self._recorded
        return rig.session if rig is not None and self.state is LinkState.OPEN else None

    @property
    def is_recording(self) -> bool:
        """True while every cycle is recorded."""
        rig = self._recorded
        return rig is not None and rig.is_recording

    def snapshot(self) -> RigSnapshot | None:
        """Return the last cycle; None where there is none."""
        session = self.session
        try:
            return session.snapshot() if session is not None else None
        except ValueError:  # its memory was closed meanwhile
            return None

    @property
    def is_at_rest(self) -> bool:
        """True while the rig is connected and without air, so that it may be released."""
        shot = self.snapshot()
        return shot is not None and shot.state in {RigState.OFF, RigState.STOPPED, RigState.FAULT} and not shot["air"]

    def change(self, machine: Machine) -> None:
        """Request a new session and log with a machine that has another controller; return before they begin.

        Raises:
            LayflatError: the rig is not at rest, without air.
        """
        if not self.is_at_rest:
            raise LayflatError(NOT_AT_REST)
        self.machine = machine
        self._anew.set()

    def lend(self) -> None:
        """End the session, and wait until the rig is free for a check or the link is closed; `reconnect` ends that.

        Raises:
            LayflatError: it is not at rest, or another check has it.
        """
        with self._lending:
            if not self.is_at_rest or not self._free.is_set():
                raise LayflatError(NOT_AT_REST if self._free.is_set() else "Another check has the rig: wait for it.")
            self._free.clear()
        self._anew.set()
        while self.state is not LinkState.LENT and not self._over.wait(LINK_CHECK_PERIOD):
            pass

    def reconnect(self) -> None:
        """Request that the link connects again after `lend`; return at once."""
        self._free.set()

    def close(self) -> None:
        """Stop the rig, vent the air, finish the log; it blocks until then."""
        self._over.set()
        self._free.set()
        self._thread.join()

    def _keep_connected(self) -> None:
        """Connect, and again `RETRY_DELAY` after an error, until the link is closed; not while the rig is lent."""
        while not self._over.is_set():
            if not self._free.is_set():
                self.state = LinkState.LENT
                self._free.wait()
                continue
            self.state = LinkState.CONNECTING
            self._anew.clear()
            try:
                self._keep_session()
            except (LayflatError, OSError) as error:
                self.state, self.trouble = LinkState.GONE, str(error)
                self._over.wait(RETRY_DELAY)

    def _keep_session(self) -> None:
        """Open a recorded session with the rig, and keep it until the link is closed or has to reconnect."""
        machine = self.machine
        driver, address = self._connect(machine)
        self._folder.mkdir(parents=True, exist_ok=True)
        with RecordedSession.in_folder(
            machine, driver, address, self._folder, f"{machine.name}-panel", self._lease
        ) as rig:
            self.log_path = rig.place
            self._recorded, self.state, self.trouble = rig, LinkState.OPEN, ""
            try:
                self._watch_session(rig)
            finally:
                # Observers must not read memory that is being closed.
                self.state = LinkState.CONNECTING
        self._recorded = None

    def _watch_session(self, rig: RecordedSession) -> None:
        """Check session and recorder until the link is closed or reconnects.

        Raises:
            RigLoopError: the loop has ended, or the recorder has and the rig is at rest.
        """
        while not self._over.wait(LINK_CHECK_PERIOD) and not self._anew.is_set():
            rig.session.check()
            if not rig.is_recording and self.is_at_rest:
                raise RigLoopError("the recorder has ended, so that nothing is recorded")
