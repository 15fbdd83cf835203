"""The paper's experiments with many machines at once: the errors that their joints make after a step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import radians
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.experiments.bench import INERTIA_PER_TORQUE, Bench, maximum_torque, payload_for_inertia
from layflat.experiments.calibration.unknowns import known_to
from layflat.experiments.limits import AT, STEP
from layflat.experiments.open_loop import SMALL_SWEEP
from layflat.experiments.two_axis import END, FIRST, HALF, SECOND
from layflat.machine import Machine
from layflat.sim import Scenario
from layflat.sim.ensemble.cases import cases
from layflat.sim.ensemble.loops import heights
from layflat.sim.ensemble.parallel import traced

COARSE = 1e-3  # step of the plant while searching, s: it ranks machines as well as the default does
WATCHED = 9.5  # how long a joint is watched after its step, s
RATIOS: Array = np.geomspace(INERTIA_PER_TORQUE, 1e-1, 11)
"""Inertia per torque with which the braked joint moves, kg m2 per N m."""
EARLIER: Array = np.geomspace(INERTIA_PER_TORQUE, 4e-2, 8)
"""The same of the earlier actuator, whose limit is to be half as large."""
REPEATS = 3  # runs with each, with other noise
UNBRAKED = 2  # runs of the new joint without brake
LOST = radians(1e3)  # error of a joint that diverged, rad


@dataclass(frozen=True)
class Steps:
    """Errors after a step of a joint alone, rad, (machines, runs, records); records are a cycle (s) apart."""

    cycle: float
    unbraked: Array  # the new joint without brake, at the inertia of the paper's comparison
    braked: Array  # with its brake and the paper's 2 kg: one run
    carried_braked: Array  # with its brake, `REPEATS` runs with each of `RATIOS`, one after the other
    carried_earlier: Array  # the earlier actuator with each of `EARLIER`, the first of them that of the comparison


@dataclass(frozen=True)
class Evidence:
    """The paper's machines, in which values take the place of others."""

    bench: Bench

    @cached_property
    def scale(self) -> float:
        """Maximum torque of the earlier actuator over that of the new joint: its pressure gains follow it."""
        return self._torque(self.bench.earlier) / self._torque(self.bench.axis_one)

    def steps(self, values: Mapping[str, Array], seed: int, step: float = COARSE) -> Steps:
        """Let joints alone make a step of 40 deg, as in Fig. 13 and with other inertias.

        Args:
            values: numbers (SI) by path, an item a machine.
            seed: of the noise.
            step: of the plant, s.
        """
        new, earlier = self.bench.axis_one, self.bench.earlier
        compared = self._payloads(new, [INERTIA_PER_TORQUE] * UNBRAKED)
        carried = np.repeat(self._payloads(new, RATIOS), REPEATS)
        payloads = np.concatenate([compared, [new.arm.payload], carried])
        brakes = np.concatenate([np.zeros(UNBRAKED), np.ones(1 + len(carried))])
        found = _stepped(new, values, payloads, brakes, seed, step)
        payloads = np.repeat(self._payloads(earlier, EARLIER), REPEATS)
        scaled = {path: self.scale * one if _is_pressure_gain(path) else one for path, one in values.items()}
        old = _stepped(earlier, scaled, payloads, np.zeros(len(payloads)), seed + 1, step)
        at = UNBRAKED + 1
        return Steps(new.cycle, found[:, :UNBRAKED], found[:, UNBRAKED:at], found[:, at:], old)

    def arm_moves(self, values: Mapping[str, Array], seed: int, step: float = COARSE) -> Array:
        """Let the arm make a step of each joint in turn, either way, as in Fig. 14.

        Returns angles, rad, (machines, ways, records, joints), the second way with the opposite sign.
        """
        ways = []
        for half in (HALF, -HALF):
            demand: list[tuple[str | float, Any]] = [
                (0.0, (-half, -half)),
                (FIRST, (half, -half)),
                (SECOND, (half, half)),
            ]
            count = len(next(iter(values.values())))
            vary = dict(values) | {"seed": np.full(count, float(seed))}
            angles = traced(self.bench.arm, Scenario(demand=demand, duration=END), vary, ("angle",), step=step)[..., 0]
            ways.append(np.sign(half) * np.nan_to_num(angles, nan=LOST))
        return np.stack(ways, axis=1)

    def small_motion(self, values: Mapping[str, Array]) -> Array:
        """Return the share of its curve's height that the earlier actuator keeps in a small motion, (machines,)."""
        earlier = self.bench.earlier
        prepared = cases(earlier, [Scenario()], known_to(earlier, values), None)
        small, _ = heights(prepared, SMALL_SWEEP)
        whole, _ = heights(prepared)
        return np.asarray(small[:, 0] / whole[:, 0])

    def _payloads(self, machine: Machine, ratios: Sequence[float] | Array) -> Array:
        torque = self._torque(machine)
        return np.array([payload_for_inertia(machine, "small", ratio * torque) for ratio in ratios])

    @staticmethod
    def _torque(machine: Machine) -> float:
        return maximum_torque(machine, "small")


def _is_pressure_gain(path: str) -> bool:
    return ".gains." in path and path.endswith(".pressure")


def _stepped(
    machine: Machine, values: Mapping[str, Array], payloads: Array, brakes: Array, seed: int, step: float
) -> Array:
    """Errors from the step on, rad, (machines, runs, records): each machine with each payload and its brake."""
    own = known_to(machine, values)
    machines, runs = len(next(iter(own.values()))), len(payloads)
    vary = {path: np.repeat(one, runs) for path, one in own.items()}
    vary |= {"arm.payload": np.tile(payloads, machines), "scenario.brake": np.tile(brakes, machines)}
    vary["seed"] = np.tile(seed + np.arange(runs, dtype=float), machines)
    scenario = Scenario(demand=[(0.0, -STEP / 2), (AT, STEP / 2)], duration=AT + WATCHED)
    angles = traced(machine, scenario, vary, ("angle",), step=step)[:, round(AT / machine.cycle) :, 0, 0]
    return np.asarray(np.nan_to_num(angles - STEP / 2, nan=LOST).reshape(machines, runs, -1))
