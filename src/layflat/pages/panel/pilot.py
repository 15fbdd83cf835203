"""Pilot of a rig: an operator's commands, carried out while the lease is renewed; and samples of the last 30 s."""

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.pages.panel.link import RigLink
from layflat.pages.panel.moves import ArmMotion, JogMotion, SequenceMotion, SequenceStep
from layflat.physics.air import NORMAL_DENSITY
from layflat.rig.abilities import DemandLimits, demand_limits
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import HostLease, RigLoopError, RigSession, RigSnapshot

HISTORY_DURATION = 30.0  # of the samples that are kept, s
HISTORY_PERIOD = 0.1  # of the samples, s
JOINT_SIGNALS = ("averaged_angle", "demand", "averaged_pressure", "voltage", "estimated_air")
SHARED_SIGNALS = ("supply", "lateness", "link")
BRAKE_SIGNAL = "brake_share"  # a joint's; 1 where the control law leaves the brakes alone
DEFAULT_SPEED_FRACTION = 0.3  # of the arm's limits, at which sequences move by default
PILOT_PERIOD = 0.02  # of the pilot's loop, s: a moving demand stays valid for 50 ms
START_REQUEST_TIME = 1.0  # for which a start is retried while the lease has lapsed, as it may on a busy computer, s
LEASE_LAPSED_TEXT = (
    "The page that drives was not heard for 0.2 s: it was closed, hidden or out of touch, or this computer was too busy"
)
MOVABLE_STATES = {RigState.READY, RigState.MOVING}


class RecentSamples(NamedTuple):
    """Samples of the last `HISTORY_DURATION`, in columns."""

    times: Array  # before now, s, (instants,), the last one 0
    joints: dict[str, Array]  # (instants, joints) each, by the names of `rig.record`
    shared: dict[str, Array]  # (instants,) each


class History:
    """Samples of the last `HISTORY_DURATION`, thinned out, and the greatest lateness of the loop."""

    def __init__(self) -> None:
        self._rows: deque[tuple[float, Array]] = deque()
        self._samples: tuple[object, RecentSamples] | None = None  # with its last row
        self.worst_lateness = 0.0  # s, since the rig was reached

    def add(self, shot: RigSnapshot, machine: Machine) -> None:
        """Store a cycle as a sample if one is due, and update the worst lateness, without the session's first second.

        A cycle older than the last sample is of another session, and clears the history first.
        """
        now = float(shot["time"])
        if self._rows and now < self._rows[-1][0]:
            self.pause()  # another session
        self.worst_lateness = max(self.worst_lateness, float(shot["lateness"])) if now > 1.0 else 0.0
        if self._rows and now - self._rows[-1][0] < HISTORY_PERIOD - 0.5 * machine.cycle:
            return
        parts = [*(shot[name] for name in JOINT_SIGNALS), shot.values_or(BRAKE_SIGNAL, 1.0)]
        self._rows.append((now, np.concatenate([*parts, [shot[name] for name in SHARED_SIGNALS]])))
        while now - self._rows[0][0] > HISTORY_DURATION:
            self._rows.popleft()

    def pause(self) -> None:
        """Clear the history: the rig is disconnected."""
        self._rows.clear()
        self.worst_lateness = 0.0

    def samples(self) -> RecentSamples | None:
        """Return the samples, the same object until a new one is kept; None where there are none."""
        rows, cached = list(self._rows), self._samples
        if not rows:
            return None
        if cached is not None and cached[0] is rows[-1]:
            return cached[1]
        times = np.array([time for time, _ in rows])
        table = np.array([row for _, row in rows])
        names = (*JOINT_SIGNALS, BRAKE_SIGNAL)
        n = (table.shape[1] - len(SHARED_SIGNALS)) // len(names)
        joints = {name: table[:, i * n : (i + 1) * n] for i, name in enumerate(names)}
        samples = RecentSamples(
            times - times[-1],
            joints,
            {name: table[:, i - len(SHARED_SIGNALS)] for i, name in enumerate(SHARED_SIGNALS)},
        )
        self._samples = rows[-1], samples
        return samples


def air_taken(samples: RecentSamples) -> Array:
    """Return the air that each joint has used since the first sample, normal litres, (instants, joints)."""
    air = samples.joints["estimated_air"]
    litres: Array = (air - air[0]) / NORMAL_DENSITY * 1000.0
    return litres


def air_rate(samples: RecentSamples) -> float:
    """Return the mean air consumption of all joints together over the samples, normal litres/min; 0 for one sample."""
    duration = -float(samples.times[0])
    return float(air_taken(samples)[-1].sum()) * 60.0 / duration if duration > 0.0 else 0.0


