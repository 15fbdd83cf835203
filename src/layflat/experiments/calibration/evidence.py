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
from layflat.experiments.kernels import looked_at
from layflat.experiments.limits import AT, STEP, SWING
from layflat.experiments.open_loop import SMALL_SWEEP
from layflat.experiments.two_axis import END, FIRST, HALF, REPEAT_TIME, SECOND
from layflat.machine import Machine
from layflat.physics.step import STEP as STEP_FINE
from layflat.physics.valves.spool import SpoolValvePart
from layflat.sim import Scenario
from layflat.sim.ensemble.cases import cases
from layflat.sim.ensemble.loops import heights
from layflat.sim.ensemble.parallel import traced
from layflat.sim.metrics import BAND

COARSE = 1e-3  # step of the plant while searching, s: it ranks machines as well as the default does
WATCHED = 9.5  # how long a joint is watched after its step, s
MOST, MOST_EARLIER = 1e-1, 4e-2  # largest inertia per torque with which a joint moves, kg m2 per N m
UNBRAKED = 2  # runs of the new joint without brake
BACK = END + REPEAT_TIME  # when the arm has come back to the middle, s
LISTENS = 0.4  # for how long dither is looked at, s
REST = 1.0  # a joint has settled if it stays inside for so long, s
LOST = radians(1e3)  # error of a joint that diverged, rad


@dataclass(frozen=True)
class Effort:
    """How closely machines are looked at."""

    counts: tuple[int, int]  # inertias of the braked joint and of the earlier actuator
    repeats: int  # runs with each of them, and of the arm's moves each way, with other noise
    step: float  # of the plant, s
    elsewhere: bool = False  # whether inertias lie elsewhere between their neighbours with each seed


ROUGH, CAREFUL, FINE = (
    Effort((8, 6), 1, COARSE, elsewhere=True),
    Effort((8, 6), 3, COARSE, elsewhere=True),
    Effort((25, 16), 3, STEP_FINE),  # as the claims are judged
)


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
class Steps:
    """What joints alone do after a step; records are a cycle (s) apart."""

    cycle: float
    unbraked: (
        Array  # errors of the new joint without brake, rad, (machines, runs, records), with the comparison's inertia
    )
    braked: Carried  # the new joint with its brake and the paper's 2 kg: one run
    carried_braked: Carried  # the new joint with its brake
    carried_earlier: Carried  # the earlier actuator; the first of the inertias is that of the comparison


