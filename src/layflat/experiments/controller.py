"""The controller: what its long-term integral learns, by three rules, and how long a cycle takes (section 3)."""

import time
from dataclasses import replace
from functools import cached_property
from math import pi, radians
from typing import Any

import numpy as np
import xarray

from layflat.experiments.bench import maximum_torque
from layflat.experiments.claim import Evaluated, Experiment, Quantity, claim
from layflat.experiments.kernels import control_cycles
from layflat.machine import parameters
from layflat.motion.scenario import Scenario
from layflat.physics.step import STEP
from layflat.sim import rollout

DRIFT = 0.05  # drift of the valve's neutral, share of full opening
DURATION = 60.0
OFFSET_LOAD = 0.4  # offset load of rule 3, share of the maximum torque at supply pressure
CYCLES, BATCHES = 1000, 101  # cycles that are timed together, and how often


def learnt(run: xarray.Dataset, since: float = 0.0) -> float:
    """Return how much the long-term integral changes from a time (s) on, V."""
    values = run["long_term"].sel(joint="small", time=slice(since, None)).to_numpy()
    return float(values[-1] - values[0])


def _sway(t: float) -> float:
    """Demand of a joint in motion, rad."""
    return radians(40.0) * float(np.sin(2 * pi * 0.5 * t))


class Controller(Experiment):
    """Axis one with its valve's neutral drifted by 5 %; the controllers of all axes on noisy samples."""

    @cached_property
    def volts(self) -> float:
        """The drift, V."""
        valve, _, _ = parameters.drive_parts(self.bench.axis_one)
        return DRIFT * valve.volts_to_full

    def run(self, step: float = STEP, **changes: Any) -> xarray.Dataset:
        """Simulate axis one; `changes` are fields of `Scenario`, the step of the plant is in s."""
        case = Scenario(drift=self.volts, brake=self.bench.brake, seed=4, duration=20.0)
        return rollout(self.bench.axis_one, step=step, scenario=replace(case, **changes))

    @claim("long-term-integral")
    def rules_of_the_integral(self) -> Evaluated:
        """Simulate the integral at rest, with the air off, in motion, and under an offset load."""
        machine = self.bench.axis_one
        load = OFFSET_LOAD * maximum_torque(machine, "small")
        ambient = machine.supply.ambient_pressure
        taken = 100.0 * learnt(self.run(duration=DURATION)) / self.volts
        still = {
            "air off": abs(learnt(self.run(supply=0.0, pressures=(ambient, ambient)))),
            "in motion": abs(learnt(self.run(demand=_sway), since=1.0)),
            "offset load": abs(learnt(self.run(load=[(0.0, 0.0), (1.0, load)]), since=2.5)),
        }
        return [
            Quantity("drift taken over", taken, "%", "all"),
            *(Quantity(name, value, "V", "0") for name, value in still.items()),
        ], 90.0 <= taken <= 110.0 and all(value == 0.0 for value in still.values())

    @cached_property
    def all_axes(self) -> float:
        """Median time of one cycle of all axes, s."""
        settings = parameters.control(self.bench.arm)
        noise = np.random.default_rng(5).standard_normal((3, 256))
        samples = (0.1 * noise[0], 1e5 * noise[1], 0.5 * noise[2])
        control_cycles(settings, *samples, CYCLES)
        times = []
        for _ in range(BATCHES):
            begin = time.perf_counter()
            control_cycles(settings, *samples, CYCLES)
            times.append((time.perf_counter() - begin) / CYCLES)
        return float(np.median(times))

    @claim("control-cycle")
    def control_cycle(self) -> Evaluated:
        """Time one cycle of all axes."""
        return [Quantity("time of a cycle", 1e6 * self.all_axes, "us", "under 2500")], self.all_axes < 1e-5