class Pilot:
    """Pilot of a rig: one motion at a time, which ends when the lease lapses or the rig obeys no more.

    Methods may be called from any thread; without a rig they do nothing.

    Attributes:
        history: samples of the last 30 s.
        hold_reason: reason for which the joints were held, or the air vented, without a command; empty while they move.
    """

    def __init__(self, link: RigLink, lease: HostLease) -> None:
        """Start the pilot's thread, without a motion."""
        self.history, self.hold_reason = History(), ""
        self._link, self._lease = link, lease
        self._move: ArmMotion | None = None
        self._start_until = 0.0  # s, monotonic
        self._before: RigState | None = None
        self._lapses = 0  # of the lease that are reported, or had no effect
        self._limits: tuple[Machine, DemandLimits] | None = None
        self._guard, self._over = threading.Lock(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="layflat-pilot", daemon=True)
        self._thread.start()

    @property
    def sequence(self) -> SequenceMotion | None:
        """Sequence that the arm performs, if it performs one."""
        move = self._move
        return move if isinstance(move, SequenceMotion) else None

    def start(self) -> None:
        """Request the air, or to go on after the joints were held; carried out while the lease is active.

        The request lapses after `START_REQUEST_TIME`.
        """
        self._start_until = time.monotonic() + START_REQUEST_TIME

    def hold(self) -> None:
        """Drop the motion and a requested start, and hold the joints where they are, with air."""
        self._acknowledge_lapses()
        self._drop_motion()
        self._send_command(RigSession.hold)

    def controlled_stop(self) -> None:
        """Drop the motion and a requested start, hold the joints, then vent the air."""
        self._acknowledge_lapses()
        self._drop_motion()
        self._send_command(RigSession.stop)

    def reset(self) -> None:
        """Reset faults that are over."""
        self._send_command(RigSession.reset)

    def switch(self, output: str, on: bool) -> None:
        """Switch a digital output of the machine."""
        self._send_command(lambda session: session.switch(output, on))

    def jog(self, velocities: Sequence[float]) -> None:
        """Move joints at these velocities, rad/s, (joints,), until zero is demanded.

        Velocities other than zero replace a sequence, if the rig obeys; zero leaves a sequence alone.
        """
        with self._guard:
            jog = self._move if isinstance(self._move, JogMotion) else None
            if jog is None and any(velocities) and (shot := self._obeying()) is not None:
                self._move = jog = JogMotion(self._link.machine, np.array(shot["demand"]))
            if jog is not None:
                jog.demand_velocity = np.array(velocities, float)

    def start_sequence(
        self, steps: Sequence[SequenceStep], *, share: float = DEFAULT_SPEED_FRACTION, repeats: bool = False
    ) -> bool:
        """Move through the steps of a sequence, from the present demand, in place of any other motion.

        Args:
            steps: steps, one after the other; without any nothing changes.
            share: fraction of the arm's speeds and accelerations, 0..1.
            repeats: whether the sequence restarts at its end.

        Returns:
            True if the motion has begun; False if the rig does not obey, or there are no steps.
        """
        with self._guard:
            shot = self._obeying()
            if shot is None or not steps:
                return False
            start, machine = np.array(shot["demand"]), self._link.machine
            self._move = SequenceMotion(
                machine, start, steps, share, repeats=repeats, limits=self._demand_limits(machine)
            )
            return True

    def close(self) -> None:
        """End the pilot's thread; the rig is left to its link."""
        self._over.set()
        self._thread.join()

    def _acknowledge_lapses(self) -> None:
        """Count all lapses of the lease so far as reported: a person ends the motion."""
        session = self._link.session
        self._lapses = 0 if session is None else session.lapses

    def _demand_limits(self, machine: Machine) -> DemandLimits:
        """Return the machine's demand limits, computed once for each machine."""
        cached = self._limits
        if cached is None or cached[0] is not machine:
            cached = self._limits = machine, demand_limits(machine)
        return cached[1]

    def _note_reason(self, session: RigSession, shot: RigSnapshot) -> None:
        """Set `hold_reason` once joints are held or vented without a command; clear it while off, starting, movable."""
        before, self._before = self._before, shot.state
        if shot.state in MOVABLE_STATES or shot.state in {RigState.OFF, RigState.STARTING}:
            self.hold_reason = ""
            if not session.lapsed:
                self._lapses = session.lapses
        elif shot.fault is not Fault.NONE:
            self.hold_reason = shot.fault_text
        elif shot.state is not before and session.lapses != self._lapses:
            self.hold_reason = LEASE_LAPSED_TEXT

    def _obeying(self) -> RigSnapshot | None:
        """Return the last cycle if the rig is in one of `MOVABLE_STATES` and the lease is active, else None."""
        shot = self._link.snapshot()
        return shot if shot is not None and shot.state in MOVABLE_STATES and self._lease.active else None

    def _drop_motion(self) -> None:
        """Drop the motion and a requested start."""
        with self._guard:
            self._move, self._start_until = None, 0.0

    def _send_command(self, command: Callable[[RigSession], None]) -> None:
        """Give a command to the rig's session, if there is one; errors of a session that has just ended are ignored."""
        session = self._link.session
        if session is not None:
            with suppress(RigLoopError, ValueError):  # it has ended meanwhile: the link reports it
                command(session)

    def _run(self) -> None:
        """Repeat every `PILOT_PERIOD`: store a sample, start a requested soft start, and send the motion's demand.

        The motion is dropped once it is over, the lease has lapsed, or the rig's state allows no motion.
        """
        while not self._over.wait(PILOT_PERIOD):
            shot, session = self._link.snapshot(), self._link.session
            if shot is None or session is None:
                self._drop_motion()
                self.history.pause()
                continue
            self._demand_limits(self._link.machine)  # computed here, so that no command waits for them
            self.history.add(shot, self._link.machine)
            self._note_reason(session, shot)
            if time.monotonic() < self._start_until and self._lease.active:
                self._start_until = 0.0
                self._send_command(RigSession.start)
            with self._guard:
                if self._move is not None and (
                    shot.state not in MOVABLE_STATES or not self._lease.active or self._move.is_over
                ):
                    self._move = None
                if self._move is not None:
                    with suppress(RigLoopError, ValueError):
                        self._move.send_demand(session, shot, time.monotonic())
