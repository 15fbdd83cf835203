"""Soak test: a rig without a fault in random motion for hours, in which no fault may be detected."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import pi, sqrt

import numpy as np
from scipy.interpolate import CubicSpline

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.motion.belt import follow_belt
from layflat.motion.inverse import InverseKinematics
from layflat.motion.kinematics import tip_position
from layflat.motion.trajectory import QUINTIC_PEAKS, States, quintic
from layflat.rig.abilities import demand_limits, falls_without_air, payload_range, plan_smooth_motion
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device.virtual import SimulatedDriver, VirtualDevice
from layflat.rig.driver import Driver
from layflat.rig.loop import RigLoop
from layflat.rig.safety.faults import Reaction, RigState
from layflat.rig.safety.supervisor import HostRequest
from layflat.rig.trials.rig import ScriptedHost

STROKE_FRACTION = 0.9  # of the working stroke in which moves end
PAUSE_RANGE = (0.1, 4.0)  # between two demands, s
MOTION_FRACTION, BELT_FRACTION = 0.2, 0.2  # of the demands that are motions of the joints, and that follow a belt
EFFORT_FRACTION = 0.6  # of the speed and acceleration of every configuration that motions demand
BELT_SPEED, BELT_ACCELERATION = (0.05, 0.5), 4.0  # m/s, m/s2
BELT_TURN_RANGE = (0.2, 1.5)  # after which a belt reverses, and after which it stops, s
PLANE_AXES = 2  # axes of a tip that moves in a plane
LINE_LENGTH_RANGE, LINE_NODES = (0.1, 0.5), 17  # lengths of lines in space, m, and configurations along one
PAYLOAD_EVERY = 5.0  # mean time between two changes of the payload, s
STATIONARY_SPEED = 0.01  # of joints, up to which an arm is stationary, rad/s


class RandomWork(ScriptedHost):
    """Host that demands another configuration, or another motion, now and then, by a random generator."""

    def __init__(self, machine: Machine, random: np.random.Generator) -> None:
        super().__init__(len(machine.joints))
        self.moves = 0
        self._machine, self._random = machine, random
        self._half = np.array([0.5 * STROKE_FRACTION * joint.stops.working_stroke for joint in machine.joints.values()])
        self._moves_on = machine.control_law.plans
        self._next = 0
        self._rows: Iterator[tuple[Array, Array, Array]] = iter(())

    def send_due_demand(self, now: int) -> None:
        """Set the demand that is due in the cycle that begins at `now`, ns: of the present motion, or a new one."""
        if now >= self._next:
            self._next = now + round(self._random.uniform(*PAUSE_RANGE) * NS_PER_SECOND)
            self._rows = iter(())
            self.moves += 1
            states = self._motion() if self._moves_on else None
            if states is None:
                self.demands, self.rates = self._random.uniform(-self._half, self._half).tolist(), None
            else:
                self._rows = zip(*states, strict=True)
        row = next(self._rows, None)
        if row is not None:
            self.demands, self.rates = row[0].tolist(), (row[1].tolist(), row[2].tolist())

    def request(self, now: int) -> HostRequest:
        """Return the host's request at `now` (ns), with velocities (rad/s) and accelerations (rad/s2) of its motion."""
        request = super().request(now)
        if self.rates is None:
            return request
        return request._replace(velocities=self.rates[0], accelerations=self.rates[1])

    @property
    def is_resting(self) -> bool:
        """Return whether the present demand does not move."""
        return self.rates is None or not (any(self.rates[0]) or any(self.rates[1]))

    rates: tuple[list[float], list[float]] | None = None

    def _motion(self) -> States | None:
        """Return a random motion from the last demand on; None for a step, also where the motion is not possible."""
        kind, start = self._random.uniform(), np.array(self.demands)
        if not np.isfinite(start).all() or kind > MOTION_FRACTION + BELT_FRACTION:
            return None
        if kind < MOTION_FRACTION:
            return plan_smooth_motion(
                self._machine, start, self._random.uniform(-self._half, self._half), EFFORT_FRACTION
            )
        tip = tip_position(self._machine, start)
        if len(tip) > PLANE_AXES:
            return self._line(start, tip)
        turns, goes_back = self._random.uniform(*BELT_TURN_RANGE, 2)
        speed = self._random.uniform(*BELT_SPEED)
        speeds = [(0.0, speed), (1.0 + turns, -speed), (2.0 + turns + goes_back, 0.0)]
        try:
            belt = follow_belt(self._machine, start, self._random.uniform(-pi, pi), speeds, BELT_ACCELERATION)
        except LayflatError:  # it starts at the border, or the arm has no tip that moves in a plane
            return None
        return belt.rows(self._machine.cycle)

    def _line(self, start: Array, tip: Array) -> States | None:
        """Return a motion from angles `start` (rad), in which the tip (m) goes along a random line in space and back.

        None where the line leaves the reach or `STROKE_FRACTION` of the strokes.
        """
        way, speed = self._random.normal(size=PLANE_AXES + 1), self._random.uniform(*BELT_SPEED)
        length = self._random.uniform(*LINE_LENGTH_RANGE)
        nodes = np.linspace(0.0, length, LINE_NODES)
        found = InverseKinematics(self._machine).solve_near(tip + nodes[:, None] * way / np.linalg.norm(way), start)
        if not found.reached.all() or (np.abs(found.angles) > self._half).any():
            return None
        q = CubicSpline(nodes, found.angles)
        T = max(QUINTIC_PEAKS[0] * length / speed, sqrt(QUINTIC_PEAKS[1] * length / BELT_ACCELERATION))
        slower = 1.0
        for _ in range(2):
            T *= slower
            s, v, a = quintic(np.arange(0.0, T + self._machine.cycle, self._machine.cycle)[:, None] / T)
            x, u, w = length * s[:, 0], length * v / T, length * a / T**2
            rows = States(q(x), q(x, 1) * u, q(x, 2) * u**2 + q(x, 1) * w)
            slower = required_stretch(self._machine, rows)
        return States(*(np.concatenate([of, sign * of[::-1]]) for of, sign in zip(rows, (1.0, -1.0, 1.0), strict=True)))


