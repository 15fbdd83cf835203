"""What a sound rig is asked for: random steps and, of control laws that plan their motion, motions and belts."""

from collections.abc import Iterator
from math import pi, sqrt

import numpy as np
from scipy.interpolate import CubicSpline

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.motion.belt import follow_belt
from layflat.motion.inverse import Inverse
from layflat.motion.kinematics import tip_position
from layflat.motion.trajectory import QUINTIC_PEAKS, States, quintic
from layflat.rig.abilities import demand_limits
from layflat.rig.clock import SECOND
from layflat.rig.safety.supervisor import HostRequest
from layflat.rig.smooth import smooth
from layflat.rig.trials.rig import Script

SPAN = 0.9  # of the working stroke in which moves end
PAUSE = (0.1, 4.0)  # between two demands, s
MOTIONS, BELTS = 0.2, 0.2  # shares of the demands that are motions of the joints, and that follow a belt
HARD = 0.6  # of what every posture can do that motions ask for
BELT_SPEED, BELT_ACCELERATION = (0.05, 0.5), 4.0  # m/s, m/s2
BELT_TURNS = (0.2, 1.5)  # after which a belt turns round, and after which it stops, s
PLANE = 2  # axes of a tip that moves in a plane
LINE, NODES = (0.1, 0.5), 17  # lengths of lines in space, m, and postures that one is laid through


class RandomWork(Script):
    """A host that asks for another place, or another motion, now and then; its random numbers are given."""

    def __init__(self, machine: Machine, random: np.random.Generator) -> None:
        super().__init__(len(machine.joints))
        self.moves = 0
        self._machine, self._random = machine, random
        self._half = np.array([0.5 * SPAN * joint.stops.working_stroke for joint in machine.joints.values()])
        self._moves_on = machine.control_law.plans
        self._next = 0
        self._rows: Iterator[tuple[Array, Array, Array]] = iter(())

    def ask(self, now: int) -> None:
        """Ask for what is due in the cycle that begins now (ns)."""
        if now >= self._next:
            self._next = now + round(self._random.uniform(*PAUSE) * SECOND)
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
        """Return what is wanted now."""
        asked = super().request(now)
        return asked if self.rates is None else asked._replace(velocities=self.rates[0], accelerations=self.rates[1])

    @property
    def rests(self) -> bool:
        """True if what is asked for now does not move."""
        return self.rates is None or not (any(self.rates[0]) or any(self.rates[1]))

    rates: tuple[list[float], list[float]] | None = None

    def _motion(self) -> States | None:
        """Return a motion from the last demand on, or None for a step."""
        kind, start = self._random.uniform(), np.array(self.demands)
        if not np.isfinite(start).all() or kind > MOTIONS + BELTS:
            return None
        if kind < MOTIONS:
            return smooth(self._machine, start, self._random.uniform(-self._half, self._half), HARD)
        tip = tip_position(self._machine, start)
        if len(tip) > PLANE:
            return self._line(start, tip)
        turns, goes_back = self._random.uniform(*BELT_TURNS, 2)
        speed = self._random.uniform(*BELT_SPEED)
        speeds = [(0.0, speed), (1.0 + turns, -speed), (2.0 + turns + goes_back, 0.0)]
        try:
            belt = follow_belt(self._machine, start, self._random.uniform(-pi, pi), speeds, BELT_ACCELERATION)
        except LayflatError:  # it begins at the border, or the arm has no tip that moves in a plane
            return None
        return belt.rows(self._machine.cycle)

    def _line(self, start: Array, tip: Array) -> States | None:
        """Return a motion of the tip (m) along a straight line in space and back, or None where its reach ends."""
        way, speed = self._random.normal(size=PLANE + 1), self._random.uniform(*BELT_SPEED)
        length = self._random.uniform(*LINE)
        nodes = np.linspace(0.0, length, NODES)
        found = Inverse(self._machine).near(tip + nodes[:, None] * way / np.linalg.norm(way), start)
        if not found.there.all() or (np.abs(found.angles) > self._half).any():
            return None
        q = CubicSpline(nodes, found.angles)
        T = max(QUINTIC_PEAKS[0] * length / speed, sqrt(QUINTIC_PEAKS[1] * length / BELT_ACCELERATION))
        slower = 1.0
        for _ in range(2):
            T *= slower
            s, v, a = quintic(np.arange(0.0, T + self._machine.cycle, self._machine.cycle)[:, None] / T)
            x, u, w = length * s[:, 0], length * v / T, length * a / T**2
            rows = States(q(x), q(x, 1) * u, q(x, 2) * u**2 + q(x, 1) * w)
            slower = harder(self._machine, rows)
        return States(*(np.concatenate([of, sign * of[::-1]]) for of, sign in zip(rows, (1.0, -1.0, 1.0), strict=True)))


def harder(machine: Machine, rows: States) -> float:
    """Return how much more time a motion would have to take, to ask of no joint more than `HARD`; at least 1."""
    can = demand_limits(machine)
    speed = (np.abs(rows[1]) / (HARD * can.speed)).max()
    acceleration = (np.abs(rows[2]) / (HARD * can.braking)).max()
    return max(1.0, float(speed), sqrt(float(acceleration)))
