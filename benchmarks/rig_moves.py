"""A rig's moves with the tracking controller: how soon the tip rests after steps, and how closely it follows a belt.

    python -m benchmarks.rig_moves [MOVES]

Steps of 40 degrees in sixteen postures and belts of 0.3 m/s, through loop and supervisor, with the simulated driver and
over the real protocols: device and loop are in processes of their own and in step, so that time is the rig's.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.experiments.beyond.moves import belt_motion, move_sequences
from layflat.machine import Machine, changed, load
from layflat.motion.kinematics import tip_position
from layflat.rig.clock import VirtualClock
from layflat.rig.device.process import DeviceProcess, ModbusPort, SerialPort
from layflat.rig.device.virtual import SimulatedDriver
from layflat.rig.driver import Driver
from layflat.rig.drivers import create_driver
from layflat.rig.loop import RigLoop
from layflat.rig.safety.supervisor import HostRequest
from layflat.rig.trials.rig import ScriptedHost, SharedClock
from layflat.virtual_rig import VirtualRig

CLOSE, PAUSE, TO_START = 2e-3, 1.5, 2.0  # m; s after a step; s until the arm is where a trial begins
DRIVERS = ("simulated", "modbus", "serial")
STARTS = 4.0  # a soft start takes less, s


class Streamed(ScriptedHost):
    """A host that streams angles with their rates, or angles alone."""

    rates: tuple[list[float], list[float]] | None = None

    def request(self, now: int) -> HostRequest:
        """Return the host's request at an instant."""
        asked = super().request(now)
        return asked if self.rates is None else asked._replace(velocities=self.rates[0], accelerations=self.rates[1])


class Bench:
    """A loop and what it moves, in step; the angles of the arm as they are in truth."""

    def __init__(self, machine: Machine, loop: RigLoop, host: Streamed, angles: Callable[[], Any]) -> None:
        self.machine, self.loop, self.host, self._angles = machine, loop, host, angles

    def at(self) -> Array:
        """Joint angles, rad."""
        return np.array(self._angles())

    def go(self, angles: Array, seconds: float) -> Array:
        """Ask for a place, and return where the joints are at every cycle until so long after, rad."""
        self.host.demands, self.host.rates, found = angles.tolist(), None, []
        for _ in range(round(seconds / self.machine.cycle)):
            self.loop.cycle()
            found.append(self.at())
        return np.array(found)

    def follow(self, motion: tuple[Array, Array, Array], *, rates: bool) -> Array:
        """Ask for angles (cycles, joints) with their rates; return where the joints are when each is asked for, rad."""
        found = []
        for angles, velocities, accelerations in zip(*motion, strict=True):
            self.host.demands = angles.tolist()
            self.host.rates = (velocities.tolist(), accelerations.tolist()) if rates else None
            self.loop.cycle()
            found.append(self.at())
        return np.array(found)


@contextmanager
def bench(machine: Machine, driver: str, seed: int) -> Iterator[Bench]:
    """A rig with air, moved over a driver."""
    host = Streamed(len(machine.joints))
    with ExitStack() as stack:
        made: Driver
        clock: Any = VirtualClock()
        if driver == "simulated":
            device = VirtualRig(machine, seed)(clock)
            made, angles = SimulatedDriver(device), lambda: device.plant.angles
        else:
            machine = changed(machine, f"interface.{driver}.timeout", 0.5)
            port = ModbusPort() if driver == "modbus" else SerialPort()
            served = stack.enter_context(DeviceProcess(VirtualRig(machine, seed), machine, port, lockstep=True))
            clock = SharedClock(served)
            made, angles = create_driver(served.address, machine), lambda: clock.truth.angles
        made.configure()
        loop = RigLoop(machine, made, clock, host)
        made.activate()
        stack.callback(made.finalize)
        loop.cycle()
        host.edges = {"reset"}
        for _ in range(20):
            loop.cycle()
        host.edges = {"start"}
        for _ in range(round(STARTS / machine.cycle)):
            loop.cycle()
        yield Bench(machine, loop, host, angles)


def settling(machine: Machine, angles: Array, goal: Array) -> float:
    """Time from which on the tip is within 2 mm of its goal, s; infinite where it is not in the end."""
    off = np.linalg.norm(tip_position(machine, angles) - tip_position(machine, goal[None]), axis=1)
    last = np.flatnonzero(off > CLOSE)
    if len(last) and last[-1] == len(off) - 1:
        return float("inf")
    return float(machine.cycle * (last[-1] + 1 if len(last) else 0))


def steps(at: Bench, count: int) -> Array:
    """Settling times of so many steps in each posture, s."""
    found = []
    for scenario in move_sequences(at.machine, count):
        demand: Any = scenario.demand
        places = [np.array(angles) for _, angles in demand]
        at.go(places[0], TO_START)
        found += [settling(at.machine, at.go(place, PAUSE), place) for place in places[1:]]
    return np.array(found)


def distances(at: Bench, speed: float, *, rates: bool) -> Array:
    """Distance of the tip from what it follows, from a second after it set out on, m."""
    motion, machine = belt_motion(at.machine, speed), at.machine
    at.go(motion[0][0], TO_START)
    found = at.follow(motion, rates=rates)
    off: Array = np.linalg.norm(tip_position(machine, found) - tip_position(machine, motion[0]), axis=1)
    return off[round(1.0 / at.machine.cycle) :]


if __name__ == "__main__":
    count, arm = int(sys.argv[1]) if len(sys.argv) > 1 else 2, load("paper-arm-tracking")
    for name in DRIVERS:
        with bench(arm, name, 0) as at:
            found = steps(at, count)
            tail = np.quantile(found, 0.95, method="higher")
            print(
                f"{name:10s} {len(found)} steps: {np.median(found):.3f} s, 95 % {tail:.3f} s, worst {found.max():.3f} s"
            )
            for rates in (True, False):
                off = 1e3 * distances(at, 0.3, rates=rates)
                how, rms = "given" if rates else "derived", np.sqrt(np.mean(off * off))
                print(f"{'':10s} belt, rates {how}: {rms:.2f} mm rms, {off.max():.2f} mm at most")
            print(f"{'':10s} {at.loop.supervisor.state.name}, {at.loop.supervisor.ledger.worst.title}", flush=True)
