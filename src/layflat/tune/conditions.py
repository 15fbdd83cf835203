"""What gains have to stand: payload, supply, losses, drift and noise that differ, and several moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine
from layflat.machine.change import value_at
from layflat.sim import Scenario

Array = NDArray[np.float64]

POSTURES = {
    1: (
        ((-1 / 3,), (1 / 3,), (0.36,)),
        ((1 / 3,), (-1 / 3,), (-1 / 2,)),
        ((0.0,), (1 / 6,), (-2 / 3,)),
    ),
    2: (
        ((-1 / 3, -1 / 3), (1 / 3, -1 / 3), (1 / 3, 1 / 3)),
        ((1 / 3, 1 / 3), (-1 / 3, 1 / 3), (-1 / 3, -1 / 3)),
        ((0.0, 0.0), (1 / 6, 1 / 6), (-1 / 2, 1 / 2)),
        ((1 / 3, 0.0), (0.36, -1 / 2), (-2 / 3, -0.54)),
    ),
}
"""Sequences of postures by the number of joints, angles as shares of half a stroke.

Of 120 deg that makes steps of 40 deg of one joint at a time either way, and others of both together, from 2 to 60 deg.
"""

REST = 0.3
"""Time at the first posture, s."""

PULL = 0.15
"""Shares of a range that count as its ends: there the worst is met."""


@dataclass(frozen=True)
class Spread:
    """How far conditions may be from nominal.

    Args:
        payload: from nothing to this, kg.
        supply: share of the gauge supply pressure, either way.
        losses: share of the losses in hoses and straps, either way.
        drift: of the valves' centres, V, either way.
        window: time that a move is given, s.
    """

    payload: float = 2.0
    supply: float = 0.1
    losses: float = 0.3
    drift: float = 0.1
    window: float = 1.7


@dataclass(frozen=True)
class Conditions:
    """What a candidate is judged by: every condition with every sequence of moves.

    Args:
        scenarios: the sequences.
        vary: one number a condition, by path (see `sim.ensemble`); the first condition is the nominal one.
        window: time that a move is given, s.
    """

    scenarios: list[Scenario]
    vary: Mapping[str, Array]
    window: float
    runs: int = field(init=False)
    """Of one candidate."""

    def __post_init__(self) -> None:
        """Count the runs."""
        object.__setattr__(self, "runs", len(self.vary["seed"]) * len(self.scenarios))

    def of(self, candidates: int) -> dict[str, Array]:
        """What varies over the runs of so many candidates, one candidate after the other."""
        moves = len(self.scenarios)
        vary = {path: np.tile(np.repeat(values, moves), candidates) for path, values in self.vary.items()}
        return {**vary, "scenario": np.tile(np.arange(moves), self.runs // moves * candidates)}


def conditions(machine: Machine, count: int, spread: Spread | None = None, seed: int = 0) -> Conditions:
    """Conditions that fill the spread evenly, its ends included.

    Args:
        machine: nominal.
        count: of conditions; a power of two.
        spread: how far they go.
        seed: of the choice, and of the first condition's noise.
    """
    from scipy.stats import qmc  # noqa: PLC0415  # takes long to import

    spread, names = spread or Spread(), list(machine.joints)
    share = qmc.Sobol(3 + len(names), seed=seed).random(count)
    share = np.where(share < PULL, 0.0, np.where(share > 1.0 - PULL, 1.0, share))
    about = 2.0 * share - 1.0
    vary = {
        "arm.payload": spread.payload * share[:, 0],
        "supply.pressure_gauge": machine.supply.pressure_gauge * (1.0 + spread.supply * about[:, 1]),
        "seed": seed + np.arange(count, dtype=float),
    }
    for j, name in enumerate(names):
        vary[f"scenario.drift.{name}"] = spread.drift * about[:, 3 + j]
        for part, usual in (("hose", machine.joint[name].hose), ("strap", machine.joint[name].strap)):
            vary[f"joint.{name}.{part}.loss_share"] = usual.loss_share * (1.0 + spread.losses * about[:, 2])
    for path, values in vary.items():
        if path != "seed":
            values[0] = _nominal(machine, path)
    scenarios = [_moves(machine, postures, spread.window) for postures in POSTURES[len(names)]]
    return Conditions(scenarios, vary, spread.window)


def _nominal(machine: Machine, path: str) -> float:
    return 0.0 if path.startswith("scenario.") else float(value_at(machine, path))


def _moves(machine: Machine, postures: tuple[tuple[float, ...], ...], window: float) -> Scenario:
    halves = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
    rows = [[share * half for share, half in zip(posture, halves, strict=True)] for posture in postures]
    times = [0.0, *(REST + window * i for i in range(len(rows) - 1))]
    return Scenario(demand=list(zip(times, rows, strict=True)), duration=REST + window * (len(rows) - 1))
