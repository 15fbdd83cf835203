"""Session on an arm that stands where it was demanded to, with states and faults as a test wants them."""

from collections.abc import Sequence

import numpy as np

from layflat.errors import InputError
from layflat.machine import load
from layflat.rig.record import RowLayout
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import RigLoopError, RigSnapshot

ARM = load("paper-arm")
LAYOUT = RowLayout.for_machine(ARM)
WALL = 1_780_000_000.0  # time of day of all cycles, s since 1970


class FakeSession:
    """What the node uses of `RigSession`."""

    def __init__(self, state: RigState = RigState.READY) -> None:
        self.state, self.fault = state, Fault.NONE
        self.demand, self.lag = np.zeros(2), np.zeros(2)  # rad
        self.asked: list[tuple[list[float], list[float] | None]] = []
        self.requests: list[str] = []
        self.is_running, self.is_frozen, self.time = True, False, 0.0

    def check(self) -> None:
        if not self.is_running:
            raise RigLoopError("the loop's process is gone (status -9); the device vents by itself")

    def snapshot(self) -> RigSnapshot:
        row = np.full(LAYOUT.width, 0.25)
        shot = RigSnapshot(LAYOUT, row)
        self.time += 0.0 if self.is_frozen else 0.005
        for name, value in {
            "time": self.time,
            "wall": WALL,
            "mode": self.state,
            "fault": self.fault,
            "supply": 7e5,
        }.items():
            row[LAYOUT.shared[name]] = value
        for name in ("measured_angle", "averaged_angle"):
            LAYOUT.named(row, name)[:] = self.demand + self.lag
        LAYOUT.named(row, "demand")[:] = self.demand
        LAYOUT.named(row, "joint_fault")[:] = 0.0, self.fault
        return shot

    def ask(self, angles: Sequence[float], velocities: Sequence[float] | None = None, *_: object, **__: object) -> None:
        if not all(isinstance(angle, float) for angle in angles):
            raise InputError("is no number", where="demand", right="give one")
        self.demand, self.state = np.array(angles), RigState.MOVING
        self.asked.append((list(angles), None if velocities is None else list(velocities)))

    def start(self) -> None:
        self.requests.append("start")

    def hold(self) -> None:
        self.requests.append("hold")

    def stop(self) -> None:
        self.requests.append("stop")

    def reset(self) -> None:
        self.requests.append("reset")
