"""Pilot of a rig: an operator's commands, obeyed while the lease is renewed, and twenty snapshots a second."""

import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

import numpy as np

from layflat.machine import Machine
from layflat.pages.panel.history import History
from layflat.pages.panel.link import RigLink
from layflat.pages.panel.moves import Course, Jog, Move, Step
from layflat.rig.abilities import DemandLimits, demand_limits
from layflat.rig.lease import Lease
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.states import State
from layflat.rig.session import LoopError, Session, Snapshot

USUAL_SHARE = 0.3  # of what the arm can do, at which courses move
TICK = 0.02  # between two looks, s: demands that move go on for 50 ms
WISHED = 1.0  # for so long a start is wished for while the lease has lapsed, as it may on a busy computer, s
UNMINDED = (
    "The page that drives was not heard for 0.2 s: it was closed, hidden or out of touch, or this computer was too busy"
)
MOVES = {State.READY, State.MOVING}


class Pilot:
    """Leads a rig: one move at a time, which ends where the lease lapses or the rig does no longer obey.

    Methods may be called from any thread; where the rig is gone they do nothing.

    Attributes:
        history: what was seen lately.
        why: reason for which the joints were held, or the air let out, without a person's wish; empty where they go on.
    """

    def __init__(self, link: RigLink, lease: Lease) -> None:
        self.history, self.why = History(), ""
        self._link, self._lease = link, lease
        self._move: Move | None = None
        self._start_until = 0.0  # s, monotonic
        self._before: State | None = None
        self._lapses = 0  # of the lease that are known to people, or led to nothing
        self._limits: tuple[Machine, DemandLimits] | None = None
        self._guard, self._over = threading.Lock(), threading.Event()
        self._thread = threading.Thread(target=self._lead, name="layflat-pilot", daemon=True)
        self._thread.start()

    @property
    def course(self) -> Course | None:
        """The course that the arm is on, if it is on one."""
        move = self._move
        return move if isinstance(move, Course) else None

    def start(self) -> None:
        """Bring the air, or go on after the joints were held."""
        self._start_until = time.monotonic() + WISHED

    def stop(self) -> None:
        """Hold the joints where they are, with air."""
        self._forgive()
        self._drop()
        self._tell(Session.hold)

    def vent(self) -> None:
        """Hold the joints, then let out the air."""
        self._forgive()
        self._drop()
        self._tell(Session.stop)

    def reset(self) -> None:
        """Reset faults that are over."""
        self._tell(Session.reset)

    def switch(self, output: str, on: bool) -> None:
        """Switch a digital output of the machine."""
        self._tell(lambda session: session.switch(output, on))

    def jog(self, velocities: Sequence[float]) -> None:
        """Move joints by these speeds, rad/s, from now until they are asked for zero."""
        with self._guard:
            jog = self._move if isinstance(self._move, Jog) else None
            if jog is None and any(velocities) and (shot := self._obeying()) is not None:
                self._move = jog = Jog(self._link.machine, np.array(shot["demand"]))
            if jog is not None:
                jog.wanted = np.array(velocities, float)

    def go(self, steps: Sequence[Step], *, share: float = USUAL_SHARE, repeats: bool = False) -> bool:
        """Move through places from where the joints are.

        Args:
            steps: the places, one after the other; without any the arm stays on what it does.
            share: of what the arm can do, 0..1.
            repeats: whether it begins anew at its end.

        Returns:
            Whether the rig obeys.
        """
        with self._guard:
            shot = self._obeying()
            if shot is None or not steps:
                return False
            start, machine = np.array(shot["demand"]), self._link.machine
            self._move = Course(machine, start, steps, share, repeats=repeats, limits=self._limits_of(machine))
            return True

    def close(self) -> None:
        """End it; the rig is left to its link."""
        self._over.set()
        self._thread.join()

    def _forgive(self) -> None:
        """Note that a person ends the motion, whatever the lease did before."""
        session = self._link.session
        self._lapses = 0 if session is None else session.lapses

    def _limits_of(self, machine: Machine) -> DemandLimits:
        known = self._limits
        if known is None or known[0] is not machine:
            known = self._limits = machine, demand_limits(machine)
        return known[1]

    def _note_reason(self, session: Session, shot: Snapshot) -> None:
        """Note why the joints were held, or the air let out, once they are."""
        before, self._before = self._before, shot.state
        if shot.state in MOVES or shot.state in {State.OFF, State.STARTING}:
            self.why = ""
            if not session.lapsed:
                self._lapses = session.lapses
        elif shot.fault is not Fault.NONE:
            self.why = shot.fault_text
        elif shot.state is not before and session.lapses != self._lapses:
            self.why = UNMINDED

    def _obeying(self) -> Snapshot | None:
        shot = self._link.snapshot()
        return shot if shot is not None and shot.state in MOVES and self._lease.lives else None

    def _drop(self) -> None:
        with self._guard:
            self._move, self._start_until = None, 0.0

    def _tell(self, what: Callable[[Session], None]) -> None:
        session = self._link.session
        if session is not None:
            with suppress(LoopError, ValueError):  # it went meanwhile: the link tells
                what(session)

    def _lead(self) -> None:
        while not self._over.wait(TICK):
            shot, session = self._link.snapshot(), self._link.session
            if shot is None or session is None:
                self._drop()
                self.history.pause()
                continue
            self._limits_of(self._link.machine)  # found here, so that nobody waits for them later
            self.history.add(shot, self._link.machine)
            self._note_reason(session, shot)
            if time.monotonic() < self._start_until and self._lease.lives:
                self._start_until = 0.0
                self._tell(Session.start)
            with self._guard:
                if self._move is not None and (shot.state not in MOVES or not self._lease.lives or self._move.over):
                    self._move = None
                if self._move is not None:
                    with suppress(LoopError, ValueError):
                        self._move.ask(session, shot, time.monotonic())