@dataclass(frozen=True)
class Evidence:
    """The paper's machines, in which values take the place of others."""

    bench: Bench

    @cached_property
    def scale(self) -> float:
        """Maximum torque of the earlier actuator over that of the new joint: its pressure gains follow it."""
        return self._torque(self.bench.earlier) / self._torque(self.bench.axis_one)

    def steps(self, values: Mapping[str, Array], seed: int, effort: Effort) -> Steps:
        """Let joints alone make a step of 40 deg, as in Fig. 13 and with other inertias.

        Args:
            values: numbers (SI) by path, an item a machine.
            seed: of the noise, and of where between its neighbours each inertia lies.
            effort: how closely they are looked at.
        """
        shift = float(np.random.default_rng(seed).uniform(-0.5, 0.5)) if effort.elsewhere else 0.0
        ratios, ratios_earlier = (
            _spread(most, count, shift) for most, count in zip((MOST, MOST_EARLIER), effort.counts, strict=True)
        )
        new, earlier = self.bench.axis_one, self.bench.earlier
        compared = self._payloads(new, [INERTIA_PER_TORQUE] * UNBRAKED)
        own = np.repeat(self._payloads(new, ratios), effort.repeats)
        payloads = np.concatenate([compared, [new.arm.payload], own])
        brakes = np.concatenate([np.zeros(UNBRAKED), np.ones(1 + len(own))])
        found = _stepped(new, values, payloads, brakes, seed, effort.step)
        payloads = np.repeat(self._payloads(earlier, ratios_earlier), effort.repeats)
        scaled = {path: self.scale * one if _is_pressure_gain(path) else one for path, one in values.items()}
        old = _stepped(earlier, scaled, payloads, np.zeros(len(payloads)), seed + 1, effort.step)
        at = UNBRAKED + 1
        lost = np.nan_to_num(found[:, :UNBRAKED], nan=LOST)
        braked, both = carried(found[:, UNBRAKED:at], np.zeros(1), new.cycle), carried(found[:, at:], ratios, new.cycle)
        return Steps(new.cycle, lost, braked, both, carried(old, ratios_earlier, new.cycle))

    def arm_moves(self, values: Mapping[str, Array], seed: int, effort: Effort) -> Array:
        """Let the arm make a step of each joint in turn, either way, as in Fig. 14; then it comes back to the middle.

        Returns angles, rad, (machines, ways, records, joints): half of the ways one way with other noise each, half the
        other way, with the opposite sign.
        """
        ways, machines, repeats = [], len(next(iter(values.values()))), effort.repeats
        noise = np.tile(seed + np.arange(repeats, dtype=float), machines)
        vary = {path: np.repeat(one, repeats) for path, one in values.items()} | {"seed": noise}
        for half in (HALF, -HALF):
            demand: list[tuple[str | float, Any]] = [
                (0.0, (-half, -half)),
                (FIRST, (half, -half)),
                (SECOND, (half, half)),
                (END, (0.0, 0.0)),
            ]
            scenario = Scenario(demand=demand, duration=BACK)
            angles = traced(self.bench.arm, scenario, vary, ("angle",), step=effort.step)[..., 0]
            found = np.sign(half) * np.nan_to_num(angles, nan=LOST)
            ways.append(found.reshape(machines, repeats, *found.shape[1:]))
        return np.concatenate(ways, axis=1)

    def ripple(self, machine: Machine, values: Mapping[str, Array]) -> Array:
        """Return the amplitude of dither in the differential pressure of a machine at rest, Pa, (machines, joints)."""
        own, valve = known_to(machine, values), machine.valve
        assert isinstance(valve, SpoolValvePart)
        rest = Scenario(opening=0.0, duration=2.0 * LISTENS, noise=False)
        both = traced(machine, rest, own, ("pressure_a", "pressure_b"), step=COARSE)[
            :, -round(LISTENS / machine.cycle) :
        ]
        turns = np.exp(-2j * np.pi * valve.dither.frequency * machine.cycle * np.arange(both.shape[1]))
        return np.asarray(2.0 * np.abs(np.mean((both[..., 0] - both[..., 1]) * turns[:, None], axis=1)))

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


def _spread(most: float, count: int, shift: float) -> Array:
    """Inertias per torque in geometric progression, those between both ends shifted by a share of their distance."""
    places = np.arange(count, dtype=float)
    places[1:-1] += shift
    return np.asarray(INERTIA_PER_TORQUE * (most / INERTIA_PER_TORQUE) ** (places / (count - 1)))


def _is_pressure_gain(path: str) -> bool:
    return ".gains." in path and path.endswith(".pressure")


def _stepped(
    machine: Machine, values: Mapping[str, Array], payloads: Array, brakes: Array, seed: int, step: float
) -> Array:
    """Errors from the step on, rad, (machines, runs, records): each machine with each payload and its brake.

    They are not numbers from where a run diverged.
    """
    own = known_to(machine, values)
    machines, runs = len(next(iter(own.values()))), len(payloads)
    vary = {path: np.repeat(one, runs) for path, one in own.items()}
    vary |= {"arm.payload": np.tile(payloads, machines), "scenario.brake": np.tile(brakes, machines)}
    vary["seed"] = np.tile(seed + np.arange(runs, dtype=float), machines)
    scenario = Scenario(demand=[(0.0, -STEP / 2), (AT, STEP / 2)], duration=AT + WATCHED)
    angles = traced(machine, scenario, vary, ("angle",), step=step)[:, round(AT / machine.cycle) :, 0, 0]
    return np.asarray((angles - STEP / 2).reshape(machines, runs, -1))
