"""Small-signal model of air and motion, averaged over the ripple of a plant with tubes.

The flow through a tube goes with the root of the pressure drop, which the valve's wave reverses: its slope is that over
the whole ripple. So the laws are differentiated in every step of a period, dx/dt = A(t) x + B(t) u. The harmonics A_n
and B_n mix: a slow change of x or u changes the ripple, and that the mean. Fast as the ripple is, it follows at once:

    A = A_0 + sum A_-n (j n w - A_0)^-1 A_n,  B likewise with B_n last.

Harmonics do not mix further here. With tubes of 2 m and 4 mm, whose ripple is great, 4 deg at 20 Hz are left; shorter
steps of the plant do not change them. Without tubes the rates hardly curve over the ripple, and are differentiated at
its mean.
"""

import numpy as np

from layflat.arrays import Array
from layflat.lanes import leaves, read_numbers
from layflat.linear.point import OperatingPoint
from layflat.linear.rates import LinearRates, linearize_rates
from layflat.physics.line import LineParameters

MIN_SAMPLES = 40  # steps of a period that are differentiated, of many


def linearize_air(point: OperatingPoint) -> LinearRates:
    """Return the model of air and motion at an operating point, from mean conductances and loads."""
    steps = len(point.ends)
    if not isinstance(point.plant.joints[0].hose_a.line, LineParameters):
        return linearize_rates(point.plant, point.states, point.inputs)
    middles = 0.5 * (point.ends + np.roll(point.ends, 1, axis=0))
    rows = np.array([[*leaves(state)] for state in point.states])
    sampled = np.arange(0, steps, max(1, steps // MIN_SAMPLES))
    models, shares = [], []
    for k in sampled.tolist():
        pairs = zip(point.states, rows + middles[k], strict=True)
        states = tuple(read_numbers(state, row.tolist()) for state, row in pairs)
        inputs = point.inputs.copy()
        inputs[:, :2] = [valve.wave[k % len(valve.wave)] for valve in point.valves]
        models.append(linearize_rates(point.plant, states, inputs))
        shares.append([[*_share(valve.rises, k), 1.0] for valve in point.valves])
    A, B = np.array([model.A for model in models]), np.array([model.B for model in models])
    B = B * np.reshape(shares, (len(sampled), 1, -1))
    A_n, B_n = np.fft.fft(A, axis=0) / len(A), np.fft.fft(B, axis=0) / len(B)
    mean_A, mean_B = A_n[0].real, B_n[0].real
    for n, w in enumerate(2.0 * np.pi * np.fft.fftfreq(len(A), steps / len(A) * point.plant.h)[1:], start=1):
        ripple = np.linalg.solve(1j * w * np.eye(len(mean_A)) - A_n[0].real, np.hstack([A_n[n], B_n[n]]))
        added = (A_n[-n] @ ripple).real
        mean_A, mean_B = mean_A + added[:, : len(mean_A)], mean_B + added[:, len(mean_A) :]
    return LinearRates(mean_A, mean_B, models[0].places)


def _share(rises: Array, k: int) -> Array:
    """Return the slopes of a valve's conductances in a step over their mean, (2,); 1 where the mean is zero."""
    mean = rises.mean(axis=0)
    return np.where(mean == 0.0, 1.0, rises[k % len(rises)] / np.where(mean == 0.0, 1.0, mean))
