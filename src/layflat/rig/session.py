"""Session of a host on a rig: it starts the loop's process, refreshes the setpoints, and reads snapshots."""

import multiprocessing
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from math import inf, nan
from multiprocessing import connection
from multiprocessing.util import Finalize
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError, LayflatError
from layflat.machine import Machine
from layflat.motion.signal_values import read_number
from layflat.parallel import end_process, start_process
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.driver import Driver
from layflat.rig.loop import LoopRecorder
from layflat.rig.mailbox import Mailbox, Setpoints
from layflat.rig.process import run_loop
from layflat.rig.record import RowLayout
from layflat.rig.safety.faults import Fault, RigState

HELD_AFTER = 0.19  # without a renewal, after which the joints are held, s
STALE_AFTER = 0.7  # without one, after which setpoints are not refreshed while air is on: the loop stops 0.1 s later, s
REFRESH_INTERVAL = 0.025  # between two writes of the setpoints, s; they are stale after 100 ms
STARTS_WITHIN = 300.0  # time within which the loop has to run; it may compile first, on a busy computer, s
ENDS_WITHIN = 10.0  # longer than a controlled stop and the venting of the hoses take, s
QUANTITIES = {"angles": u.ANGLE, "velocities": u.ANGULAR_SPEED, "accelerations": u.ANGULAR_ACCELERATION}


class HostLease:
    """Lease on a rig that its operator renews continuously; a new one is expired.

    The host's process may run while no operator is present: a page was closed, a cable pulled, a browser is frozen. So
    setpoints are refreshed only while the lease has not expired; afterwards they go stale, and the loop itself stops.
    """

    def __init__(self) -> None:
        self._renewed = -inf

    def renew(self) -> None:
        """Renew the lease: the operator is present."""
        self._renewed = time.monotonic()

    @property
    def age(self) -> float:
        """Return the time since the last renewal, s; infinite before the first."""
        return time.monotonic() - self._renewed

    @property
    def active(self) -> bool:
        """Return whether it was renewed within `HELD_AFTER`: then the rig obeys."""
        return self.age <= HELD_AFTER

    @property
    def expired(self) -> bool:
        """Return whether it was not renewed for `STALE_AFTER`: then the rig stops."""
        return self.age > STALE_AFTER


class RigLoopError(LayflatError):
    """Failure or end of the loop's process."""


class RigSnapshot:
    """Row of one cycle, its numbers by name."""

    def __init__(self, layout: RowLayout, row: Array) -> None:
        self.layout, self.row = layout, row

    def __getitem__(self, name: str) -> Array:
        """Return a shared number, (), or those of all joints, (joints,)."""
        return self.layout.named(self.row, name)

    def values_or(self, name: str, default: float) -> Array:
        """Return a signal of all joints, (joints,); the default for each where the control law does not report it."""
        return self[name] if name in self.layout.by_joint else np.full(len(self.layout.joints), default)

    @property
    def state(self) -> RigState:
        """Return the state of the supervisor."""
        return RigState(int(self["mode"]))

    @property
    def fault(self) -> Fault:
        """Return the worst present fault."""
        return Fault(int(self["fault"]))

    @property
    def fault_text(self) -> str:
        """Return the title of the worst fault, with its first joint; "stopped by the loop" without a fault."""
        if self.fault is Fault.NONE:
            return "stopped by the loop"
        each = list(self["joint_fault"])
        where = f"joint {self.layout.joints[each.index(self.fault)]!r}: " if self.fault in each else ""
        return where + self.fault.title


