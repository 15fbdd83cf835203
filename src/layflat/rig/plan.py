"""Execution of a plan of demands on a rig: soft start, demands in time, and causes of an early end."""

import time
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError, LayflatError
from layflat.machine import Machine, parameters
from layflat.motion.signal_rows import read_rows
from layflat.motion.signal_values import SignalKind, read_number
from layflat.rig.abilities import demand_limits
from layflat.rig.recorded import RecordedSession
from layflat.rig.safety.faults import RigState
from layflat.rig.session import RigLoopError, RigSnapshot

POLL_INTERVAL = 0.02  # between two polls of the rig, at most, s: polling without pause takes a processor from the loop
START_MARGIN = 5.0  # beyond the machine's start time, within which a refused start shows, s


class EarlyEndError(LayflatError):
    """End of a run before that of its plan; `fault` is False where the user stopped it."""

    def __init__(self, what: str, *, fault: bool) -> None:
        self.fault = fault
        super().__init__(what)


@dataclass(frozen=True)
class DemandPlan:
    """Plan of demands in time, from the end of the soft start."""

    times: Sequence[float]  # from which on each holds, increasing, s
    demands: Sequence[Sequence[float]]  # rad, one for each joint from base to tip, a row for each time
    duration: float  # until the joints are held and the air is vented, s
    velocities: Sequence[Sequence[float]] | None = None  # rad/s, rows likewise; None: they are derived, or zero
    accelerations: Sequence[Sequence[float]] | None = None  # rad/s2, beside velocities


def check_accelerations(machine: Machine, accelerations: Array, where: str) -> None:
    """Check that accelerations do not exceed those that the arm has in its best configuration.

    Control laws that do not plan their motion ignore accelerations; theirs are not checked.

    Args:
        machine: the machine.
        accelerations: rad/s2, (cycles, joints).
        where: source of the accelerations, for messages.

    Raises:
        InputError: an acceleration is too large.
    """
    if not machine.control_law.plans:
        return
    limit = demand_limits(machine).acceleration
    row, j = np.unravel_index(int(np.argmax(np.abs(accelerations) / limit)), accelerations.shape)
    if abs(accelerations[row, j]) > limit[j]:
        demanded, possible = np.degrees(accelerations[row, j]), np.degrees(limit[j])
        what = f"asks joint {list(machine.joints)[j]!r} for {demanded:.4g} deg/s2 at {row * machine.cycle:.6g} s"
        raise InputError(what, where=where, right=f"it can do {possible:.4g} deg/s2 at most")


def check_plan(machine: Machine, plan: DemandPlan, where: str = "plan") -> None:
    """Check that a machine can follow a plan to its end, before its rig gets air.

    Args:
        machine: the machine.
        plan: demands in time.
        where: source of the plan, for messages.

    Raises:
        InputError: times do not begin at 0 or later and increase, or reach the duration; a demand or rate is not one
            finite number a joint and time; a demand is outside the working stroke; accelerations are without
            velocities.
    """
    joints = list(machine.joints)
    count, duration = len(plan.times), read_number(plan.duration, u.TIME, f"{where}: duration")
    times = read_rows(plan.times, SignalKind(f"{where}: times", u.TIME, (where,)), count)[:, 0]
    if count == 0 or times[0] < 0.0 or np.any(np.diff(times) <= 0.0):
        raise InputError("must begin at 0 or later, and increase", where=f"{where}: times", right="give 0.0, 0.5, ...")
    if times[-1] >= duration:
        right = f"its last demand comes at {times[-1]:g} s: give more"
        raise InputError(f"{duration:g} s ends before the last move", where=f"{where}: duration", right=right)
    demands = read_rows(plan.demands, SignalKind(where, u.ANGLE, joints), count)
    for j, name in enumerate(joints):
        parameters.check_inside_stroke(machine, name, float(demands[np.argmax(np.abs(demands[:, j])), j]), where)
    if plan.accelerations is not None and plan.velocities is None:
        right = "give velocities too, or leave both out"
        raise InputError("are given without velocities", where=f"{where}: accelerations", right=right)
    for name, rates, quantity in (
        ("velocities", plan.velocities, u.ANGULAR_SPEED), ("accelerations", plan.accelerations, u.ANGULAR_ACCELERATION),
    ):  # fmt: skip
        if rates is not None:
            read_rows(rates, SignalKind(f"{where}: {name}", quantity, joints), count)


