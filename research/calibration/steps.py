"""Steps of joints alone, with many machines at once: those of Fig. 13, and with increasing inertia."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import radians

import numpy as np

from layflat.arrays import Array
from layflat.experiments.axis_one import INERTIA_RATIOS, OSCILLATION_WINDOW, STEP, STEP_TIME
from layflat.experiments.bench import INERTIA_PER_TORQUE, ReproductionBench, maximum_torque, payload_for_inertia
from layflat.machine import Machine
from layflat.motion.scenario import Scenario
from layflat.sim.ensemble.parallel import simulate_traces
from layflat.sim.metrics import SETTLING_BAND
from research.calibration.effort import EvaluationEffort
from research.calibration.kernels import evaluate_errors
from research.calibration.unknowns import values_in

RECORDED_TIME = 9.5  # after a step, s
MAX_INERTIA_RATIO, MAX_EARLIER_INERTIA_RATIO = (
    INERTIA_RATIOS[-1],
    INERTIA_RATIOS[15],
)  # largest inertia per torque with which a joint moves, kg m2 per N m
UNBRAKED_RUNS = 2  # of the new joint without brake
REST_DURATION = 1.0  # within the band, from which on a joint has settled, s
DIVERGED_ERROR = radians(1e3)  # error of a joint that diverged, rad


@dataclass(frozen=True)
class StepResponses:
    """Settling and oscillation of steps, (machines, runs, repeats)."""

    ratios: Array  # inertia per torque of each run, kg m2 per N m
    time: Array  # until the joint stays within the band, s; infinite unless a second is left
    swing: Array  # peak to peak over the last two seconds, rad
    late: Array  # rms of the error over the last four seconds, rad


def evaluate_responses(error: Array, ratios: Array, cycle: float) -> StepResponses:
    """Return settling and oscillation from errors (machines, runs x repeats, records), rad.

    Args:
        error: in the order of runs, then repeats.
        ratios: inertia per torque of each run, kg m2 per N m.
        cycle: between records, s.
    """
    machines, _, records = error.shape
    found = evaluate_errors(
        error.reshape(-1, records), SETTLING_BAND, round(OSCILLATION_WINDOW / cycle), DIVERGED_ERROR
    )
    found = found.reshape(machines, len(ratios), -1, 3)
    time = found[..., 0] * cycle
    return StepResponses(
        ratios, np.where(time > records * cycle - REST_DURATION, np.inf, time), found[..., 1], found[..., 2]
    )


@dataclass(frozen=True)
class PaperSteps:
    """Steps of joints alone, with the inertia of the paper's comparison (Fig. 13)."""

    cycle: float  # between records, s
    unbraked: Array  # errors of the new joint without brake, rad, (machines, runs, records)
    braked: StepResponses  # the new joint with its brake and the paper's 2 kg: one run
    earlier: StepResponses  # the earlier actuator


@dataclass(frozen=True)
class InertiaSteps:
    """Steps of joints alone, with increasing inertia."""

    cycle: float  # s
    braked: StepResponses  # the new joint with its brake
    earlier: StepResponses  # the earlier actuator


