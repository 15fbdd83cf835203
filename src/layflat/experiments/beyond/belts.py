"""How closely the tip follows a belt that goes to and fro."""

from dataclasses import dataclass

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.belt import follow_belt
from layflat.motion.kinematics import tip_position
from layflat.motion.reach import Reach
from layflat.sim import rollout

PLACE, LENGTH = 0.55, 0.36  # of the belt before the arm's base, and of the way to and fro on it, as shares of the reach
ACCELERATION = 3.0  # of the belt, m/s2
SECONDS, CAUGHT = 4.0, 1.0  # of a run, and from when on it counts
UPWARDS = np.pi / 2


@dataclass(frozen=True)
class Following:
    """Distances of the tip from a belt, m, under a law at a speed (m/s)."""

    law: str
    speed: float
    distances: Array

    @property
    def rms(self) -> float:
        """Their root mean square, m."""
        return float(np.sqrt(np.mean(self.distances**2)))

    @property
    def most(self) -> float:
        """The greatest, m."""
        return float(self.distances.max())


def following(law: str, machine: Machine, speed: float, seeds: int) -> Following:
    """Return how closely a machine with a planar arm of two joints follows a belt with so many noises.

    The arm is told angle, velocity and acceleration of its joints; the belt turns round at both ends.
    """
    angles, velocities, accelerations = to_and_fro(machine, speed)
    wanted, first = tip_position(machine, angles), round(CAUGHT / machine.cycle)
    found = []
    for seed in range(seeds):
        run = rollout(
            machine, angles, demand_velocity=velocities, demand_acceleration=accelerations,
            duration=len(angles) * machine.cycle, start=_elsewhere(angles[0]), seed=seed,
        )  # fmt: skip
        apart = np.linalg.norm(tip_position(machine, run["angle"].to_numpy()[:-1]) - wanted, axis=1)
        found.append(apart[first:])
    return Following(law, speed, np.concatenate(found))


def to_and_fro(machine: Machine, speed: float) -> tuple[Array, Array, Array]:
    """Return angles, velocities and accelerations (cycles, joints) of an arm of two joints whose tip is on the belt."""
    reach, size = Reach(machine), sum(joint.planar_link.length for joint in machine.joints.values())
    x, low, way = PLACE * size, 0.02 * size, LENGTH * size
    start = np.array(reach.postures(x, low)[0].angles)
    lasts = way / speed
    turns = [(k * lasts, speed if k % 2 == 0 else -speed) for k in range(int(SECONDS / lasts))]
    motion = follow_belt(machine, start, UPWARDS, [*turns, (len(turns) * lasts, 0.0)], ACCELERATION)
    angles, velocities, accelerations = motion.rows(machine.cycle)
    return angles, velocities, accelerations


def _elsewhere(start: Array) -> list[float]:
    """Return a posture beside the belt, from which it is caught up with."""
    found: list[float] = (start - np.sign(start) * np.radians(10.0)).tolist()
    return found
