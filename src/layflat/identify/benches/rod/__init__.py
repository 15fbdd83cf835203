"""Model of a friction test bench: force on a rod from its position and the pressure in the chamber.

A log is a data set over `time` (s) with `position` (m), `pressure` (absolute, Pa) and `force` (N), the force that moves
the rod, positive in the direction of the position. Logs at two pressures or more show the growth of friction with
pressure, at three or more a change of the seal's shape with pressure.

Logs of one seal differ by more than pressure: sensors are set to zero anew, grease and wear move, a rod is loaded from
another side. Every fitted log therefore has an offset of force, a tilt, and a factor of friction (nuisances), known to
be small. Without them a fit would attribute such differences to pressure.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description.change import changed_all, value_at
from layflat.identify.benches import BenchKind, Logs, select_blocks, simulate_candidates
from layflat.identify.benches import hysteresis as curves
from layflat.identify.benches.hysteresis import FINE_REVERSALS, CurveModel, bounded_unknown, element_unknowns
from layflat.identify.benches.rod.description import RodBench
from layflat.identify.benches.rod.laws import Rod, RodLog, rod_force
from layflat.identify.benches.rod.linear import linear_step, select_terms
from layflat.identify.logs.checks.channels import median_filter
from layflat.identify.model import ModelOutput, Unknown

LOOPS_AT_TWO_PRESSURES = "loops at two pressures or more, the higher the further apart"
LOOPS_AT_THREE_PRESSURES = "loops at three pressures or more, from low to high"
REPEATED_LOGS = "more logs at the same pressures"

FORCE_DEVIATION, TILT_DEVIATION, FRICTION_DEVIATION = 0.0015, 0.0005, 0.07
"""Standard deviations between logs: of the force, and of a tilt's force over half the travel, as fractions of the
greatest force; of the friction, and of its growth over half the travel, as fractions of the friction.

