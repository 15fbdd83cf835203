"""A friction test bench: force on a rod from its position and the pressure in the chamber.

A log is a data set over `time` (s) with `position` (m), `pressure` (absolute, Pa) and `force` (N), the force that moves
the rod, positive the way the position is. Logs at two pressures or more show how friction grows with pressure, at three
or more whether pressure changes the shape of the seal.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description.change import changed_all, value_at
from layflat.identify.benches.contract import Bench, Logs, chosen, simulated
from layflat.identify.benches.hysteresis import logs as curves
from layflat.identify.benches.hysteresis.model import CurveModel
from layflat.identify.benches.rod.description import RodBench
from layflat.identify.benches.rod.laws import Rod, RodLog, rod_force
from layflat.identify.benches.rod.linear import linear_step
from layflat.identify.benches.rod.shape import terms_shown
from layflat.identify.benches.rod.unknowns import OWN, Sizes, unknowns_of
from layflat.identify.logs.checks.channels import without_spikes
from layflat.identify.model import Output

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
