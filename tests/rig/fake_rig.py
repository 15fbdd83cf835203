"""A driver on top of a plant for tests, a host that follows a plan, a loop of both; what can fail is an attribute."""

from __future__ import annotations

from collections.abc import Callable
from math import nan

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Capabilities, Driver, LinkError, RigCommand, SensorReading
from layflat.rig.loop import LoopRecorder, RigLoop
from layflat.rig.safety.faults import Fault, RigState, ValveMode
from layflat.rig.safety.supervisor import HostRequest
from tests.rig.plant_bench import PlantBench

Array = NDArray[np.float64]


def _nothing(angles: Array, pressures: Array) -> None: ...


class FakeDriver(Driver):
    """Simulated: a cycle of the plant passes between a write and the next read."""

    def __init__(self, machine: Machine, bench: PlantBench) -> None:
        super().__init__()
        self.machine, self.bench = machine, bench
        self.command: RigCommand | None = None
        self.commands: list[RigCommand] = []
        self.link: str | None = None
        self.device = DeviceState.RUNNING
        self.stopped = False
        self.supply: float | None = None
        self.spoil: Callable[[Array, Array], None] = _nothing

    def read(self) -> SensorReading:
        if self.command is not None:
            self.bench.advance(self.command.voltages)
        angles, pressures = self.bench.sense()
        self.spoil(angles, pressures)
        if self.link is not None:
            raise LinkError(self.link)
        supply = self.bench.around.supply_pressure if self.supply is None else self.supply
        return SensorReading(angles, pressures, supply, self.stopped, self.device)

    def write(self, command: RigCommand) -> None:
        self.command = command
        self.commands.append(command)
        gauge = self.machine.supply.pressure_gauge if command.air else 0.0
        around = self.bench.around
        self.bench.around = around._replace(supply_pressure=around.ambient_pressure + gauge)

    def _configure(self) -> Capabilities:
        return Capabilities(len(self.machine.joints), 0.0, 10.0, 5.0, True, 0.001)

    def _deactivate(self) -> None: ...


class PlannedHost(LoopRecorder):
    """Wants what it is told to, once; keeps rows and lines."""

    def __init__(self, n: int) -> None:
        self.demands = [nan] * n
        self.rates: tuple[list[float], list[float]] | None = None  # of the demands: velocities and accelerations
        self.start = self.stop = self.reset = self.hold = self.ended = False
        self.switched: list[tuple[int, bool]] = []
        self.age = 0.0
        self.rows: list[Array] = []
        self.lines: list[str] = []
        self.recording = True

    def request(self, _now: int) -> HostRequest:
        v, a = self.rates or (None, None)
        edges = self.start, self.stop, self.reset
        wish = HostRequest(list(self.demands), *edges, self.age, v, a, hold=self.hold, switched=self.switched)
        self.switched = []
        self.start = self.stop = self.reset = self.hold = False
        return wish

    def publish(self, row: Array) -> None:
        self.rows.append(row.copy())

    # As a recorder

    def event(self, text: str) -> None:
        self.lines.append(text)

    def is_alive(self) -> bool:
        return self.recording


class Rig:
    """All of it, with air in the hoses and demands obeyed from the first cycle on where `filled`."""

    def __init__(
        self, machine: Machine, angles: Array | None = None, *, seed: int = 0, filled: bool = True,
        described: Machine | None = None,
    ) -> None:  # fmt: skip
        n = len(machine.joints)
        at = np.zeros(n) if angles is None else np.asarray(angles, dtype=float)
        self.bench = PlantBench(machine, at, seed, None if filled else 0.0)
        self.driver = FakeDriver(machine, self.bench)
        self.host = PlannedHost(n)
        self.clock = VirtualClock()
        self.loop = RigLoop(described or machine, self.driver, self.clock, self.host, self.host)
        self.supervisor = self.loop.supervisor
        if filled:
            self.host.demands = at.tolist()
            quiet = self.bench.exact()
            self.loop.start_filled(SensorReading(*quiet, self.bench.around.supply_pressure, False, DeviceState.RUNNING))

    def cycles(self, count: int) -> Rig:
        for _ in range(count):
            self.loop.cycle()
        return self

    def seconds(self, seconds: float) -> Rig:
        return self.cycles(round(seconds / self.bench.cycle))

    def take_lines(self) -> list[str]:
        """Lines that came since the last call."""
        lines, self.host.lines = self.host.lines, []
        return lines

    def until(self, condition: Callable[[], bool], most: float) -> float:
        """Seconds until a condition holds after a cycle; at most so many."""
        for k in range(round(most / self.bench.cycle)):
            self.loop.cycle()
            if condition():
                return (k + 1) * self.bench.cycle
        raise AssertionError(f"nothing within {most} s: {self.host.lines[-5:]}")

    def shows(self, *what: RigState | ValveMode | Fault) -> bool:
        """Whether all of this is its state, its act, its latched or its worst fault."""
        ledger = self.supervisor.ledger
        present = (self.supervisor.state, self.supervisor.valve_mode, ledger.latched, ledger.worst)
        return all(any(one is other for other in present) for one in what)

    @property
    def now(self) -> float:
        return self.clock.now() / NS_PER_SECOND
