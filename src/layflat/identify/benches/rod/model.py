"""A friction test bench: force on a rod from its position and the pressure in the chamber.

A log is a data set over `time` (s) with `position` (m), `pressure` (absolute, Pa) and `force` (N), the force that moves
the rod, positive the way the position is. Logs at two pressures or more show how friction grows with pressure, at three
or more whether pressure changes the shape of the seal.

Logs of one seal differ by more than pressure: sensors are set to zero anew, grease and wear move, a rod is loaded from
another side. Every fitted log therefore has a force, a tilt, and a friction of its own (nuisances), known to be small.
Without them a fit would take what one log happens to have for a law of pressure.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description.change import changed_all, value_at
from layflat.identify.benches.contract import Bench, Logs, chosen, simulated
from layflat.identify.benches.hysteresis import logs as curves
from layflat.identify.benches.hysteresis.model import CurveModel, element_unknowns, within
from layflat.identify.benches.rod.description import RodBench
from layflat.identify.benches.rod.laws import Rod, RodLog, rod_force
from layflat.identify.benches.rod.linear import linear_step, terms_shown
from layflat.identify.logs.checks.channels import without_spikes
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
    """Sizes of forces and motions in the logs of a rod."""

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
    """Return what pressure adds to the area where it changes the shape of the seal."""
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


BLOCKS = ("piston", "friction", "profile", "shape", "viscous")
DEFAULT_BLOCKS = ("piston", "friction", "profile", "shape")
"""`viscous` is for logs of speeds that differ at each pressure; `shape` is fitted where logs show it to change."""

NUMBERS = (
    "piston.area", "piston.area_slope", "piston.area_growth", "piston.area_slope_growth", "piston.spring",
    "piston.offset", "friction.base", "friction.slope", "friction.viscous", "friction.film_share",
    "friction.film_speed",
)  # fmt: skip
"""Where the parameters of a `Rod` stand in the description."""

MEMORY = 0.5  # errors of a force resemble each other for so long (s): they are of the shape of a loop, and no noise

FILMS, STEPS = (0.1, 0.5, 0.8), 2  # shares of the film that are tried at first, and linear steps from each

ENDS = ("friction.profile_from", "friction.profile_to")


class RodModel(CurveModel[RodBench]):
    """Forces in the logs of a friction test bench; made as `Bench` says."""

    losses = "friction"

    def __init__(
        self, bench: RodBench, logs: Logs, validation: Logs | None = None, *, blocks: Sequence[str] = DEFAULT_BLOCKS
    ) -> None:
        self.outputs = tuple(map(_alike, curves.outputs(logs, validation, "force", "N")))
        self.logs = []
        for log, out in zip([*logs.values(), *(validation or {}).values()], self.outputs, strict=True):
            position = curves.moving(log, "position", out.log)
            pressure = without_spikes(curves.signal(log, "pressure", out.log)) - bench.ambient_pressure
            self.logs.append(
                RodLog(position, curves.rate(out.time, position), pressure, curves.first_of(out), pressure.mean())
            )
        self.motions = tuple(log.position for log in self.logs)
        self.sizes = Sizes(self.outputs, self.logs)
        self.spread_profile = "profile" in blocks and bool(bench.friction.profile) and not any(bench.friction.profile)
        if self.spread_profile:
            ends = dict(zip(ENDS, (self.sizes.first, self.sizes.last), strict=True))
            bench = changed_all(bench, ends)
        self.origin = bench
        table = unknowns_of(bench, self.sizes, list(logs))
        own = table.pop("logs") if blocks else []
        self.unknowns = (*chosen(table, blocks), *own)
        self.unknowns, self.remarks = terms_shown(self, self.sizes.pressures)

    def simulate(self, values: Array) -> Array:
        """Forces by candidate: see `Model.simulate`."""
        rod, columns = parameters(self.candidates(values)), self.columns(values)
        cases = [(self._as_in(rod, out.log, columns), log) for log, out in zip(self.logs, self.outputs, strict=True)]
        shapes = [one.shape for one in self.motions]
        return np.concatenate(simulated(rod_force, len(values), cases, shapes), axis=1)

    def starts(self) -> Array:
        """Starts from linear least squares, the best first: all enters nearly linearly but deflections and the film."""
        guess = np.array([one.guess for one in self.unknowns])
        film = [i for i, one in enumerate(self.unknowns) if one.path == "friction.film_share"]
        found = []
        for share in FILMS if film else (0.0,):
            at = guess.copy()
            at[film] = share
            for _ in range(STEPS):
                at, cost = linear_step(self, at)
            found.append((cost, at))
        return np.array([at for _, at in sorted(found, key=lambda one: one[0])])

    def written(self, values: Array) -> dict[str, float]:
        """Return the found values by their paths in the description; see `Model.written`."""
        ends = {path: float(value_at(self.origin, path)) for path in ENDS} if self.spread_profile else {}
        return super().written(values) | ends

    def _as_in(self, rod: Rod, log: str, columns: dict[str, Any]) -> Rod:
        """The rod as it is in a log: with what that has of its own, if it is fitted."""
        force, tilt, friction, uneven = (columns.get(f"log.{what}.{log}", 0.0) for what in OWN)
        middle, half = self.sizes.middle, self.sizes.half
        places = [rod.profile_from + j * rod.profile_step for j in range(len(rod.profile))]
        profile = [b + uneven * (x - middle) / half for b, x in zip(rod.profile, places, strict=True)]
        return rod._replace(
            offset=rod.offset + force - tilt * middle,
            spring=rod.spring + tilt,
            base=rod.base * (1.0 + friction),
            slope=rod.slope * (1.0 + friction),
            profile=tuple(profile),
        )


def parameters(bench: RodBench) -> Rod:
    """Return the parameters of the laws from a description."""
    friction = bench.friction
    found: dict[str, Any] = {path.rpartition(".")[2]: value_at(bench, path) for path in NUMBERS}
    level = friction.base + friction.slope * friction.reference_pressure_gauge
    weights = tuple(weight * (1.0 - friction.film_share) for weight in friction.weights)
    stiffness = tuple(weight * level / d for weight, d in zip(weights, friction.deflections, strict=True))
    along: dict[str, Any] = {}
    if friction.profile:
        step = (friction.profile_to - friction.profile_from) / (len(friction.profile) - 1)
        along = {"profile": friction.profile, "profile_from": friction.profile_from, "profile_step": step}
    found |= {"exponent": friction.exponent, "reference_pressure": friction.reference_pressure_gauge}
    return Rod(weights=weights, stiffness=stiffness, **found, **along)


def _alike(output: Output) -> Output:
    """Count samples whose errors resemble each other as one."""
    alike = MEMORY / float(np.median(np.diff(output.time)))
    return replace(output, scale=output.scale * np.sqrt(max(alike, 1.0)))


BENCH = Bench(BLOCKS, DEFAULT_BLOCKS, RodModel, even=False)
