"""How long the controller takes (section 3: two axes well inside a 5 ms cycle)."""

from __future__ import annotations

import time
from functools import cached_property

import numpy as np

from layflat.experiments.claim import Evaluated, Experiment, Quantity, claim
from layflat.experiments.kernels import control_cycles
from layflat.machine import parameters

CYCLES = 1000
BATCHES = 101


class Timing(Experiment):
    """The controllers of all axes on noisy samples."""

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

    @claim("control-cycle", "3", "two axes in under 2.5 ms on a 386", "all axes' step under 10 us at the median")
    def control_cycle(self) -> Evaluated:
        """Time one cycle of all axes."""
        return [Quantity("time of a cycle", 1e6 * self.all_axes, "us", "under 2500")], self.all_axes < 1e-5
