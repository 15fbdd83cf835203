"""What is true in the scene: for judges only, never for vision or plans."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layflat.cell.scene.produce import Specimen

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FruitTruth(Specimen):
    """A fruit at an instant.

    Attributes:
        position: of its middle in the cell's frame, (3,) m.
        orientation: quaternion, w first, (4,).
        acceleration: of its middle in the last step, m/s^2.
        peak_acceleration: greatest since the scene began, m/s^2.
        press: greatest force of the cup on it since the scene began, N.
        held: whether the cup holds it.
        place: name of the pack and number of the place that it lies in, None if in none.
    """

    position: Array
    orientation: Array
    acceleration: float
    peak_acceleration: float
    press: float
    held: bool
    place: tuple[str, int] | None


@dataclass(frozen=True)
class Collision:
    """A first contact of the arm, its lift or its cup with something that it should not touch."""

    time: float
    part: str
    other: str


@dataclass(frozen=True)
class Truth:
    """The whole scene at an instant.

    Attributes:
        tip: of the cup's lip, (3,) m.
        fruits: by name.
        collisions: since the scene began.
    """

    time: float
    tip: Array
    fruits: dict[str, FruitTruth]
    collisions: tuple[Collision, ...]
