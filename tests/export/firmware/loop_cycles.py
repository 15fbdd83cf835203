"""Cycles of a rig's loop that moves and fails, as what a device that runs the law itself reads and hears in each."""

from collections.abc import Iterator
from math import nan
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.rig import frames
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device.failures import get_failure
from layflat.rig.device.virtual import SimulatedDriver
from layflat.rig.driver import RigCommand, SensorReading
from layflat.rig.loop import LoopRecorder, RigLoop
from layflat.rig.safety.core import CycleCore
from layflat.rig.safety.faults import RigState
from layflat.rig.safety.requests import DeviceRequest, RequestWire
from layflat.rig.safety.supervisor import HostRequest
from layflat.rig.wire import Wire
from layflat.virtual_rig import VirtualRig

FAILURES: tuple[tuple[str, float | None], ...] = (
    ("e-stop", None), ("angle-open", None), ("supply-lost", None), ("stuck-spool", 0.5), ("pressure-frozen", None),
    ("converter-frozen", None), ("burst-hose", None), ("grip", 3.0), ("push", 2.5),
)  # fmt: skip
"""Failures in turn, with their sizes."""

FAILS_AFTER, HEALS_AFTER, RESETS_AFTER, STARTS_AFTER = 5.0, 5.6, 6.6, 6.7  # in each round, s
ROUND = 6.8  # from a start to the next, s
DEMAND_CYCLES = 70  # between two demands


class Cycle(NamedTuple):
    """Control cycle: what comes in, and all that the loop makes of it."""

    time: int  # us
    reading: SensorReading
    request: DeviceRequest
    command: RigCommand
    inputs: Array
    after: Array  # memory, then results, in the order of the structs of C
    rows: Array  # signals of each joint, as they are recorded
    events: list[str]


class ScriptedHost(LoopRecorder):
    """Host and recorder of a loop; its requests are attributes, and are kept as a device would hear them."""

    ended = False

    def __init__(self, joints: int) -> None:
        self.wanted = HostRequest([nan] * joints)
        self.heard = DeviceRequest.first(joints)
        self.lines: list[str] = []
        self.recording = True

    def request(self, _: int) -> HostRequest:
        wanted = self.wanted
        self.wanted = wanted._replace(start=False, stop=False, hold=False, reset=False, switched=())
        self.heard = self.heard.following(wanted, recording=self.recording, events=0)
        return wanted

    def publish(self, row: Array) -> None: ...

    def event(self, text: str) -> None:
        self.lines.append(text)

    def is_alive(self) -> bool:
        return self.recording


class KeepingDriver(SimulatedDriver):
    """Driver of a virtual rig that keeps the last reading and command."""

    reading: SensorReading
    command: RigCommand

    def read(self) -> SensorReading:
        self.reading = super().read()
        return self.reading

    def write(self, command: RigCommand) -> None:
        self.command = command
        super().write(command)


def numbers_after(core: CycleCore) -> Array:
    """Return memory and results of a cycle, in the order of the structs of C."""
    rows, law = core.rows, core.law
    parts = (
        rows.memory, rows.joints, law.memory.array[0], rows.results, rows.commands, rows.events, law.report.array
    )  # fmt: skip
    return np.concatenate([part.ravel() for part in parts])


def run_cycles(machine: Machine, seconds: float, seed: int = 0) -> Iterator[Cycle]:
    """Yield the cycles of a loop: in each round it starts, moves, fails, is healed and reset.

    Args:
        machine: the machine.
        seconds: simulated time.
        seed: seed of demands, noise and joints.
    """
    rng, clock, n = np.random.default_rng(seed), VirtualClock(), len(machine.joints)
    device = VirtualRig(machine, seed)(clock)
    driver, host = KeepingDriver(device), ScriptedHost(n)
    driver.configure()
    driver.activate()
    loop = RigLoop(machine, driver, clock, host, host)
    half = np.array([0.5 * joint.stops.working_stroke for joint in machine.joints.values()])
    each, kept, cycle_ns = round(ROUND / machine.cycle), 0, round(machine.cycle * NS_PER_SECOND)

    def due(seconds: float, k: int) -> bool:
        return k % each == round(seconds / machine.cycle)

    for k in range(round(seconds / machine.cycle)):
        name, size = FAILURES[k // each % len(FAILURES)]
        joint, failure = k // each % n, get_failure(name)
        if due(0.05, k) or due(STARTS_AFTER, k):
            host.wanted = host.wanted._replace(start=True)
        if due(RESETS_AFTER, k):
            host.wanted = host.wanted._replace(reset=True, demands=[nan] * n, velocities=None)
        if due(FAILS_AFTER, k):
            failure.inject(device, joint, size)
        if due(HEALS_AFTER, k):
            failure.heal(device, joint)
        if loop.supervisor.state in {RigState.READY, RigState.MOVING} and k % DEMAND_CYCLES == 0:
            moving = rng.random() < 0.3
            host.wanted = host.wanted._replace(
                demands=(rng.uniform(-0.8, 0.8, n) * half).tolist(), age=0.01 * rng.random(),
                velocities=rng.uniform(-0.3, 0.3, n).tolist() if moving else None, since=0.02 * rng.random(),
                switched=[(j, bool(rng.integers(2))) for j in range(len(machine.interface.outputs))],
            )  # fmt: skip
        if rng.random() < 0.002:  # the loop is late, by part of a cycle or by some
            clock.wait(clock.now() + round(rng.uniform(1.0, 3.0) * cycle_ns / 1000) * 1000)
        loop.cycle()
        core = loop.supervisor.core
        yield Cycle(
            clock.now() // 1000, driver.reading, host.heard, driver.command,
            np.concatenate([core.rows.inputs, core.rows.samples.ravel()]), numbers_after(core),
            loop.layout.joint_rows(loop.row).copy(), host.lines[kept:],
        )  # fmt: skip
        kept = len(host.lines)


def counts_of(wire: Wire, reading: SensorReading) -> list[int]:
    """Return the counts of a reading: supply, then angle and pressure of each joint."""
    joints = zip(reading.angles.tolist(), reading.pressures.tolist(), strict=True)
    return [
        wire.supply.count(reading.supply),
        *(count for angle, pressure in joints for count in (wire.angle.count(angle), wire.pressure.count(pressure))),
    ]


def request_frame(requests: RequestWire, number: int, request: DeviceRequest) -> bytes:
    """Return a request as a frame."""
    return frames.encode(frames.REQUEST_FRAME, number & 0xFFFF, requests.request_bytes(request))
