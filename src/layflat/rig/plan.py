"""A plan of demands, performed on a rig: soft start, demands in time, and what ends it early."""

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
from layflat.rig.recorded import Recorded
from layflat.rig.safety.states import State
from layflat.rig.session import LoopError, Snapshot

TICK = 0.02  # between two looks at the rig, at most, s: who looks all the time takes a processor from the loop
SPARE = 5.0  # beyond the machine's start time, in which a start that is refused shows, s


class EarlyEndError(LayflatError):
    """A run ended before its plan did; `fault`: it was no wish of the user's."""

    def __init__(self, what: str, *, fault: bool) -> None:
        self.fault = fault
        super().__init__(what)


@dataclass(frozen=True)
class Plan:
    """Demands in time, from the end of the soft start."""

    times: Sequence[float]  # from which on each holds, growing, s
    demands: Sequence[Sequence[float]]  # rad, one for each joint from base to tip, a row for each time
    duration: float  # until the joints are held and the air is let out, s
    velocities: Sequence[Sequence[float]] | None = None  # rad/s, rows likewise; None: they are derived, or zero
    accelerations: Sequence[Sequence[float]] | None = None  # rad/s2, beside velocities


def check_accelerations(machine: Machine, accelerations: Array, where: str) -> None:
    """Refuse accelerations (rad/s2, (cycles, joints)) that no posture of the arm has; raise InputError naming where.

    Those of a control law that goes by errors are of no account.
    """
    if not machine.control_law.plans:
        return
    most = demand_limits(machine).acceleration
    row, j = np.unravel_index(int(np.argmax(np.abs(accelerations) / most)), accelerations.shape)
    if abs(accelerations[row, j]) > most[j]:
        asked, can = np.degrees(accelerations[row, j]), np.degrees(most[j])
        what = f"asks joint {list(machine.joints)[j]!r} for {asked:.4g} deg/s2 at {row * machine.cycle:.6g} s"
        raise InputError(what, where=where, right=f"it can do {can:.4g} deg/s2 at most")


def check_plan(machine: Machine, plan: Plan, where: str = "plan") -> None:
    """Refuse a plan that a machine can't follow to its end, before its rig gets air.

    Args:
        machine: the machine.
        plan: demands in time.
        where: what gave it, in messages.

    Raises:
        InputError: times do not grow or end after the plan; a demand is not one number a joint, or outside the stroke.
    """
    joints = list(machine.joints)
    count, duration = len(plan.times), read_number(plan.duration, u.TIME, f"{where}: duration")
    times = read_rows(plan.times, SignalKind(f"{where}: times", u.TIME, (where,)), count)[:, 0]
    if count == 0 or times[0] < 0.0 or np.any(np.diff(times) <= 0.0):
        raise InputError("do not grow from zero or later", where=f"{where}: times", right="give 0.0, 0.5, ...")
    if times[-1] >= duration:
        right = f"its last demand comes at {times[-1]:g} s: give more"
        raise InputError(f"{duration:g} s ends before the last move", where=f"{where}: duration", right=right)
    demands = read_rows(plan.demands, SignalKind(where, u.ANGLE, joints), count)
    for j, name in enumerate(joints):
        parameters.check_inside_stroke(machine, name, float(demands[np.argmax(np.abs(demands[:, j])), j]), where)
    if plan.accelerations is not None and plan.velocities is None:
        raise InputError("are given without velocities", where=f"{where}: accelerations", right="give both")
    for name, rates, quantity in (
        ("velocities", plan.velocities, u.ANGULAR_SPEED), ("accelerations", plan.accelerations, u.ANGULAR_ACCELERATION),
    ):  # fmt: skip
        if rates is not None:
            read_rows(rates, SignalKind(f"{where}: {name}", quantity, joints), count)


class PlanRunner:
    """A rig in use that is led through a plan; `stopped` tells whether the user wants it to end."""

    def __init__(self, rig: Recorded, stopped: Callable[[], bool] = bool) -> None:
        self._rig, self._stopped = rig, stopped
        self._running = False
        self.asked: list[float] = []  # when each of the plan's demands was asked for, by the loop's time, s
        self.ended = 0.0  # when the plan ended, or what ended it was seen, by the same, s

    def bring_air(self) -> list[float]:
        """Start softly; angles at which the joints are held then, rad. Raise EarlyEndError if there is no air."""
        session, give_up = self._rig.session, time.monotonic() + self._rig.machine.safety.start_time + SPARE
        self._look()
        session.start()
        starting = False
        while (shot := self._look()) is None or shot.state is not State.READY:
            starting = starting or (shot is not None and shot.state is State.STARTING)
            if starting and shot is not None and shot.state in {State.OFF, State.STOPPED}:
                raise EarlyEndError(f"the start was broken off: {shot.fault_text}", fault=True)
            if time.monotonic() > give_up:
                raise EarlyEndError("the rig did not start", fault=True)
            time.sleep(TICK)
        self._running = True
        demands: list[float] = shot["demand"].tolist()
        return demands

    def follow(self, plan: Plan) -> None:
        """Ask for the plan's demands in time, until it ends; raise EarlyEndError if something ended it.

        Raises:
            InputError: the machine can't follow the plan; nothing was asked for.
        """
        check_plan(self._rig.machine, plan)
        begin, done = time.monotonic(), 0
        while (now := time.monotonic() - begin) < plan.duration:
            shot = self._look()
            due = bisect_right(plan.times, now)
            if due > done and shot is not None:
                self.asked += [float(shot["time"])] * (due - done)
                self._ask(plan, due - 1, begin)
                done = due
            coming = plan.times[done] if done < len(plan.times) else plan.duration
            time.sleep(min(max(begin + coming - time.monotonic(), 1e-3), TICK))
        self._look()

    def _ask(self, plan: Plan, row: int, begin: float) -> None:
        """Ask for a row of a plan that began then (s, monotonic); one that moves counts from when it was due."""
        v, a = (None if rates is None else rates[row] for rates in (plan.velocities, plan.accelerations))
        at = None if v is None else begin + plan.times[row]
        self._rig.session.ask(plan.demands[row], v, a, at=at)

    def _look(self) -> Snapshot | None:
        """The last cycle; raise EarlyEndError if the run has ended."""
        shot = self._rig.session.snapshot()
        self.ended = float(shot["time"]) if shot is not None else 0.0
        if self._stopped():
            raise EarlyEndError("stopped", fault=False)
        try:
            self._rig.session.check()
        except LoopError as error:
            raise EarlyEndError(str(error), fault=True) from None
        if not self._rig.recording:
            raise EarlyEndError("the recorder is gone", fault=True)
        if shot is not None and (shot.state is State.FAULT or (self._running and shot.state is State.STOPPED)):
            raise EarlyEndError(shot.fault_text, fault=True)
        return shot
