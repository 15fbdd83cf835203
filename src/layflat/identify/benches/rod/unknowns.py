"""What is unknown of a rod: bounds from its logs, and what is known of it before any log.

Logs of one seal differ by more than pressure: sensors are set to zero anew, grease and wear move, a rod is loaded from
another side. Every fitted log therefore has a force, a tilt, and a friction of its own (nuisances), known to be small.
Without them a fit would take what one log happens to have for a law of pressure.
"""

from collections.abc import Sequence

import numpy as np

from layflat.arrays import Array
from layflat.identify.benches.hysteresis.model import element_unknowns, within
from layflat.identify.benches.rod.description import RodBench
from layflat.identify.benches.rod.laws import RodLog
from layflat.identify.model import Output
from layflat.identify.unknown import Unknown

SLOPES = "loops at two pressures or more, the higher the further apart"
SHAPES = "loops at three pressures or more, from low to high"
LOGS = "more logs at the same pressures"

OF_FORCE, OF_TILT, OF_FRICTION = 0.0015, 0.0005, 0.07
"""How far logs differ, as standard deviations: in force, and in what a tilt does over half the travel, as shares of the
greatest force; in friction, and in its growth over half the travel, as shares of the friction.

Sensors of force and pressure hold their zero within one or two thousandths of what they measure, which is some per cent
of a loop; what friction differs by when a test is repeated is some per cent as well.
"""

BENT = 1.0  # standard deviation of the exponent with which friction grows with pressure
LEAST_EXPONENT, GREATEST_EXPONENT = 0.2, 5.0
UNEVEN = 0.1  # standard deviation of the friction along the stroke, a share of it
CHANGE = 0.01  # standard deviation of what a change of shape does, a share of the greatest force
STEADY, FILM = 2.0, 1e-3
"""The slowest log's working speed over the greatest speed of a film (its friction then changes by less than 4 %), and
the least speed of a film over that working speed."""

FAR = 10.0  # bounds of what has a prior lie so many standard deviations away

OWN = ("offset", "tilt", "friction", "friction_tilt")  # what a log has of its own


class Sizes:
    """How large forces and motions are in the logs of a rod."""

    def __init__(self, outputs: Sequence[Output], logs: Sequence[RodLog]) -> None:
        measured = [out.measured[np.isfinite(out.measured)] for out in outputs]
        self.most = max(float(np.abs(one).max()) for one in measured)  # greatest force
        self.reach = max(float(np.ptp(one)) for one in measured)  # greatest range of force within a log
        self.pressure = max(float(np.abs(log.pressure).max()) for log in logs) + 1e3
        self.speed = max(float(np.abs(log.speed).max()) for log in logs) + 1e-6
        fitted = [(out, log) for out, log in zip(outputs, logs, strict=True) if out.fitted.any()]
        self.first = min(float(log.position.min()) for _, log in fitted)
        self.last = max(float(log.position.max()) for _, log in fitted)
        moving = [np.abs(log.speed[log.speed != 0.0]) for log in logs]
        self.slowest = min(float(np.median(one)) for one in moving)  # working speed of the slowest log
        self.travel = max(float(np.ptp(log.position)) for log in logs)
        # Of the logs as wholes: a log counts by its mean pressure.
        self.pressures: Array = np.array([log.pressure.mean() for _, log in fitted])

    @property
    def middle(self) -> float:
        """Position in the middle of all strokes."""
        return 0.5 * (self.first + self.last)

    @property
    def half(self) -> float:
        """Half of all strokes."""
        return 0.5 * (self.last - self.first)


def unknowns_of(bench: RodBench, sizes: Sizes, logs: Sequence[str]) -> dict[str, list[Unknown]]:
    """By block; `logs` are the names of those that are fitted."""
    piston, friction = bench.piston, bench.friction
    area, tilt, fastest = sizes.most / sizes.pressure, sizes.reach / sizes.travel, sizes.reach / sizes.speed
    steep, speeds = tilt / sizes.pressure, "speeds that differ at each pressure"
    most, turns = sizes.most, "reversals, sampled finely where the motion reverses"
    film = within("friction.film_share", "1", friction.film_share, 0.0, 1.0, turns, floor=True, ceiling=True)
    # A film that speeds up to those of the logs would change could not be told from a growth with pressure.
    slow = (FILM * sizes.slowest, sizes.slowest / STEADY)
    speed = within("friction.film_speed", "m/s", friction.film_speed, *slow, turns, log=True, ceiling=True)
    return {
        "piston": [
            within("piston.area", "m^2", piston.area, 1e-3 * area, 1e2 * area, SLOPES, log=True),
            within("piston.area_slope", "m", piston.area_slope, -steep, steep, SLOPES),
            within("piston.spring", "N/m", piston.spring, -tilt, tilt, "long strokes"),
            within("piston.offset", "N", piston.offset, -most, most, SLOPES),
        ],
        "friction": [
            within("friction.base", "N", friction.base, 0.0, sizes.reach, SLOPES),
            within("friction.slope", "N/Pa", friction.slope, 0.0, sizes.reach / sizes.pressure, SLOPES),
            exponent_unknown(bench),
            *element_unknowns("friction", "m", friction.deflections, friction.weights, sizes.travel),
            film,
            speed,
        ],
        "profile": [_small(f"friction.profile.{j}", "1", UNEVEN, LOGS) for j in range(len(friction.profile))],
        "shape": shape_unknowns(bench, sizes),
        "viscous": [within("friction.viscous", "N*s/m", friction.viscous, 0.0, fastest, speeds)],
        "logs": [one for name in logs for one in _of_log(name, sizes)] if len(logs) > 1 else [],
    }


def shape_unknowns(bench: RodBench, sizes: Sizes) -> list[Unknown]:
    """What pressure adds to the area where it changes the shape of the seal."""
    half = max(0.5 * float(np.ptp(sizes.pressures)), 1e-3 * sizes.pressure)
    bend = CHANGE * sizes.most / half**2
    grown, guess = "piston.area_growth", bench.piston
    return [
        _small(grown, "m^2/Pa", bend, SHAPES, guess.area_growth),
        _small("piston.area_slope_growth", "m/Pa", bend / sizes.half, SHAPES, guess.area_slope_growth),
    ]


def exponent_unknown(bench: RodBench) -> Unknown:
    """Return the exponent with which friction grows with pressure, as an unknown."""
    n, bounds = bench.friction.exponent, (LEAST_EXPONENT, GREATEST_EXPONENT)
    return Unknown("friction.exponent", "1", n, *bounds, log=False, excitation=SHAPES, prior=(n, BENT))


def _of_log(name: str, sizes: Sizes) -> list[Unknown]:
    force, tilt = OF_FORCE * sizes.most, OF_TILT * sizes.most / sizes.half
    spreads = (force, tilt, OF_FRICTION, OF_FRICTION)
    units = ("N", "N/m", "1", "1")
    return [
        _small(f"log.{what}.{name}", unit, spread, "", nuisance=True)
        for what, unit, spread in zip(OWN, units, spreads, strict=True)
    ]


def _small(
    path: str, unit: str, spread: float, excitation: str, guess: float = 0.0, *, nuisance: bool = False
) -> Unknown:
    """An unknown that is zero but for some standard deviations; a profile and its like never reach -1."""
    far = FAR * spread if unit != "1" else min(FAR * spread, 0.9)
    guess = float(np.clip(guess, -far, far))
    prior = (0.0, spread)
    return Unknown(path, unit, guess, -far, far, log=False, excitation=excitation, nuisance=nuisance, prior=prior)
