"""Simulation of the paper's experiments with many machines at once."""

import os
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description.change import changed_all
from layflat.experiments.bench import ReproductionBench
from layflat.experiments.controller import DURATION, ControllerExperiment, long_term_change
from layflat.experiments.dither import HIGH_FREQUENCY, small_signal_gain
from layflat.experiments.open_loop import SMALL_SWEEP_FRACTION
from layflat.experiments.two_axis import (
    END_TIME,
    HALF_STEP,
    LARGE_STEP_TIME,
    REST_WINDOW,
    SMALL_STEP_TIME,
    approach_demands,
)
from layflat.machine import Machine, parameters
from layflat.motion.scenario import Scenario
from layflat.physics.step import COARSE_STEP
from layflat.physics.valves.spool import SpoolValvePart
from layflat.sim.ensemble.cases import prepare_cases
from layflat.sim.ensemble.loops import loop_heights
from layflat.sim.ensemble.parallel import simulate_traces
from research.calibration.effort import EvaluationEffort
from research.calibration.steps import DIVERGED_ERROR, Steps
from research.calibration.unknowns import values_in

DITHER_WINDOW = 0.4  # of a measurement of dither, s


@dataclass(frozen=True)
class Evidence:
    """Experiments on the paper's machines with changed values; seed 1 is the noise of the claims."""

    bench: ReproductionBench

    @cached_property
    def steps(self) -> Steps:
        """Steps of joints alone."""
        return Steps(self.bench)

    def arm_moves(self, values: Mapping[str, Array], seed: int, effort: EvaluationEffort) -> Array:
        """Simulate a step of each joint in turn, in both directions, as in Fig. 14.

        Return angles, rad, (machines, directions, records, joints), those of the second with the opposite sign.
        """
        ways, own = [], values_in(self.bench.arm, values)
        vary = own | {"seed": np.full(len(next(iter(own.values()))), seed + 1.0)}
        for half in (HALF_STEP, -HALF_STEP):
            demand: list[tuple[str | float, Any]] = [
                (0.0, (-half, -half)),
                (LARGE_STEP_TIME, (half, -half)),
                (SMALL_STEP_TIME, (half, half)),
            ]
            scenario = Scenario(demand=demand, duration=END_TIME)
            angles = simulate_traces(self.bench.arm, scenario, vary, ("angle",), step=effort.step)[..., 0]
            ways.append(np.sign(half) * np.nan_to_num(angles, nan=DIVERGED_ERROR))
        return np.stack(ways, axis=1)

    def comes_back(self, values: Mapping[str, Array], seed: int, effort: EvaluationEffort) -> Array:
        """Return the arm's angles at rest after approaches to one position, rad, (machines, approaches, joints)."""
        own, (demand, ends) = values_in(self.bench.arm, values), approach_demands()
        vary = own | {"seed": np.full(len(next(iter(own.values()))), seed + 2.0)}
        ends = ends[: effort.approaches]
        scenario = Scenario(demand=[one for one in demand if one[0] < ends[-1]], duration=float(ends[-1]))
        angles = np.nan_to_num(
            simulate_traces(self.bench.arm, scenario, vary, ("angle",), step=effort.step)[..., 0], nan=DIVERGED_ERROR
        )
        cycle = self.bench.arm.cycle
        rests = [angles[:, round((end - REST_WINDOW) / cycle) : round(end / cycle)].mean(axis=1) for end in ends]
        return np.stack(rests, axis=1)

    def taken_over(self, values: Mapping[str, Array], effort: EvaluationEffort) -> Array:
        """Return the share of a valve's drift that the small joint's long-term integral takes over, (machines,)."""
        on = self.bench

        def taken(one: dict[str, float]) -> float:
            arm, earlier = (changed_all(machine, values_in(machine, one)) for machine in (on.arm, on.earlier))
            runs = ControllerExperiment(replace(on, arm=arm, earlier=earlier))
            return long_term_change(runs.run(effort.step, duration=DURATION)) / runs.volts

        return _each(taken, values)

    def frictions(self, machine: Machine) -> dict[str, float]:
        """Return the differential pressure (Pa) that friction and losses of each joint of a machine can hold."""
        gauge = machine.supply.pressure_gauge
        return {name: parameters.held_pressure(joint, gauge) for name, joint in machine.joints.items()}

    def ripple(self, machine: Machine, values: Mapping[str, Array]) -> Array:
        """Return the amplitude of dither in the differential pressure of a machine at rest, Pa, (machines, joints)."""
        own, valve = values_in(machine, values), machine.valve
        assert isinstance(valve, SpoolValvePart)
        rest = Scenario(opening=0.0, duration=2.0 * DITHER_WINDOW, noise=False)
        both = simulate_traces(machine, rest, own, ("pressure_a", "pressure_b"), step=COARSE_STEP)[
            :, -round(DITHER_WINDOW / machine.cycle) :
        ]
        turns = np.exp(-2j * np.pi * valve.dither.frequency * machine.cycle * np.arange(both.shape[1]))
        return np.asarray(2.0 * np.abs(np.mean((both[..., 0] - both[..., 1]) * turns[:, None], axis=1)))

    def hysteresis(self, values: Mapping[str, Array]) -> Array:
        """Return the heights of curves, shares of the greatest torque, (machines, 3).

        They are those of the earlier actuator, and of the new joint without and with brake.
        """
        columns = []
        for machine, brake in ((self.bench.earlier, True), (self.bench.axis_one, False), (self.bench.axis_one, True)):
            own = values_in(machine, values)
            none = {"joint.small.brake.torque": np.zeros(len(next(iter(own.values()))))}
            height, torque = loop_heights(prepare_cases(machine, [Scenario()], own if brake else own | none, None))
            columns.append(height[:, 0] / torque[:, 0])
        return np.stack(columns, axis=1)

    def spool(self, values: Mapping[str, Array]) -> Array:
        """Return how much more a dither that is too fast for the spool lets through than its own, (machines,)."""

        def faster(own: dict[str, float]) -> float:
            valve = changed_all(self.bench.arm, own).valve
            assert isinstance(valve, SpoolValvePart)
            dither = valve.dither
            gain, fast = (small_signal_gain(valve, dither.amplitude, at) for at in (dither.frequency, HIGH_FREQUENCY))
            return fast / gain

        return _each(faster, {path: one for path, one in values.items() if path.startswith("valve.")})

    def small_motion(self, values: Mapping[str, Array]) -> Array:
        """Return the share of its curve's height that the earlier actuator keeps in a small motion, (machines,)."""
        earlier = self.bench.earlier
        prepared = prepare_cases(earlier, [Scenario()], values_in(earlier, values), None)
        small, _ = loop_heights(prepared, SMALL_SWEEP_FRACTION)
        whole, _ = loop_heights(prepared)
        return np.asarray(small[:, 0] / whole[:, 0])


def _each(found: Callable[[dict[str, float]], float], values: Mapping[str, Array]) -> Array:
    """What is found of each machine by itself, side by side on all cores, (machines,)."""
    machines = (dict(zip(values, map(float, own), strict=True)) for own in zip(*values.values(), strict=True))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return np.array(list(pool.map(found, machines)))
