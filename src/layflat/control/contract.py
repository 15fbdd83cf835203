"""Tuples that a control law takes and returns in a control cycle; with an item per joint, from base to tip."""

from typing import NamedTuple

from layflat.physics.adjustable import Shares


class Sensed(NamedTuple):
    """Readings of the sensors in this cycle; tuples with an item per joint, from base to tip."""

    angle: tuple[float, ...]  # rad
    differential_pressure: tuple[float, ...]  # hose A less hose B, Pa


class Demand(NamedTuple):
    """Demand of each joint in this cycle, with its rates; a step has zero rates."""

    angle: tuple[float, ...]  # rad
    velocity: tuple[float, ...]  # rad/s
    acceleration: tuple[float, ...]  # rad/s2
    stiffness: tuple[float, ...]  # at rest, N m/rad; 0: as it comes


class Command(NamedTuple):
    """Commands of a law in this cycle; tuples with an item per joint."""

    voltage: tuple[float, ...]  # to the valves' drivers, V
    shares: tuple[Shares, ...]  # of brake, dither and supply, where the machine lets them be adjusted; 1 leaves all