def required_stretch(machine: Machine, rows: States) -> float:
    """Return the factor, at least 1, by which a motion's time must grow to keep to `EFFORT_FRACTION` of its limits.

    The limits are the speed and the deceleration that each joint has in every configuration (`demand_limits`).

    Args:
        machine: machine that moves.
        rows: states of the motion, (samples, joints) each.
    """
    can = demand_limits(machine)
    speed = (np.abs(rows[1]) / (EFFORT_FRACTION * can.speed)).max()
    acceleration = (np.abs(rows[2]) / (EFFORT_FRACTION * can.braking)).max()
    return max(1.0, float(speed), sqrt(float(acceleration)))


@dataclass
class SoakResult:
    """Result of a soak test."""

    hours: float  # of simulated time
    moves: int = 0  # number of demands
    payloads: int = 0  # number of payloads
    messages: list[str] = field(default_factory=list)  # false alarms
    trips: int = 0  # number of false alarms that held or vented the rig


def run_soak(
    machine: Machine, device_of: Callable[[VirtualClock], VirtualDevice], hours: float, seed: int,
    progress: Callable[[float], None] | None = None, clock: VirtualClock | None = None,
    driver_of: Callable[[VirtualDevice], Driver] = SimulatedDriver,
) -> SoakResult:  # fmt: skip
    """Move at random for hours of simulated time, and count the faults that hold or vent the rig; each is then reset.

    The payload of an arm that would fall changes only while it rests: in motion that throws it out of its stroke, which
    is no false alarm.

    Args:
        machine: description of the rig.
        device_of: function that creates a device without a failure on a clock.
        hours: duration, hours of simulated time.
        seed: seed of moves and payloads.
        progress: called with the fraction that is done, 0..1.
        clock: clock of the loop; default: one that is never late.
        driver_of: creates the driver of a device.
    """
    clock, random = clock or VirtualClock(), np.random.default_rng(seed)
    host = RandomWork(machine, random)
    device = device_of(clock)
    driver = driver_of(device)
    driver.configure()
    loop = RigLoop(machine, driver, clock, host)
    driver.activate()
    supervisor = loop.supervisor
    result, (lightest, heaviest), thrown = SoakResult(hours), payload_range(machine), falls_without_air(machine)
    end, next_payload, shown = round(hours * 3600 * NS_PER_SECOND), 0, 0
    while clock.now() < end:
        now, before = clock.now(), supervisor.state
        if before in {RigState.OFF, RigState.FAULT, RigState.STOPPED}:
            host.edges = {"reset"} if before is RigState.FAULT else {"start"}
        host.send_due_demand(now)
        stands = not thrown or (host.is_resting and bool(np.abs(device.plant.velocities).max() < STATIONARY_SPEED))
        if lightest < heaviest and now >= next_payload and stands:
            next_payload = now + round(random.exponential(PAYLOAD_EVERY) * NS_PER_SECOND)
            device.plant.payload = random.uniform(lightest, heaviest)
            result.payloads += 1
        loop.cycle()
        if before is not RigState.FAULT:
            result.trips += supervisor.state is RigState.FAULT
            if supervisor.ledger.now and supervisor.ledger.reaction > Reaction.WARN:
                result.messages.append(f"{now / NS_PER_SECOND:.2f} s: {supervisor.ledger.now.name}")
        if progress is not None and now - shown > NS_PER_SECOND:
            shown = now
            progress(now / end)
    driver.finalize()
    result.moves = host.moves
    return result
