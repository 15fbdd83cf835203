"""Signals over the last four cycles: at a 5 ms cycle just one period of the 50 Hz dither.

| symbol | meaning |
|---|---|
| x_0 .. x_3 | samples, newest first |
"""

from math import sqrt

from layflat.jit import law

SIGNALS = {
    "averaged_angle": ("rad", "angle averaged over the dither period"),
    "averaged_velocity": ("rad/s", "velocity from the averaged angle"),
    "averaged_pressure": ("Pa", "differential pressure averaged over the dither period"),
    "ripple": ("Pa", "amplitude of the pressure at the dither frequency"),
}
"""Unit and meaning of what averages yield, under the names that laws and rigs give them."""


@law
def mean4(x_0, x_1, x_2, x_3):
    """Mean of four samples: zero gain at a quarter of the sampling rate (50 Hz), 1.5 cycles of delay."""
    return 0.25 * (x_0 + x_1 + x_2 + x_3)


@law
def ripple4(x_0, x_1, x_2, x_3):
    """Amplitude of the component at a quarter of the sampling rate: first bin of the four-point DFT."""
    return 0.5 * sqrt((x_0 - x_2) * (x_0 - x_2) + (x_1 - x_3) * (x_1 - x_3))
