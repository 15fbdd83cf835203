"""What models of hysteresis curves have in common, of a joint or of a rod: elements that slip one after the other."""

from collections.abc import Mapping, Sequence
from typing import Any, Generic, TypeVar

import numpy as np

from layflat.arrays import Array
from layflat.description import Part
from layflat.description.change import changed_all, value_at
from layflat.identify.benches.contract import with_columns
from layflat.identify.model import Model
from layflat.identify.unknown import Unknown

Described = TypeVar("Described", bound=Part)

LEAST, MOST = 1e-6, 2.0
"""An element slips after so much of the longest travel in the logs: it is Coulomb friction below, a spring above.

The least is far below what any log shows, so that friction which slips at once does not hit a bound.
"""

DECIMALS = 6  # of weights in a description


class CurveModel(Model, Generic[Described]):
    """Efforts in logs of hysteresis curves."""

    origin: Described  # where the search begins, and what is held
    losses: str  # path of the table with the deflections and weights of the elements
    motions: tuple[Array, ...]  # angle (rad) or position (m) of every log

    def candidates(self, values: Array) -> Described:
        """Return the description with arrays, an item a candidate, for what is fitted."""
        return with_columns(self.origin, self._found(self.columns(values)))

    def described(self, values: Array) -> Described:
        """Return the description with values of the unknowns (SI) in their places."""
        found = self._found({path: float(value) for path, value in self.columns(values).items()})
        if self._weights in found:
            found[self._weights] = rounded(np.array(found[self._weights]))
        return changed_all(self.origin, found)

    def written(self, values: Array) -> dict[str, float]:
        """What was found, by its path in the description: weights in place of how they are split."""
        described, found = self.described(values), self._found(self.columns(values))
        weights = [f"{self._weights}.{j}" for j in range(len(found.pop(self._weights, ())))]
        return {path: float(value_at(described, path)) for path in (*found, *weights)}

    @property
    def _weights(self) -> str:
        return f"{self.losses}.weights"

    def _found(self, columns: Mapping[str, Any]) -> dict[str, Any]:
        """Numbers or arrays by their paths in the description."""
        own = [unknown.path for unknown in self.unknowns if not unknown.nuisance]
        found = {path: columns[path] for path in own if ".split." not in path}
        split = [columns[path] for path in own if ".split." in path]
        if split:
            found[self._weights] = tuple(np.moveaxis(shares_of(np.stack(split, axis=-1)), -1, 0))
        return found


def within(
    path: str,
    unit: str,
    guess: float,
    low: float,
    high: float,
    excitation: str,
    *,
    log: bool = False,
    floor: bool = False,
    ceiling: bool = False,
) -> Unknown:
    """An unknown with bounds that come from the logs; the search begins at the guess as far as it lies inside."""
    inside = float(np.clip(guess, low, high))
    return Unknown(path, unit, inside, low, high, log=log, excitation=excitation, floor=floor, ceiling=ceiling)


def element_unknowns(
    where: str, unit: str, deflections: Sequence[float], weights: Sequence[float], travel: float
) -> list[Unknown]:
    """Deflections of elements, and how they share the friction (see `shares_of`), as unknowns.

    Described are `deflections`, in the `unit` of the motion, and `weights`, in the table at `where`; the longest
    travel in all logs bounds them.
    """
    fine = "reversals, sampled finely where the motion reverses"
    low, high = LEAST * travel, MOST * travel
    found = [within(f"{where}.deflections.{j}", unit, d, low, high, fine, log=True) for j, d in enumerate(deflections)]
    split = split_of(np.array(weights))
    return found + [within(f"{where}.split.{j}", "1", float(part), 0.0, 1.0, fine) for j, part in enumerate(split)]


def shares_of(split: Array) -> Array:
    """Weights that add up to 1, (..., n + 1), from what each element takes of what those before it leave, (..., n)."""
    left = np.cumprod(1.0 - split, axis=-1)
    one = np.ones((*split.shape[:-1], 1))
    return np.asarray(np.concatenate([split, one], axis=-1) * np.concatenate([one, left], axis=-1))


def split_of(weights: Array) -> Array:
    """What each element but the last takes of what those before it leave: the inverse of `shares_of`."""
    left = 1.0 - np.concatenate([[0.0], np.cumsum(weights)[:-1]])
    return np.asarray([w / rest if rest > 0.0 else 0.5 for w, rest in zip(weights[:-1], left[:-1], strict=True)])


def rounded(weights: Array) -> tuple[float, ...]:
    """Weights with six decimals that still add up to 1, as they can stand in a file."""
    found = np.round(weights, DECIMALS)
    largest = int(np.argmax(found))
    found[largest] = round(1.0 - float(np.delete(found, largest).sum()), DECIMALS)
    return tuple(float(one) for one in found)