@dataclass(frozen=True)
class Steps:
    """Simulation of joints alone with changed values; seed 1 is the noise of the claims."""

    bench: ReproductionBench

    @cached_property
    def scale(self) -> float:
        """Maximum torque of the earlier actuator over that of the new joint, by which its pressure gains are scaled."""
        return self._torque(self.bench.earlier) / self._torque(self.bench.axis_one)

    def compared(self, values: Mapping[str, Array], seed: int, effort: EvaluationEffort) -> PaperSteps:
        """Simulate a step of 40 deg of joints alone, with the inertia of the paper's comparison.

        Args:
            values: numbers (SI) by path, (machines,).
            seed: of the noise.
            effort: of the evaluation.
        """
        new, ratio = self.bench.axis_one, np.array([INERTIA_PER_TORQUE])
        payloads = np.append(self._payloads(new, np.repeat(ratio, UNBRAKED_RUNS)), new.arm.payload)
        brakes = np.append(np.zeros(UNBRAKED_RUNS), 1.0)
        seeds = seed + np.append(np.arange(UNBRAKED_RUNS), 0)
        found = _step_errors(new, values, payloads, brakes, seeds, effort.step)
        lost = np.nan_to_num(found[:, :UNBRAKED_RUNS], nan=DIVERGED_ERROR)
        braked = evaluate_responses(found[:, UNBRAKED_RUNS:], np.zeros(1), new.cycle)
        return PaperSteps(new.cycle, lost, braked, self._earlier(values, ratio, np.array([float(seed)]), effort))

    def loaded(self, values: Mapping[str, Array], seed: int, effort: EvaluationEffort) -> InertiaSteps:
        """Simulate the same step with increasing inertia; arguments as of `compared`.

        Each seed shifts the inertias between their neighbours, if `effort.elsewhere`.
        """
        new = self.bench.axis_one
        shift = float(np.random.default_rng(seed).uniform(-0.5, 0.5)) if effort.elsewhere else 0.0
        ratios, ratios_earlier = (
            _inertia_ratios(most, count, shift)
            for most, count in zip((MAX_INERTIA_RATIO, MAX_EARLIER_INERTIA_RATIO), effort.counts, strict=True)
        )
        seeds = np.asarray(seed - 1.0 + np.arange(effort.repeats))
        payloads = np.repeat(self._payloads(new, ratios), len(seeds))
        noise = np.tile(seeds, len(ratios))
        found = _step_errors(new, values, payloads, np.ones(len(payloads)), noise, effort.step)
        braked = evaluate_responses(found, ratios, new.cycle)
        return InertiaSteps(new.cycle, braked, self._earlier(values, ratios_earlier, seeds, effort))

    def _earlier(
        self, values: Mapping[str, Array], ratios: Array, seeds: Array, effort: EvaluationEffort
    ) -> StepResponses:
        """Simulate the step of the earlier actuator, whose pressure gains are scaled to its torque."""
        earlier = self.bench.earlier
        payloads, noise = np.repeat(self._payloads(earlier, ratios), len(seeds)), np.tile(seeds, len(ratios))
        scaled = {path: self.scale * one if _is_pressure_gain(path) else one for path, one in values.items()}
        found = _step_errors(earlier, scaled, payloads, np.zeros(len(payloads)), noise, effort.step)
        return evaluate_responses(found, ratios, earlier.cycle)

    def _payloads(self, machine: Machine, ratios: Sequence[float] | Array) -> Array:
        torque = self._torque(machine)
        return np.array([payload_for_inertia(machine, "small", ratio * torque) for ratio in ratios])

    @staticmethod
    def _torque(machine: Machine) -> float:
        return maximum_torque(machine, "small")


def _inertia_ratios(most: float, count: int, shift: float) -> Array:
    """Return inertias per torque in geometric progression, the inner ones shifted by a fraction of their distance."""
    places = np.arange(count, dtype=float)
    places[1:-1] += shift
    return np.asarray(INERTIA_PER_TORQUE * (most / INERTIA_PER_TORQUE) ** (places / (count - 1)))


def _is_pressure_gain(path: str) -> bool:
    return ".gains." in path and path.endswith(".pressure")


def _step_errors(
    machine: Machine, values: Mapping[str, Array], payloads: Array, brakes: Array, seeds: Array, step: float
) -> Array:
    """Return errors from the step on, rad, (machines, runs, records): each machine with each payload, brake and noise.

    They are nan from where a run diverged.
    """
    own = values_in(machine, values)
    machines, runs = len(next(iter(own.values()))), len(payloads)
    vary = {path: np.repeat(one, runs) for path, one in own.items()}
    vary |= {"arm.payload": np.tile(payloads, machines), "scenario.brake": np.tile(brakes, machines)}
    vary["seed"] = np.tile(seeds.astype(float), machines)
    scenario = Scenario(demand=[(0.0, -STEP / 2), (STEP_TIME, STEP / 2)], duration=STEP_TIME + RECORDED_TIME)
    angles = simulate_traces(machine, scenario, vary, ("angle",), step=step)[
        :, round(STEP_TIME / machine.cycle) :, 0, 0
    ]
    return np.asarray((angles - STEP / 2).reshape(machines, runs, -1))
