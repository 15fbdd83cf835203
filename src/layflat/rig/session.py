"""The host's hold on a rig: it starts the loop's process, keeps setpoints fresh, and looks on."""

import multiprocessing
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from math import nan
from multiprocessing import connection
from multiprocessing.util import Finalize
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError, LayflatError
from layflat.machine import Machine
from layflat.motion.signal_values import read_number
from layflat.parallel import start_process
from layflat.rig.clock import SECOND
from layflat.rig.driver import Driver
from layflat.rig.lease import Lease
from layflat.rig.loop import Recorder
from layflat.rig.mailbox import Mailbox, Setpoints
from layflat.rig.process import run_loop
from layflat.rig.record import Layout
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.states import State

REFRESH = 0.025  # setpoints are written again so often, s; they are stale after 100 ms
STARTS_WITHIN = 300.0  # the process has to run by then; it may have to compile first, on a busy computer, s
ENDS_WITHIN = 10.0  # a controlled stop, and the hoses' emptying, take less, s


QUANTITIES = {"angles": u.ANGLE, "velocities": u.ANGULAR_SPEED, "accelerations": u.ANGULAR_ACCELERATION}


class LoopError(LayflatError):
    """The loop's process failed or is gone."""


class Snapshot:
    """A row by name."""

    def __init__(self, layout: Layout, row: Array) -> None:
        self._layout, self.row = layout, row

    def __getitem__(self, name: str) -> Array:
        """A shared number, or those of all joints, (joints,)."""
        return self._layout.named(self.row, name)

    def told(self, name: str, untold: float) -> Array:
        """Return the numbers of all joints, (joints,), or this one for each where the control law does not tell it."""
        return self[name] if name in self._layout.by_joint else np.full(len(self._layout.joints), untold)

    @property
    def state(self) -> State:
        """Of the supervisor."""
        return State(int(self["mode"]))

    @property
    def fault(self) -> Fault:
        """The worst there is."""
        return Fault(int(self["fault"]))

    @property
    def fault_text(self) -> str:
        """The same for people, with its joint."""
        if self.fault is Fault.NONE:
            return "stopped by the loop"
        each = list(self["joint_fault"])
        where = f"joint {self._layout.joints[each.index(self.fault)]!r}: " if self.fault in each else ""
        return where + self.fault.title


