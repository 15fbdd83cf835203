"""What the questions take from the tables of their studies."""

from collections.abc import Sequence

import numpy as np
import pandas

from layflat.arrays import Array
from layflat.experiments.axis_one import limit_within
from layflat.experiments.bench import INERTIA_PER_TORQUE, maximum_torque
from layflat.machine import Machine
from layflat.sim.sweep import sweep

JOINT = "small"  # that the studies of one joint are about


def grid(frame: pandas.DataFrame, across: str, upward: str, column: str) -> tuple[Array, Array, Array]:
    """Return values of two columns in order, and the median of a third where they meet, (upward, across).

    A run that diverged counts as infinite, and so does the median of runs half of which are.
    """
    values = frame.assign(**{column: frame[column].fillna(np.inf)})
    wide = values.groupby([upward, across])[column].quantile(0.5, interpolation="higher").unstack()
    return wide.columns.to_numpy(dtype=float), wide.index.to_numpy(dtype=float), wide.to_numpy(dtype=float)


def inertia_per_torque(machine: Machine, payload: Array) -> Array:
    """Return inertia of payloads (kg) at the end of the link, per maximum torque, kg m2 per N m."""
    return payload * machine.joint[JOINT].planar_link.length ** 2 / maximum_torque(machine, JOINT)


def limits(ratios: Array, times: Array, allowed: float) -> Array:
    """Return the largest inertia per torque, from the paper's comparison on, up to which all settle in time.

    Times to settle and the time allowed are in s, (ratios, cases). There is a limit for each case; 0 where not even the
    inertia of the paper's comparison settles.
    """
    known = ratios >= INERTIA_PER_TORQUE
    return np.array([limit_within(dict(zip(ratios[known], own[known], strict=True)), allowed) for own in times.T])


def hysteresis(machine: Machine, brake: float = 1.0) -> float:
    """Return loop height over greatest torque at supply pressure, %."""
    return 100.0 * sweep(machine, JOINT, machine.supply.pressure_gauge, brake=brake).hysteresis


def at_rest(frame: pandas.DataFrame, moves: Sequence[str]) -> Array:
    """Return how far a joint is off at the end of each move, deg: mean error and half the ripple, (runs, moves)."""
    error = frame[[f"steady_error.{move}" for move in moves]].abs().to_numpy(dtype=float)
    ripple = frame[[f"ripple.{move}" for move in moves]].to_numpy(dtype=float)
    return np.asarray(np.degrees(error + 0.5 * ripple))


def moves_of(frame: pandas.DataFrame) -> list[str]:
    """Return joint and number of every move of a table, such as "small.0"."""
    return [name.removeprefix("settling.") for name in frame.columns if name.startswith("settling.")]


def listed(words: Sequence[str]) -> str:
    """Return words as a list in a sentence."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
