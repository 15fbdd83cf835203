"""Counts of a converter, and the numbers they stand for."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor
from typing import NamedTuple

from layflat.errors import LayflatError
from layflat.physics.sensor import Sensor

WORD = 16
"""Bits."""


class WireError(LayflatError):
    """Words that nobody who keeps to docs/rig-wires.md sends."""


class Converter(NamedTuple):
    """A count c stands for low + lsb c; c goes from 0 to `top`, which belongs to it."""

    low: float
    lsb: float
    top: int

    @classmethod
    def of_sensor(cls, sensor: Sensor) -> Converter:
        """Counts as `read_sensor` makes them: both ends of the range are among them."""
        return cls(sensor.low, sensor.lsb, round((sensor.high - sensor.low) / sensor.lsb))

    @property
    def words(self) -> int:
        """Words that a count takes."""
        return 1 if self.top < 1 << WORD else 2

    def count(self, value: float) -> int:
        """Count nearest to a value, within the range."""
        inside = min(max(value, self.low), self.value(self.top))
        return floor((inside - self.low) / self.lsb + 0.5)

    def value(self, count: int) -> float:
        """What a count stands for: bit for bit what `read_sensor` says of it."""
        return self.low + self.lsb * count

    def put(self, words: list[int], value: float) -> None:
        """Append a value's count, high word first."""
        count = self.count(value)
        if self.words == 2:
            words.append(count >> WORD)
        words.append(count & 0xFFFF)

    def take(self, words: Sequence[int], at: int) -> float:
        """The value whose count begins at a place among words.

        Raises:
            WireError: the converter has no such count.
        """
        count = words[at] if self.words == 1 else words[at] << WORD | words[at + 1]
        if count > self.top:
            raise WireError(f"count {count} of a converter that ends at {self.top}")
        return self.value(count)