class PlanRunner:
    """Runner of a plan on a rig in use; `stopped` returns True once the user has stopped it."""

    def __init__(self, rig: RecordedSession, stopped: Callable[[], bool] = bool) -> None:
        self._rig, self._stopped = rig, stopped
        self._running = False
        self.sending_times: list[float] = []  # instant at which each of the plan's demands was sent, loop time, s
        self.ended = 0.0  # instant of the plan's end, or at which the cause of an early end was read, loop time, s

    def start_air(self) -> list[float]:
        """Start softly, wait until the air is ready, and return the angles at which the joints are then held, rad.

        Raises:
            EarlyEndError: the start failed or took too long, the user stopped it, or loop or recorder have ended.
        """
        session, give_up = self._rig.session, time.monotonic() + self._rig.machine.safety.start_time + START_MARGIN
        self._last_snapshot()
        session.start()
        starting = False
        while (shot := self._last_snapshot()) is None or shot.state is not RigState.READY:
            starting = starting or (shot is not None and shot.state is RigState.STARTING)
            if starting and shot is not None and shot.state in {RigState.OFF, RigState.STOPPED}:
                raise EarlyEndError(f"the start was broken off: {shot.fault_text}", fault=True)
            if time.monotonic() > give_up:
                within = self._rig.machine.safety.start_time + START_MARGIN
                raise EarlyEndError(f"the rig did not start within {within:g} s", fault=True)
            time.sleep(POLL_INTERVAL)
        self._running = True
        demands: list[float] = shot["demand"].tolist()
        return demands

    def follow(self, plan: DemandPlan) -> None:
        """Send the plan's demands in time, until it ends; of several that are due at once only the last is sent.

        Raises:
            EarlyEndError: the user, a fault, or the end of loop or recorder ended it.
            InputError: the machine can't follow the plan; nothing was sent.
        """
        check_plan(self._rig.machine, plan)
        begin, done = time.monotonic(), 0
        while (now := time.monotonic() - begin) < plan.duration:
            shot = self._last_snapshot()
            due = bisect_right(plan.times, now)
            if due > done and shot is not None:
                self.sending_times += [float(shot["time"])] * (due - done)
                self._send_row(plan, due - 1, begin)
                done = due
            coming = plan.times[done] if done < len(plan.times) else plan.duration
            time.sleep(min(max(begin + coming - time.monotonic(), 1e-3), POLL_INTERVAL))
        self._last_snapshot()

    def _send_row(self, plan: DemandPlan, row: int, begin: float) -> None:
        """Send a row of a plan that began at `begin` (s, monotonic); one with velocities is meant for its due time."""
        v, a = (None if rates is None else rates[row] for rates in (plan.velocities, plan.accelerations))
        at = None if v is None else begin + plan.times[row]
        self._rig.session.ask(plan.demands[row], v, a, at=at)

    def _last_snapshot(self) -> RigSnapshot | None:
        """Return the snapshot of the last cycle (None before the first) and set `ended` to its time (else 0).

        Raises:
            EarlyEndError: the user stopped it, loop or recorder have ended, or the rig is in FAULT, or in STOPPED after
                `start_air` succeeded.
        """
        shot = self._rig.session.snapshot()
        self.ended = float(shot["time"]) if shot is not None else 0.0
        if self._stopped():
            raise EarlyEndError("stopped", fault=False)
        try:
            self._rig.session.check()
        except RigLoopError as error:
            raise EarlyEndError(str(error), fault=True) from None
        if not self._rig.is_recording:
            raise EarlyEndError("the recorder is gone", fault=True)
        if shot is not None and (shot.state is RigState.FAULT or (self._running and shot.state is RigState.STOPPED)):
            raise EarlyEndError(shot.fault_text, fault=True)
        return shot
