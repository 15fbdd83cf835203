"""The host's hold on a rig: it starts the loop's process, keeps setpoints fresh, and looks on."""

from __future__ import annotations

import contextlib
import multiprocessing
import threading
import time
from collections.abc import Callable, Sequence
from math import nan
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from layflat.errors import InputError, LayflatError
from layflat.machine import Machine
from layflat.rig.driver import Driver
from layflat.rig.law import layout_of
from layflat.rig.mailbox import Mailbox, Setpoints
from layflat.rig.process import Job, Keeper, LoopMessage, run_loop
from layflat.rig.record import SHARED, Layout
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.states import State
from layflat.rig.shielded import shielded

Array = NDArray[np.float64]

REFRESH = 0.025
"""Setpoints are written again so often, s; they are stale after 100 ms."""

STARTS_WITHIN = 60.0
"""The process has to run by then; it may have to compile first, s."""

ENDS_WITHIN = 10.0
"""A controlled stop, and the hoses' emptying, take less, s."""


class LoopError(LayflatError):
    """The loop's process failed or is gone."""


class Snapshot:
    """A row by name.

    Args:
        layout: of the row.
        row: numbers.
    """

    def __init__(self, layout: Layout, row: Array) -> None:
        self._layout, self.row = layout, row

    def __getitem__(self, name: str) -> float | Array:
        """A shared number, or those of all joints."""
        if name in SHARED:
            return float(self.row[self._layout.shared[name]])
        return self._layout.joint_rows(self.row)[:, self._layout.columns[name]]

    @property
    def state(self) -> State:
        """Of the supervisor."""
        return State(int(self.row[self._layout.shared["mode"]]))

    @property
    def fault(self) -> Fault:
        """The worst there is."""
        return Fault(int(self.row[self._layout.shared["fault"]]))


class Session:
    """A rig in use: `with Session(...) as rig: rig.start(); rig.ask([0.3, 0.2])`.

    Args:
        machine: with controller.
        driver: makes the driver; called in the loop's process, so it must be picklable.
        rig: what names the rig, such as the driver's address: two loops can't have it at a time.
        recorder: makes the recorder's end that takes rows, in the loop's process; picklable.
        realtime: whether the loop asks for priority and locked memory.
        refresh: whether a thread keeps setpoints fresh; otherwise `ask` or `refresh` has to be called every 50 ms.
    """

    def __init__(
        self, machine: Machine, driver: Callable[[], Driver], rig: str, recorder: Callable[[], Keeper] | None = None,
        *, realtime: bool = True, refresh: bool = True,
    ) -> None:  # fmt: skip
        self._layout = layout_of(machine)
        self._path = Mailbox.create(self._layout)
        self._mailbox = Mailbox(self._path, self._layout)
        self._wanted = Setpoints([nan] * len(machine.joints))
        self._guard = threading.Lock()
        self.refresh()
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        job = Job(machine, driver, self._path, rig, recorder, realtime)
        self.process = context.Process(target=run_loop, args=(job, other), name="layflat-loop")
        with shielded():
            self.process.start()
        other.close()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._keep_fresh, daemon=True) if refresh else None
        if self._thread is not None:
            self._thread.start()
        self.messages: tuple[str, ...] = ()
        """Lines that the loop's process had to say."""
        try:
            self._begun()
        except BaseException:
            self.close()
            raise

    def start(self) -> None:
        """Bring the air, softly; demands are obeyed from then on."""
        self._edge("starts")

    def stop(self) -> None:
        """Hold the joints, then let out the air."""
        self._edge("stops")

    def reset(self) -> None:
        """Let go of latched faults that are over."""
        self._edge("resets")

    def ask(self, demands: Sequence[float]) -> None:
        """Angles for all joints, rad, from base to tip.

        Raises:
            InputError: not one for each joint.
            LoopError: the loop is gone.
        """
        if len(demands) != len(self._layout.joints):
            raise InputError(
                f"{len(demands)} angles for {len(self._layout.joints)} joints", where="demand", right="give one a joint"
            )
        self.check()
        with self._guard:
            self._wanted.demands = [float(demand) for demand in demands]
            self._mailbox.ask(self._wanted)

    @property
    def mailbox(self) -> Path:
        """File of shared memory, in which anyone may look on."""
        return self._path

    def refresh(self) -> None:
        """Show that the host lives."""
        with self._guard:
            self._mailbox.ask(self._wanted)

    def snapshot(self) -> Snapshot | None:
        """The last cycle; None before the first."""
        row = self._mailbox.shown()
        return Snapshot(self._layout, row) if row is not None else None

    def check(self) -> None:
        """Make sure that the loop runs.

        Raises:
            LoopError: it does not.
        """
        self._listen()
        if not self.process.is_alive():
            raise LoopError(f"the loop's process is gone (status {self.process.exitcode}); the device vents by itself")

    def end(self) -> None:
        """Stop, and let the loop end once the air is out; this does not wait for it."""
        with self._guard:
            self._wanted.ended = True
            self._wanted.stops += 1
            self._mailbox.ask(self._wanted)

    def close(self) -> None:
        """Stop, wait until the air is out and the loop has ended."""
        self.end()
        try:
            self.process.join(ENDS_WITHIN)
            if self.process.is_alive():
                self.process.kill()
                self.process.join()
            with contextlib.suppress(LoopError):
                self._listen()
        finally:
            self._over.set()
            if self._thread is not None:
                self._thread.join()
            self._mailbox.close()
            self._pipe.close()
            self._path.unlink(missing_ok=True)

    def __enter__(self) -> Session:
        """The session itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()

    def _edge(self, name: str) -> None:
        self.check()
        with self._guard:
            setattr(self._wanted, name, getattr(self._wanted, name) + 1)
            self._mailbox.ask(self._wanted)

    def _keep_fresh(self) -> None:
        while not self._over.wait(REFRESH):
            self.refresh()

    def _listen(self) -> bool:
        """Take what the process has said, if anything."""
        try:
            said: LoopMessage | None = self._pipe.recv() if self._pipe.poll() else None
        except (OSError, EOFError):  # it has ended
            return False
        if said is not None:
            self.messages += said.lines
            if said.kind == "failed":
                raise LoopError(said.lines[0])
        return said is not None

    def _begun(self) -> None:
        until = time.monotonic() + STARTS_WITHIN
        while time.monotonic() < until:
            gone = not self.process.is_alive()
            if self._listen():
                return
            if gone:
                break
            time.sleep(0.01)
        raise LoopError(f"the loop's process did not start (status {self.process.exitcode})")
