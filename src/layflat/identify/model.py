"""Model to be fitted: measured signals, unknowns, and a simulation of the signals from the unknowns."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.identify.unknown import Shares, Unknown

Flags = NDArray[np.bool_]

FITTED = 2.0 / 3.0  # share of a log that is fitted where no other log is there for validation


@dataclass(frozen=True)
class Output:
    """A measured signal that is compared with the simulated one."""

    name: str  # such as "angle large"
    unit: str  # SI
    log: str  # the log that it was read from
    time: Array  # s, (samples,)
    measured: Array  # (samples,), not a number where nothing was measured
    fitted: Flags  # (samples,), whether a sample is fitted; otherwise it is for validation
    scale: float  # what an error is divided by: the noise, or how large an error matters
    driven_by: Array | None = None  # input that moves it most, (samples,): errors of a good model don't follow it


class Model(ABC):
    """A bench that can be simulated for any values of what is unknown."""

    unknowns: tuple[Unknown, ...]  # as the outputs fixed once it is made
    outputs: tuple[Output, ...]
    remarks: tuple[str, ...] = ()  # what the logs say of the model's structure, in sentences for the report
    cross_validated: bool = False  # whether its unknowns are chosen, and its error estimated, by leaving logs out

    @abstractmethod
    def simulate(self, values: Array) -> Array:
        """Run freely from what the logs begin with: only inputs of the logs are given.

        Args:
            values: of the unknowns in SI, a candidate a row: (candidates, unknowns).

        Returns:
            All outputs, one after the other, (candidates, samples); not numbers where a candidate diverged.
        """

    def settled(self, shares: Array, triangle: Array) -> Array:  # noqa: ARG002  # what others settle by
        """Shares that the description can have, near the best ones; default: these.

        Args:
            shares: found by the search, see `shares`.
            triangle: times what is added to them is what it adds to the residuals, the priors' among them.
        """
        return shares

    def starts(self) -> Array:
        """Return more starts of the search, (starts, unknowns) in SI; the guess comes first in any case."""
        return np.empty((0, len(self.unknowns)))

    def mirrored(self, values: Array) -> Array:  # noqa: ARG002  # what others look at
        """Return values far from those found that may predict as well, for the search to compare; default: none.

        Args:
            values: of the unknowns in SI, (unknowns,).

        Returns:
            The same with some of them changed, (mirrors, unknowns); always as many, in the same order.
        """
        return np.empty((0, len(self.unknowns)))

    def continuations(self) -> Sequence[Sequence["Model"]]:
        """Models of the same unknowns and outputs through which the search goes, from the easiest on.

        Several such continuations, of the same last model, are tried one after the other until one explains the logs.
        The last model gives values and intervals; what the values predict is simulated by this model itself.
        """
        return ((self,),)

    def led(self) -> "Model | None":
        """Return the model that predicts in place of one that runs away from its logs even with right values.

        Default: None, as most do not.
        """
        return None

    def simpler(self) -> "Mapping[str, Model]":
        """Return models of the same logs with fewer unknowns, by name, the simplest first; default: none."""
        return {}

    def held(self, paths: Collection[str]) -> Self:
        """Return a copy in which some unknowns keep the values of the description."""
        other = copy(self)
        other.unknowns = tuple(one for one in self.unknowns if one.path not in paths)
        for name in ("guess", "shares"):
            other.__dict__.pop(name, None)
        return other

    def written(self, values: Array) -> dict[str, float]:
        """Return the description's values by path from those of the unknowns (SI); items of lists by their number."""
        columns = self.columns(values)
        return {one.path: float(columns[one.path]) for one in self.unknowns if not one.nuisance}

    def columns(self, values: Array) -> dict[str, Array]:
        """Return what stands in the last axis of `values`, a row or (candidates, unknowns), by the unknowns' paths."""
        return dict(zip((unknown.path for unknown in self.unknowns), values.T, strict=True))

    @cached_property
    def shares(self) -> Shares:
        """In what the search goes; default: in shares of the unknowns themselves.

        A model that knows values in which its outputs are straighter returns shares of those.
        """
        return Shares(self.unknowns)

    @cached_property
    def guess(self) -> Array:
        """Guessed values, (unknowns,)."""
        return np.array([unknown.guess for unknown in self.unknowns])

    @cached_property
    def measured(self) -> Array:
        """All that was measured, one output after the other."""
        return np.concatenate([output.measured for output in self.outputs])

    @cached_property
    def used(self) -> Flags:
        """Mask of the samples that are fitted."""
        return np.concatenate([output.fitted & np.isfinite(output.measured) for output in self.outputs])

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Slice of each output among all samples."""
        ends = np.cumsum([len(output.measured) for output in self.outputs]).tolist()
        return tuple(slice(end - len(output.measured), end) for end, output in zip(ends, self.outputs, strict=True))