class RigSession(AbstractContextManager["RigSession"]):
    """Session on a rig: `with RigSession(...) as rig: rig.start(); rig.ask([0.3, 0.2])`.

    With a lease the rig is held, and then stops, once the lease is not renewed; until it is, `start` and `ask` do
    nothing.

    Args:
        machine: description of the rig, with a controller.
        driver: factory of its driver, called in the loop's process; it must be picklable.
        recorder: factory of the recorder's end, likewise; default: nothing is recorded.
        lease: lease of the operator; default: none is needed.

    Raises:
        RigLoopError: the loop failed to start, with its reason.
    """

    def __init__(
        self, machine: Machine, driver: Callable[[], Driver], recorder: Callable[[], LoopRecorder] = LoopRecorder,
        lease: HostLease | None = None,
    ) -> None:  # fmt: skip
        self._layout, self._outputs = RowLayout.for_machine(machine), machine.interface.outputs
        self.mailbox = Mailbox.create(self._layout)  # file of shared memory, which any process may read
        self._memory = Mailbox(self.mailbox, self._layout)
        self._setpoints = Setpoints([nan] * len(machine.joints))
        self._guard, self._over, self._lease = threading.RLock(), threading.Event(), lease
        self.lapsed = lease is not None  # whether the lease is not active now
        self.lapses = 0  # times that the lease has lapsed since the loop began
        self._change_setpoints()
        self._pipe, its = multiprocessing.Pipe()
        self.process = start_process(run_loop, (machine, driver, self.mailbox, recorder, its), "layflat-loop")
        its.close()
        # A program that ends without `close` waits for the loop, which must not take it for one that lives.
        Finalize(self, self._over.set, exitpriority=10)
        self._thread = threading.Thread(target=self._renew_periodically, daemon=True)
        self._thread.start()
        self.messages: list[str] = []  # messages of the loop's process
        try:
            self._wait_for_loop()
        except BaseException:
            self.close()
            raise

    def start(self) -> None:
        """Request a soft start; demands are obeyed once the air has come."""
        self.check()
        self._change_unless_lapsed(starts=self._setpoints.starts + 1)

    def hold(self) -> None:
        """Hold the joints where they are, with air, and drop all demands; `start`, then `ask`, continue."""
        self.check()
        self._hold()

    def stop(self) -> None:
        """Begin a controlled stop: hold the joints, then vent the hoses."""
        self.check()
        self._change_setpoints(stops=self._setpoints.stops + 1)

    def switch(self, output: str, on: bool) -> None:
        """Switch a digital output of the machine; the device switches all off as it dumps, and none on by itself.

        Raises:
            InputError: the machine has no output of that name.
            RigLoopError: the loop does not run.
        """
        if output not in self._outputs:
            names = ", ".join(self._outputs)
            right = f"give {names}" if names else "name it in interface.outputs of the machine's file"
            raise InputError(f"unknown output {output!r}", where="output", right=right)
        self.check()
        with self._guard:
            self._change_unless_lapsed(switches=self._setpoints.switched(self._outputs.index(output), on))

    def reset(self) -> None:
        """Request a reset: latched faults that are over are cleared."""
        self.check()
        self._change_setpoints(resets=self._setpoints.resets + 1)

    def ask(
        self, angles: Sequence[float], velocities: Sequence[float] | None = None,
        accelerations: Sequence[float] | None = None, *, at: float | None = None,
    ) -> None:  # fmt: skip
        """Demand angles of all joints, from base to tip, and their motion from there on.

        With velocities the motion goes on for `demands.EXTRAPOLATION_TIME` unless another demand comes, then comes to
        rest. Without them a rate is derived from the angles where they change smoothly from one call to the next, up to
        `demands.MAX_STREAM_INTERVAL` apart; else they are demanded at rest. Control laws that do not plan use the
        angles alone.

        Args:
            angles: rad.
            velocities: rad/s.
            accelerations: rad/s2, beside velocities; without them zero.
            at: target instant of the demand by `time.monotonic()`, s; default: now. One more than 0.1 s from now counts
                as now.

        Raises:
            InputError: an argument is not one finite number for each joint, or accelerations are without velocities.
            RigLoopError: the loop does not run.
        """
        if accelerations is not None and velocities is None:
            right = "give velocities too, or leave both out"
            raise InputError("are given without velocities", where="accelerations", right=right)
        demand = {"angles": angles, "velocities": velocities, "accelerations": accelerations}
        rows = {name: None if row is None else self._read_row(name, row) for name, row in demand.items()}
        self.check()
        target_time = time.monotonic_ns() if at is None else round(at * NS_PER_SECOND)
        rows["demands"] = rows.pop("angles")
        self._change_unless_lapsed(**rows, asks=self._setpoints.asks + 1, target_time=target_time)

    def _read_row(self, name: str, values: Sequence[float]) -> list[float]:
        """Return values as one finite number a joint; raise InputError where they are not."""
        joints = self._layout.joints
        if len(values) != len(joints):
            what = f"{len(values)} {name} for {len(joints)} joints"
            raise InputError(what, where="demand", right="give one a joint")
        return [read_number(value, QUANTITIES[name], f"demand: {name}") for value in values]

    def snapshot(self) -> RigSnapshot | None:
        """Return the snapshot of the last cycle; None before the first."""
        row = self._memory.read_row()
        return RigSnapshot(self._layout, row) if row is not None else None

    def check(self) -> None:
        """Check that the loop runs; raise RigLoopError if it does not."""
        self._listen()
        if not self.process.is_alive():
            raise RigLoopError(
                f"the loop's process is gone (status {self.process.exitcode}); the device vents by itself"
            )

    def end(self) -> None:
        """Request a stop and the end of the loop once the air is out, without waiting for it."""
        self._change_setpoints(ended=True, stops=self._setpoints.stops + 1)

    def close(self) -> None:
        """Stop, and wait until the air is out and the loop has ended; kill its process after `ENDS_WITHIN`.

        A second call does nothing.
        """
        if self._over.is_set():
            return
        self.end()
        try:
            end_process(self.process, ENDS_WITHIN)
            with suppress(RigLoopError):
                self._listen()
        finally:
            self._over.set()
            self._thread.join()
            self._memory.close()
            self._pipe.close()
            self.mailbox.unlink(missing_ok=True)

    def __exit__(self, *_: object) -> None:
        self.close()

    def _change_setpoints(self, **changed: Any) -> None:
        """Change the setpoints and write them; even unchanged they are a heartbeat."""
        with self._guard:
            self._setpoints = replace(self._setpoints, **changed)
            self._memory.write_setpoints(self._setpoints)

    def _change_unless_lapsed(self, **changed: Any) -> None:
        """Change setpoints, unless the host's lease has lapsed."""
        with self._guard:
            self._check_lease()
            if not self.lapsed:
                self._change_setpoints(**changed)

    def _hold(self) -> None:
        """Request a hold, and drop all demands."""
        nothing = [nan] * len(self._setpoints.demands)
        self._change_setpoints(demands=nothing, velocities=None, accelerations=None, holds=self._setpoints.holds + 1)

    def _renew_periodically(self) -> None:
        """Renew the setpoints every `REFRESH_INTERVAL` as a heartbeat, unless a host's lease has expired under air."""
        while not self._over.wait(REFRESH_INTERVAL):
            self._check_lease()
            if self._lease is None or not self._lease.expired or not self._has_air():
                self._change_setpoints()

    def _check_lease(self) -> None:
        """Update `lapsed`; once a lease lapses, count that and hold the joints."""
        with self._guard:
            before, self.lapsed = self.lapsed, self._lease is not None and not self._lease.active
            if self.lapsed and not before:
                self.lapses += 1
                self._hold()

    def _has_air(self) -> bool:
        """Return whether air was requested in the last cycle; False before the first."""
        shot = self.snapshot()
        return shot is not None and bool(shot["air"])

    def _listen(self) -> bool:
        """Move a message of the loop, if any, to `messages`, and return whether there was one.

        Raise RigLoopError if the message is a failure.
        """
        try:
            if not self._pipe.poll():
                return False
            well, lines = self._pipe.recv()
        except (OSError, EOFError):  # it has ended
            return False
        self.messages += lines
        if not well:
            raise RigLoopError(lines[0])
        return True

    def _wait_for_loop(self) -> None:
        """Wait until the loop's process is ready; raise RigLoopError if it ends, or is not within `STARTS_WITHIN`."""
        connection.wait([self._pipe, self.process.sentinel], STARTS_WITHIN)
        if not self._listen():
            self.process.join(0.1)  # so that its status is known
            alive = self.process.is_alive()
            slow = f"is not ready after {STARTS_WITHIN:g} s; start again once fewer programs run beside it"
            how = slow if alive else f"ended with status {self.process.exitcode}; start again, and see what it prints"
            raise RigLoopError(f"the loop's process {how}")
