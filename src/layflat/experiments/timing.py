"""How long the controller takes (section 3: two axes well inside a 5 ms cycle)."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from layflat.experiments.bench import Bench
from layflat.experiments.claim import Claim
from layflat.experiments.kernels import control_cycles
from layflat.machine import parameters

CYCLES = 1000
BATCHES = 101


@dataclass(frozen=True)
class Timing:
    """Median time of one cycle of both axes, s."""

    both_axes: float


def perform(bench: Bench) -> Timing:
    """Time the controllers of both axes on noisy samples."""
    gains = tuple(parameters.gains(bench.arm, name) for name in bench.arm.joints)
    noise = np.random.default_rng(5).standard_normal((3, 256))
    samples = (0.1 * noise[0], 1e5 * noise[1], 0.5 * noise[2])
    control_cycles(gains, *samples, CYCLES)
    times = []
    for _ in range(BATCHES):
        begin = time.perf_counter()
        control_cycles(gains, *samples, CYCLES)
        times.append((time.perf_counter() - begin) / CYCLES)
    return Timing(float(np.median(times)))


def claims(found: Timing) -> list[Claim]:
    """What the paper says of the control cycle."""
    return [
        Claim(
            "control-cycle",
            "3",
            "two axes in under 2.5 ms on a 386",
            1e6 * found.both_axes,
            "us",
            1e6 * found.both_axes < 10.0,
            "both axes' step under 10 us at the median",
        )
    ]
