"""Ripple of pressures and velocities that the waves of the valves' drivers leave.

The conductances of a valve over a period of its wave are known (valve.py), and the torques of the losses, which follow
the ripple, from one before (losses.py). Each harmonic of them passes through the model of air and motion (rates.py):
X = (j w - A)^-1 B U. Held for a step, they act as in its middle, where x is; its rotation is that of its start.
"""

from collections.abc import Sequence

import numpy as np

from layflat.arrays import Array
from layflat.linear.losses import Ripple
from layflat.linear.rates import LinearRates

VELOCITY_COLUMN, PRESSURE_A_COLUMN = 1, 2  # of the numbers of a `MovingJoint`


def no_ripple(step: float) -> tuple[Ripple, Ripple]:
    """Return the ripples of hoses A and B of a joint without any."""
    return (Ripple(step, np.zeros(1), np.zeros(1)),) * 2


def compute_ripples(model: LinearRates, waves: Sequence[Array], step: float) -> list[tuple[Ripple, Ripple]]:
    """Return the ripples of hoses A and B of each joint.

    Args:
        model: air and motion.
        waves: numbers of each joint's `AirInputs` over a period, (steps, 3), in SI units.
        step: step of the waves, s.
    """
    ripples = []
    for j, wave in enumerate(waves):
        steps = len(wave)
        alike = [i for i, other in enumerate(waves) if len(other) == steps]  # others are no part of this period
        inputs = np.fft.fft(np.concatenate([waves[i] - waves[i].mean(axis=0) for i in alike], axis=1), axis=0)
        B = model.B[:, [3 * i + path for i in alike for path in range(3)]]
        s = 2j * np.pi * np.fft.fftfreq(steps, step)
        pairs = zip(s[1:], inputs[1:], strict=True)
        harmonics = [np.linalg.solve(s_n * np.eye(len(B)) - model.A, B @ u) for s_n, u in pairs]
        x = np.array([np.zeros(len(B)), *harmonics])
        columns = {column: k for k, (i, column) in enumerate(model.places) if i == j}
        middle, start = (np.fft.ifft(x * shift, axis=0).real for shift in (1.0, np.exp(-0.5 * step * s)[:, np.newaxis]))
        velocity = start[:, columns[VELOCITY_COLUMN]] if VELOCITY_COLUMN in columns else np.zeros(steps)
        air = [columns[column] for column in sorted(columns) if column >= PRESSURE_A_COLUMN]
        a, b = (Ripple(step, velocity, middle[:, k]) for k in (air[0], air[len(air) // 2]))
        ripples.append((a, b))
    return ripples
