"""Signals of a control cycle: inputs and outputs of a control law, and averages over the last four cycles.

Tuples have an item per joint, from base to tip. At a 5 ms cycle four cycles are just one period of the 50 Hz dither.

| symbol | meaning |
|---|---|
| x_0 .. x_3 | samples, newest first |
"""

from math import sqrt
from typing import NamedTuple

from layflat.jit import law
from layflat.physics.adjustable import DriveFractions


class Sensed(NamedTuple):
    """Readings of the sensors in this cycle; tuples with an item per joint, from base to tip."""

    angle: tuple[float, ...]  # rad
    differential_pressure: tuple[float, ...]  # hose A less hose B, Pa


class Demand(NamedTuple):  # language: name that users' control laws import
    """Demand of each joint in this cycle, with its rates; a step has zero rates."""

    angle: tuple[float, ...]  # rad
    velocity: tuple[float, ...]  # rad/s
    acceleration: tuple[float, ...]  # rad/s2
    stiffness: tuple[float, ...]  # at rest, N m/rad; 0 for none


class Command(NamedTuple):  # language: name that users' control laws import
    """Commands of a law in this cycle; tuples with an item per joint."""

    voltage: tuple[float, ...]  # to the valves' drivers, V
    shares: tuple[
        DriveFractions, ...
    ]  # of brake, dither and supply, 0..1, if the machine can adjust them; 1 for all of it


SIGNALS = {
    "averaged_angle": ("rad", "angle averaged over the dither period"),
    "averaged_velocity": ("rad/s", "velocity from the averaged angle"),
    "averaged_pressure": ("Pa", "differential pressure averaged over the dither period"),
    "ripple": ("Pa", "amplitude of the pressure at the dither frequency"),
}
"""Unit and meaning of the averages, by the names that laws and rigs report."""


@law
def mean4(x_0, x_1, x_2, x_3):
    """Return the mean of four samples: zero gain at a quarter of the sampling rate (50 Hz), 1.5 cycles of delay."""
    return 0.25 * (x_0 + x_1 + x_2 + x_3)


@law
def ripple4(x_0, x_1, x_2, x_3):
    """Return the amplitude at a quarter of the sampling rate: first bin of the four-point DFT."""
    return 0.5 * sqrt((x_0 - x_2) * (x_0 - x_2) + (x_1 - x_3) * (x_1 - x_3))