class Session(AbstractContextManager["Session"]):
    """A rig in use: `with Session(...) as rig: rig.start(); rig.ask([0.3, 0.2])`.

    The machine has a controller. With a lease the rig is held, and then stops, once nobody renews it: until
    somebody does, `start` and `ask` do nothing. What makes the driver, and the end of the recorder that takes rows, is
    called in the loop's process, so it must be picklable. LoopError is raised if the loop does not begin, and says why.
    """

    def __init__(
        self, machine: Machine, driver: Callable[[], Driver], recorder: Callable[[], Recorder] = Recorder,
        lease: Lease | None = None,
    ) -> None:  # fmt: skip
        self._layout, self._outputs = Layout.of(machine), machine.interface.outputs
        self.mailbox = Mailbox.create(self._layout)  # file of shared memory, in which anyone may look on
        self._memory = Mailbox(self.mailbox, self._layout)
        self._wanted = Setpoints([nan] * len(machine.joints))
        self._guard, self._over, self._lease = threading.RLock(), threading.Event(), lease
        self.lapsed = lease is not None  # whether nobody minds the rig now
        self.lapses = 0  # times that the lease has lapsed since the loop began
        self._want()
        self._pipe, its = multiprocessing.Pipe()
        self.process = start_process(run_loop, (machine, driver, self.mailbox, recorder, its), "layflat-loop")
        its.close()
        # A program that ends without `close` waits for the loop, which must not take it for one that lives.
        Finalize(self, self._over.set, exitpriority=10)
        self._thread = threading.Thread(target=self._keep_fresh, daemon=True)
        self._thread.start()
        self.messages: list[str] = []  # lines that the loop's process had to say
        try:
            self._wait_for_loop()
        except BaseException:
            self.close()
            raise

    def start(self) -> None:
        """Bring the air, softly; demands are obeyed from then on."""
        self.check()
        self._want_if_minded(starts=self._wanted.starts + 1)

    def hold(self) -> None:
        """Hold the joints where they are, with air; what was asked for is forgotten. `start` goes on, then `ask`."""
        self.check()
        self._hold()

    def stop(self) -> None:
        """Hold the joints, then let out the air."""
        self.check()
        self._want(stops=self._wanted.stops + 1)

    def switch(self, output: str, on: bool) -> None:
        """Switch a digital output of the machine; the device switches all off as it dumps, and none on by itself.

        Raises:
            InputError: the machine has no output of that name.
            LoopError: the loop does not run.
        """
        if output not in self._outputs:
            known = ", ".join(self._outputs)
            right = f"give {known}" if known else "name it in interface.outputs of the machine's file"
            raise InputError(f"unknown output {output!r}", where="output", right=right)
        self.check()
        with self._guard:
            self._want_if_minded(switches=self._wanted.switched(self._outputs.index(output), on))

    def reset(self) -> None:
        """Let go of latched faults that are over."""
        self.check()
        self._want(resets=self._wanted.resets + 1)

    def ask(
        self, angles: Sequence[float], velocities: Sequence[float] | None = None,
        accelerations: Sequence[float] | None = None, *, at: float | None = None,
    ) -> None:  # fmt: skip
        """Ask for angles of all joints, from base to tip, and for how they move on from there.

        With velocities the motion goes on for `moving.GOES_ON` unless something else is asked for, then comes to rest.
        Without them a rate is derived from the angles where they change smoothly from one call to the next, up to
        `moving.STREAM` apart; else they are asked for at rest. Control laws that go by errors take the angles alone.

        Args:
            angles: rad.
            velocities: rad/s.
            accelerations: rad/s2, beside velocities; without them zero.
            at: instant for which they are meant, by `time.monotonic()`; default: now. Others than about now are not
                believed.

        Raises:
            InputError: it is not one finite number for each joint, or accelerations are without velocities.
            LoopError: the loop does not run.
        """
        if accelerations is not None and velocities is None:
            raise InputError("are given without velocities", where="accelerations", right="give both")
        given = {"angles": angles, "velocities": velocities, "accelerations": accelerations}
        rows = {name: None if of is None else self._one_a_joint(name, of) for name, of in given.items()}
        self.check()
        meant = time.monotonic_ns() if at is None else round(at * SECOND)
        rows["demands"] = rows.pop("angles")
        self._want_if_minded(**rows, asks=self._wanted.asks + 1, meant=meant)

    def _one_a_joint(self, name: str, values: Sequence[float]) -> list[float]:
        """Return one finite number a joint; raise InputError where it is none."""
        joints = self._layout.joints
        if len(values) != len(joints):
            what = f"{len(values)} {name} for {len(joints)} joints"
            raise InputError(what, where="demand", right="give one a joint")
        return [read_number(value, QUANTITIES[name], f"demand: {name}") for value in values]

    def snapshot(self) -> Snapshot | None:
        """The last cycle; None before the first."""
        row = self._memory.shown()
        return Snapshot(self._layout, row) if row is not None else None

    def check(self) -> None:
        """Make sure that the loop runs; raise LoopError if it does not."""
        self._listen()
        if not self.process.is_alive():
            raise LoopError(f"the loop's process is gone (status {self.process.exitcode}); the device vents by itself")

    def end(self) -> None:
        """Stop, and let the loop end once the air is out; this does not wait for it."""
        self._want(ended=True, stops=self._wanted.stops + 1)

    def close(self) -> None:
        """Stop, wait until the air is out and the loop has ended."""
        self.end()
        try:
            self.process.join(ENDS_WITHIN)
            if self.process.is_alive():
                self.process.kill()
                self.process.join()
            with suppress(LoopError):
                self._listen()
        finally:
            self._over.set()
            self._thread.join()
            self._memory.close()
            self._pipe.close()
            self.mailbox.unlink(missing_ok=True)

    def __exit__(self, *_: object) -> None:
        self.close()

    def _want(self, **changed: Any) -> None:
        """Change what is wanted; even unchanged it shows that the host lives."""
        with self._guard:
            self._wanted = replace(self._wanted, **changed)
            self._memory.ask(self._wanted)

    def _want_if_minded(self, **changed: Any) -> None:
        with self._guard:
            self._mind()
            if not self.lapsed:
                self._want(**changed)

    def _hold(self) -> None:
        nothing = [nan] * len(self._wanted.demands)
        self._want(demands=nothing, velocities=None, accelerations=None, holds=self._wanted.holds + 1)

    def _keep_fresh(self) -> None:
        while not self._over.wait(REFRESH):
            self._mind()
            if self._lease is None or not self._lease.over or not self._has_air():
                self._want()

    def _mind(self) -> None:
        """Hold the joints once the lease has lapsed."""
        with self._guard:
            before, self.lapsed = self.lapsed, self._lease is not None and not self._lease.lives
            if self.lapsed and not before:
                self.lapses += 1
                self._hold()

    def _has_air(self) -> bool:
        shot = self.snapshot()
        return shot is not None and bool(shot["air"])

    def _listen(self) -> bool:
        """Take what the process has said, if anything."""
        try:
            if not self._pipe.poll():
                return False
            well, lines = self._pipe.recv()
        except (OSError, EOFError):  # it has ended
            return False
        self.messages += lines
        if not well:
            raise LoopError(lines[0])
        return True

    def _wait_for_loop(self) -> None:
        connection.wait([self._pipe, self.process.sentinel], STARTS_WITHIN)
        if not self._listen():
            self.process.join(0.1)  # so that its status is known
            alive = self.process.is_alive()
            how = f"is not ready after {STARTS_WITHIN:g} s" if alive else f"ended with status {self.process.exitcode}"
            raise LoopError(f"the loop's process {how}; start again once fewer programs run beside it")
