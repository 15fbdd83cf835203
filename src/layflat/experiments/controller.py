"""Controller: its long-term integral under its three rules, and the computing time of a cycle (section 3)."""

import time
from dataclasses import replace
from functools import cached_property
from math import pi, radians
from typing import Any

import numpy as np
import xarray

from layflat.experiments.bench import maximum_torque
from layflat.experiments.claim import ClaimQuantity, Evaluation, Experiment, claim
from layflat.experiments.kernels import control_cycles
from layflat.machine import parameters
from layflat.motion.scenario import Scenario
from layflat.physics.step import STEP
from layflat.sim import rollout

NEUTRAL_DRIFT = 0.05  # of the valve, fraction of full opening
DURATION = 60.0
OFFSET_LOAD = 0.4  # of rule 3, fraction of the maximum torque at supply pressure
TIMED_CYCLES, TIMED_BATCHES = 1000, 101  # cycles that are timed together, and number of measurements


def long_term_change(run: xarray.Dataset, since: float = 0.0) -> float:
    """Return the change of the long-term integral from a time (s) to the end of a run, V."""
    values = run["long_term"].sel(joint="small", time=slice(since, None)).to_numpy()
    return float(values[-1] - values[0])


def _sinusoidal_demand(t: float) -> float:
    """Return the demand of a joint in motion, rad: 40 deg at 0.5 Hz."""
    return radians(40.0) * float(np.sin(2 * pi * 0.5 * t))


class ControllerExperiment(Experiment):
    """Axis one with its valve's neutral drifted by 5 %; the controllers of all axes on noisy samples."""

    @cached_property
    def volts(self) -> float:
        """Drift of the valve's neutral, V."""
        valve, _, _ = parameters.valve_and_sensors(self.bench.axis_one)
        return NEUTRAL_DRIFT * valve.volts_to_full

    def run(self, step: float = STEP, **changes: Any) -> xarray.Dataset:
        """Simulate axis one with drift and brake, for 20 s; `changes` are fields of `Scenario`, `step` is in s."""
        case = Scenario(drift=self.volts, brake=self.bench.brake, seed=4, duration=20.0)
        return rollout(self.bench.axis_one, step=step, scenario=replace(case, **changes))

    @claim("long-term-integral")
    def rules_of_the_integral(self) -> Evaluation:
        """Evaluate the integral's change at rest, with the air off, in motion, and under an offset load."""
        machine = self.bench.axis_one
        load = OFFSET_LOAD * maximum_torque(machine, "small")
        ambient = machine.supply.ambient_pressure
        compensated = 100.0 * long_term_change(self.run(duration=DURATION)) / self.volts
        changes = {
            "air off": abs(long_term_change(self.run(supply=0.0, pressures=(ambient, ambient)))),
            "in motion": abs(long_term_change(self.run(demand=_sinusoidal_demand), since=1.0)),
            "offset load": abs(long_term_change(self.run(load=[(0.0, 0.0), (1.0, load)]), since=2.5)),
        }
        return [
            ClaimQuantity("drift taken over", compensated, "%", "all"),
            *(ClaimQuantity(name, value, "V", "0") for name, value in changes.items()),
        ], 90.0 <= compensated <= 110.0 and all(value == 0.0 for value in changes.values())

    @cached_property
    def all_axes(self) -> float:
        """Median computing time of a control cycle of all axes, s."""
        settings = parameters.control(self.bench.arm)
        noise = np.random.default_rng(5).standard_normal((3, 256))
        samples = (0.1 * noise[0], 1e5 * noise[1], 0.5 * noise[2])
        control = control_cycles.bind(settings, *samples, TIMED_CYCLES, np.empty(1))
        control()
        times = []
        for _ in range(TIMED_BATCHES):
            begin = time.perf_counter()
            control()
            times.append((time.perf_counter() - begin) / TIMED_CYCLES)
        return float(np.median(times))

    @claim("control-cycle")
    def control_cycle(self) -> Evaluation:
        """Measure the computing time of one cycle of all axes."""
        return [ClaimQuantity("time of a cycle", 1e6 * self.all_axes, "us", "under 2500")], self.all_axes < 1e-5
