"""Shortfalls of machines against the paper's findings; machines that exceed a level are not evaluated further."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from layflat.arrays import Array
from research.calibration import shortfall
from research.calibration.effort import EvaluationEffort
from research.calibration.evidence import Evidence

Values = Callable[[Array], Mapping[str, Array]]
"""From shares (machines, unknowns) to numbers (SI) by path."""


@dataclass(frozen=True)
class Findings:
    """The paper's findings, by which machines are evaluated."""

    evidence: Evidence
    left_out: frozenset[str] = frozenset()  # by the names of their shortfalls

    def lack(
        self, shares: Array, values: Values, *, arm: bool, seed: int, effort: EvaluationEffort, level: Array | float
    ) -> Array:
        """Return the total shortfall of machines (machines, unknowns), (machines,); partial where above their level.

        Of several evaluations the worst counts.
        """
        found, still, left = np.zeros(len(shares)), np.zeros(len(shares)), np.arange(len(shares))
        levels = np.broadcast_to(level, len(shares))
        for number, (own, closely) in enumerate(effort.each(seed)):
            lacked = still.copy()
            for noisy, look in self._looks(arm, own, closely):
                if not len(left) or (number and not noisy):
                    continue
                parts = look(values(shares[left]))
                kept = (effort.counted(one) for name, one in parts.items() if name not in self.left_out)
                part = sum(kept, np.zeros(len(left)))
                lacked[left] += part
                still[left] += 0.0 if noisy else part
                found[left] = np.maximum(found[left], lacked[left])
                left = left[found[left] <= levels[left]]
        return found

    def parts(
        self, shares: Array, values: Values, *, arm: bool, seed: int, effort: EvaluationEffort
    ) -> dict[str, Array]:
        """Return the shortfalls of machines, (machines,), by name."""
        found: dict[str, Array] = {}
        for _, look in self._looks(arm, seed, effort):
            found |= look(values(shares))
        return found

    def _looks(
        self, arm: bool, seed: int, effort: EvaluationEffort
    ) -> Iterator[tuple[bool, Callable[[Mapping[str, Array]], dict[str, Array]]]]:
        """Yield evaluations, the cheapest first, and whether they depend on the seed of the noise."""
        evidence, on = self.evidence, self.evidence.bench
        braked = on.arm if arm else on.axis_one
        yield False, lambda by_path: shortfall.held_short(by_path, evidence.frictions(braked))
        yield False, lambda by_path: shortfall.dither(evidence.ripple(braked, by_path))
        if arm:
            yield True, lambda by_path: shortfall.two_axes(evidence.arm_moves(by_path, seed, effort), on.arm.cycle)
            yield True, lambda by_path: shortfall.comes_back(evidence.comes_back(by_path, seed, effort))
            return
        yield False, lambda by_path: shortfall.small_motions(evidence.small_motion(by_path))
        yield False, lambda by_path: shortfall.open_loop(evidence.hysteresis(by_path))
        yield True, lambda by_path: shortfall.compared(evidence.steps.compared(by_path, seed, effort))
        yield True, lambda by_path: shortfall.loaded(evidence.steps.loaded(by_path, seed, effort))
        yield False, lambda by_path: shortfall.spool(evidence.spool(by_path))
        if effort.learns:
            yield False, lambda by_path: shortfall.drift(evidence.taken_over(by_path, effort))
