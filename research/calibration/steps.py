"""Steps of joints alone, with many machines at once: those of Fig. 13, and with growing inertia."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import radians

import numpy as np

from layflat.arrays import Array
from layflat.experiments.axis_one import AT, RATIOS, STEP, SWING
from layflat.experiments.bench import INERTIA_PER_TORQUE, Bench, maximum_torque, payload_for_inertia
from layflat.machine import Machine
from layflat.motion.scenario import Scenario
from layflat.sim.ensemble.parallel import traced
from layflat.sim.metrics import BAND
from research.calibration.effort import Effort
from research.calibration.kernels import looked_at
from research.calibration.unknowns import known_to

WATCHED = 9.5  # how long a joint is watched after its step, s
MOST, MOST_EARLIER = RATIOS[-1], RATIOS[15]  # largest inertia per torque with which a joint moves, kg m2 per N m
UNBRAKED = 2  # runs of the new joint without brake
REST = 1.0  # a joint has settled if it stays inside for so long, s
LOST = radians(1e3)  # error of a joint that diverged, rad


@dataclass(frozen=True)
class Carried:
    """What runs with a brake's share come to, (machines, runs, repeats)."""

    ratios: Array  # inertia per torque of each run, kg m2 per N m
    time: Array  # until the joint stays within the band, s; infinite unless a second is left
    swing: Array  # peak to peak over the last two seconds, rad
    late: Array  # rms of the error over the last four seconds, rad


def carried(error: Array, ratios: Array, cycle: float) -> Carried:
    """Return what errors (machines, runs times repeats, records), rad, come to."""
    machines, _, records = error.shape
    found = looked_at(error.reshape(-1, records), BAND, round(SWING / cycle), LOST)
    found = found.reshape(machines, len(ratios), -1, 3)
    time = found[..., 0] * cycle
    return Carried(ratios, np.where(time > records * cycle - REST, np.inf, time), found[..., 1], found[..., 2])


@dataclass(frozen=True)
class Compared:
    """What joints alone do after a step, with the inertia by which the paper compares them (Fig. 13)."""

    cycle: float  # s, by which records are apart
    unbraked: Array  # errors of the new joint without brake, rad, (machines, runs, records)
    braked: Carried  # the new joint with its brake and the paper's 2 kg: one run
    earlier: Carried  # the earlier actuator


@dataclass(frozen=True)
class Loaded:
    """The same with growing inertia."""

    cycle: float  # s
    braked: Carried  # the new joint with its brake
    earlier: Carried  # the earlier actuator


@dataclass(frozen=True)
class Steps:
    """Joints alone, in which values take the place of others; with seed 1 their noise is that of the claims."""

    bench: Bench

    @cached_property
    def scale(self) -> float:
        """Maximum torque of the earlier actuator over that of the new joint: its pressure gains follow it."""
        return self._torque(self.bench.earlier) / self._torque(self.bench.axis_one)

    def compared(self, values: Mapping[str, Array], seed: int, effort: Effort) -> Compared:
        """Let joints alone make a step of 40 deg, with the inertia by which the paper compares them.

        Args:
            values: numbers (SI) by path, an item a machine.
            seed: of the noise.
            effort: how closely they are looked at.
        """
        new, ratio = self.bench.axis_one, np.array([INERTIA_PER_TORQUE])
        payloads = np.append(self._payloads(new, np.repeat(ratio, UNBRAKED)), new.arm.payload)
        brakes = np.append(np.zeros(UNBRAKED), 1.0)
        seeds = seed + np.append(np.arange(UNBRAKED), 0)
        found = _stepped(new, values, payloads, brakes, seeds, effort.step)
        lost = np.nan_to_num(found[:, :UNBRAKED], nan=LOST)
        braked = carried(found[:, UNBRAKED:], np.zeros(1), new.cycle)
        return Compared(new.cycle, lost, braked, self._earlier(values, ratio, np.array([float(seed)]), effort))

    def loaded(self, values: Mapping[str, Array], seed: int, effort: Effort) -> Loaded:
        """Let them make the same step with growing inertia; arguments as of `compared`.

        With another seed each inertia lies elsewhere between its neighbours, unless the effort says otherwise.
        """
        new = self.bench.axis_one
        shift = float(np.random.default_rng(seed).uniform(-0.5, 0.5)) if effort.elsewhere else 0.0
        ratios, ratios_earlier = (
            _spread(most, count, shift) for most, count in zip((MOST, MOST_EARLIER), effort.counts, strict=True)
        )
        seeds = np.asarray(seed - 1.0 + np.arange(effort.repeats))
        payloads = np.repeat(self._payloads(new, ratios), len(seeds))
        noise = np.tile(seeds, len(ratios))
        found = _stepped(new, values, payloads, np.ones(len(payloads)), noise, effort.step)
        braked = carried(found, ratios, new.cycle)
        return Loaded(new.cycle, braked, self._earlier(values, ratios_earlier, seeds, effort))

    def _earlier(self, values: Mapping[str, Array], ratios: Array, seeds: Array, effort: Effort) -> Carried:
        """The step of the earlier actuator, whose controller's pressure gains follow its torque."""
        earlier = self.bench.earlier
        payloads, noise = np.repeat(self._payloads(earlier, ratios), len(seeds)), np.tile(seeds, len(ratios))
        scaled = {path: self.scale * one if _is_pressure_gain(path) else one for path, one in values.items()}
        found = _stepped(earlier, scaled, payloads, np.zeros(len(payloads)), noise, effort.step)
        return carried(found, ratios, earlier.cycle)

    def _payloads(self, machine: Machine, ratios: Sequence[float] | Array) -> Array:
        torque = self._torque(machine)
        return np.array([payload_for_inertia(machine, "small", ratio * torque) for ratio in ratios])

    @staticmethod
    def _torque(machine: Machine) -> float:
        return maximum_torque(machine, "small")


def _spread(most: float, count: int, shift: float) -> Array:
    """Inertias per torque in geometric progression, those between both ends shifted by a share of their distance."""
    places = np.arange(count, dtype=float)
    places[1:-1] += shift
    return np.asarray(INERTIA_PER_TORQUE * (most / INERTIA_PER_TORQUE) ** (places / (count - 1)))


def _is_pressure_gain(path: str) -> bool:
    return ".gains." in path and path.endswith(".pressure")


def _stepped(
    machine: Machine, values: Mapping[str, Array], payloads: Array, brakes: Array, seeds: Array, step: float
) -> Array:
    """Errors from the step on, rad, (machines, runs, records): each machine with each payload, its brake and noise.

    They are not numbers from where a run diverged.
    """
    own = known_to(machine, values)
    machines, runs = len(next(iter(own.values()))), len(payloads)
    vary = {path: np.repeat(one, runs) for path, one in own.items()}
    vary |= {"arm.payload": np.tile(payloads, machines), "scenario.brake": np.tile(brakes, machines)}
    vary["seed"] = np.tile(seeds.astype(float), machines)
    scenario = Scenario(demand=[(0.0, -STEP / 2), (AT, STEP / 2)], duration=AT + WATCHED)
    angles = traced(machine, scenario, vary, ("angle",), step=step)[:, round(AT / machine.cycle) :, 0, 0]
    return np.asarray((angles - STEP / 2).reshape(machines, runs, -1))