Sensors of force and pressure hold their zero within one or two thousandths of their reading, which is some per cent of
a loop; friction differs by some per cent as well when a test is repeated.
"""

EXPONENT_DEVIATION = 1.0  # standard deviation of the exponent with which friction grows with pressure
MIN_EXPONENT, MAX_EXPONENT = 0.2, 5.0
PROFILE_DEVIATION = 0.1  # standard deviation of the friction along the stroke, as a fraction of it
SHAPE_DEVIATION = 0.01  # standard deviation of the force of a change of shape, as a fraction of the greatest force
MIN_WORKING_SPEED_RATIO = 2.0  # the slowest log's working speed over a film's: its friction changes by less than 4 %
MIN_FILM_SPEED_RATIO = 1e-3  # least speed of a film over that working speed

PRIOR_BOUND_DEVIATIONS = 10.0  # from the prior's mean to the bounds, in standard deviations

LOG_EFFECTS = ("offset", "tilt", "friction", "friction_tilt")  # nuisances of each log


class RodScales:
    """Greatest forces, pressures and motions in the logs of a rod: they set the bounds of its unknowns."""

    def __init__(self, outputs: Sequence[ModelOutput], logs: Sequence[RodLog]) -> None:
        measured = [out.measured[np.isfinite(out.measured)] for out in outputs]
        self.max_force = max(float(np.abs(one).max()) for one in measured)
        self.max_force_range = max(float(np.ptp(one)) for one in measured)  # within a log
        self.max_pressure = max(float(np.abs(log.pressure).max()) for log in logs) + 1e3
        self.max_speed = max(float(np.abs(log.speed).max()) for log in logs) + 1e-6
        fitted = [(out, log) for out, log in zip(outputs, logs, strict=True) if out.fitted.any()]
        self.min_position = min(float(log.position.min()) for _, log in fitted)
        self.max_position = max(float(log.position.max()) for _, log in fitted)
        moving = [np.abs(log.speed[log.speed != 0.0]) for log in logs]
        self.min_working_speed = min(float(np.median(one)) for one in moving)  # of the slowest log
        self.travel = max(float(np.ptp(log.position)) for log in logs)
        self.pressures: Array = np.array([log.pressure.mean() for _, log in fitted])  # mean of each fitted log

    @property
    def middle(self) -> float:
        """Return the position in the middle of all strokes, m."""
        return 0.5 * (self.min_position + self.max_position)

    @property
    def half_stroke(self) -> float:
        """Return half of the range of all strokes, m."""
        return 0.5 * (self.max_position - self.min_position)


def rod_unknowns(bench: RodBench, scales: RodScales, logs: Sequence[str]) -> dict[str, list[Unknown]]:
    """Return the unknowns of a bench by block: those of `ROD_BLOCKS`, and `logs`.

    Args:
        bench: bench as described; its values are the guesses.
        scales: scales of its logs, from which the bounds follow.
        logs: names of those that are fitted; a single one has no nuisances.
    """
    piston, friction = bench.piston, bench.friction
    force, span = scales.max_force, scales.max_force_range
    area, tilt, damping = force / scales.max_pressure, span / scales.travel, span / scales.max_speed
    steep, speeds = tilt / scales.max_pressure, "speeds that differ at each pressure"
    areas, forces, pressures = (1e-3 * area, 1e2 * area), (-force, force), LOOPS_AT_TWO_PRESSURES
    share = bounded_unknown(
        "friction.film_fraction", "1", friction.film_fraction, (0.0, 1.0), FINE_REVERSALS, floor=True, ceiling=True
    )
    # A film whose friction changes up to the speeds of the logs would be indistinguishable from a growth with pressure.
    film_speeds = (
        MIN_FILM_SPEED_RATIO * scales.min_working_speed, scales.min_working_speed / MIN_WORKING_SPEED_RATIO
    )  # fmt: skip
    speed = bounded_unknown(
        "friction.film_speed", "m/s", friction.film_speed, film_speeds, FINE_REVERSALS, log=True, ceiling=True
    )
    return {
        "piston": [
            bounded_unknown("piston.area", "m^2", piston.area, areas, pressures, log=True),
            bounded_unknown("piston.area_slope", "m", piston.area_slope, (-steep, steep), pressures),
            bounded_unknown("piston.spring", "N/m", piston.spring, (-tilt, tilt), "long strokes"),
            bounded_unknown("piston.offset", "N", piston.offset, forces, pressures),
        ],
        "friction": [
            bounded_unknown("friction.base", "N", friction.base, (0.0, span), pressures),
            bounded_unknown("friction.slope", "N/Pa", friction.slope, (0.0, span / scales.max_pressure), pressures),
            exponent_unknown(bench),
            *element_unknowns("friction", "m", friction.deflections, friction.weights, scales.travel),
            share,
            speed,
        ],
        "profile": [
            _small_unknown(f"friction.profile.{j}", "1", PROFILE_DEVIATION, REPEATED_LOGS)
            for j in range(len(friction.profile))
        ],
        "shape": shape_unknowns(bench, scales),
        "viscous": [bounded_unknown("friction.viscous", "N*s/m", friction.viscous, (0.0, damping), speeds)],
        "logs": [one for name in logs for one in _log_unknowns(name, scales)] if len(logs) > 1 else [],
    }


def shape_unknowns(bench: RodBench, scales: RodScales) -> list[Unknown]:
    """Return the growth of the area with pressure, of a seal that changes its shape, as unknowns."""
    half = max(0.5 * float(np.ptp(scales.pressures)), 1e-3 * scales.max_pressure)
    growth, piston, excitation = SHAPE_DEVIATION * scales.max_force / half**2, bench.piston, LOOPS_AT_THREE_PRESSURES
    slope_growth = growth / scales.half_stroke
    return [
        _small_unknown("piston.area_growth", "m^2/Pa", growth, excitation, piston.area_growth),
        _small_unknown("piston.area_slope_growth", "m/Pa", slope_growth, excitation, piston.area_slope_growth),
    ]


def exponent_unknown(bench: RodBench) -> Unknown:
    """Return the exponent with which friction grows with pressure, as an unknown."""
    n, bounds = bench.friction.exponent, (MIN_EXPONENT, MAX_EXPONENT)
    prior = (n, EXPONENT_DEVIATION)
    return Unknown("friction.exponent", "1", n, *bounds, log=False, excitation=LOOPS_AT_THREE_PRESSURES, prior=prior)


def _log_unknowns(name: str, scales: RodScales) -> list[Unknown]:
    """Return the unknowns of one log that are nuisances: offset of force, tilt, and deviations of friction."""
    force, tilt = FORCE_DEVIATION * scales.max_force, TILT_DEVIATION * scales.max_force / scales.half_stroke
    deviations = (force, tilt, FRICTION_DEVIATION, FRICTION_DEVIATION)
    units = ("N", "N/m", "1", "1")
    return [
        _small_unknown(f"log.{effect}.{name}", unit, deviation, "", nuisance=True)
        for effect, unit, deviation in zip(LOG_EFFECTS, units, deviations, strict=True)
    ]


def _small_unknown(
    path: str, unit: str, deviation: float, excitation: str, guess: float = 0.0, *, nuisance: bool = False
) -> Unknown:
    """Return an unknown with the prior mean zero and a standard deviation; fractions of friction never reach -1."""
    limit = PRIOR_BOUND_DEVIATIONS * deviation if unit != "1" else min(PRIOR_BOUND_DEVIATIONS * deviation, 0.9)
    guess = float(np.clip(guess, -limit, limit))
    prior = (0.0, deviation)
    return Unknown(path, unit, guess, -limit, limit, log=False, excitation=excitation, nuisance=nuisance, prior=prior)


ROD_BLOCKS = ("piston", "friction", "profile", "shape", "viscous")
DEFAULT_BLOCKS = ("piston", "friction", "profile", "shape")
"""Default blocks: `viscous` needs different speeds at each pressure; `shape` is dropped unless logs show it."""

ROD_PATHS = (
    "piston.area", "piston.area_slope", "piston.area_growth", "piston.area_slope_growth", "piston.spring",
    "piston.offset", "friction.base", "friction.slope", "friction.viscous", "friction.film_fraction",
    "friction.film_speed",
)  # fmt: skip
"""Paths of the parameters of a `Rod` in the description."""

ERROR_CORRELATION_TIME = 0.5  # of a force, s: errors are of a loop's shape, and no noise

FILM_STARTS, LINEAR_STEPS = (0.1, 0.5, 0.8), 2  # shares of the film at the starts, and linear steps from each

PROFILE_ENDS = ("friction.profile_from", "friction.profile_to")


class RodModel(CurveModel[RodBench]):
    """Model of the forces in the logs of a friction test bench; built as `BenchKind` says.

    Terms that the fitted logs do not show are left out, see `select_terms`; `remarks` says so.
    """

    losses = "friction"

    def __init__(
        self, bench: RodBench, logs: Logs, validation: Logs | None = None, *, blocks: Sequence[str] = DEFAULT_BLOCKS
    ) -> None:
        self.outputs = tuple(map(_widen_scale, curves.effort_outputs(logs, validation, "force", "N")))
        self.logs = []
        for log, out in zip([*logs.values(), *(validation or {}).values()], self.outputs, strict=True):
            position = curves.read_moving_signal(log, "position", out.log)
            pressure = median_filter(curves.read_signal(log, "pressure", out.log)) - bench.ambient_pressure
            speed = curves.smoothed_rate(out.time, position)
            self.logs.append(RodLog(position, speed, pressure, curves.first_sample(out), pressure.mean()))
        self.motions = tuple(log.position for log in self.logs)
        self.scales = RodScales(self.outputs, self.logs)
        self.spread_profile = "profile" in blocks and bool(bench.friction.profile) and not any(bench.friction.profile)
        if self.spread_profile:
            ends = dict(zip(PROFILE_ENDS, (self.scales.min_position, self.scales.max_position), strict=True))
            bench = changed_all(bench, ends)
        self.origin = bench
        table = rod_unknowns(bench, self.scales, list(logs))
        of_logs = table.pop("logs") if blocks else []
        self.unknowns = (*select_blocks(table, blocks), *of_logs)
        self.unknowns, self.remarks = select_terms(self, self.scales.pressures)

    def simulate(self, values: Array) -> Array:
        """Return the forces of all logs, (candidates, samples): see `Model.simulate`."""
        rod, columns = parameters(self.describe_candidates(values)), self.columns(values)
        cases = [
            (self._rod_in_log(rod, out.log, columns), log) for log, out in zip(self.logs, self.outputs, strict=True)
        ]
        shapes = [one.shape for one in self.motions]
        return np.concatenate(simulate_candidates(rod_force, len(values), cases, shapes), axis=1)

    def starts(self) -> Array:
        """Return starts by linear least squares, (starts, unknowns), the best first.

        Only deflections and the film are far from linear: there is a start per value in `FILM_STARTS` if it is fitted.
        """
        guess = np.array([one.guess for one in self.unknowns])
        film = [i for i, one in enumerate(self.unknowns) if one.path == "friction.film_fraction"]
        starts = []
        for share in FILM_STARTS if film else (0.0,):
            values = guess.copy()
            values[film] = share
            for _ in range(LINEAR_STEPS):
                values, cost = linear_step(self, values)
            starts.append((cost, values))
        return np.array([values for _, values in sorted(starts, key=lambda start: start[0])])

    def described_values(self, values: Array) -> dict[str, float]:
        """Return values by their paths in the description, with the ends of a profile laid over the logs' positions."""
        ends = {path: float(value_at(self.origin, path)) for path in PROFILE_ENDS} if self.spread_profile else {}
        return super().described_values(values) | ends

    def _rod_in_log(self, rod: Rod, log: str, columns: dict[str, Any]) -> Rod:
        """Return the rod with the nuisances of a log, if they are fitted."""
        force, tilt, friction, slope = (columns.get(f"log.{effect}.{log}", 0.0) for effect in LOG_EFFECTS)
        middle, half = self.scales.middle, self.scales.half_stroke
        positions = [rod.profile_from + j * rod.profile_step for j in range(len(rod.profile))]
        profile = [b + slope * (x - middle) / half for b, x in zip(rod.profile, positions, strict=True)]
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
    numbers: dict[str, Any] = {path.rpartition(".")[2]: value_at(bench, path) for path in ROD_PATHS}
    level = friction.base + friction.slope * friction.reference_pressure_gauge
    weights = tuple(weight * (1.0 - friction.film_fraction) for weight in friction.weights)
    stiffness = tuple(weight * level / d for weight, d in zip(weights, friction.deflections, strict=True))
    profile: dict[str, Any] = {}
    if friction.profile:
        step = (friction.profile_to - friction.profile_from) / (len(friction.profile) - 1)
        profile = {"profile": friction.profile, "profile_from": friction.profile_from, "profile_step": step}
    numbers |= {"exponent": friction.exponent, "reference_pressure": friction.reference_pressure_gauge}
    return Rod(weights=weights, stiffness=stiffness, **numbers, **profile)


def _widen_scale(output: ModelOutput) -> ModelOutput:
    """Return an output with a scale at which samples within the correlation time of its errors count as one."""
    samples = ERROR_CORRELATION_TIME / float(np.median(np.diff(output.time)))
    return replace(output, scale=output.scale * np.sqrt(max(samples, 1.0)))


DESCRIPTION = RodBench
BENCH = BenchKind(ROD_BLOCKS, DEFAULT_BLOCKS, RodModel, even=False)
