"""Effort of an evaluation of machines: numbers of runs, step of integration, and noise."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from layflat.arrays import Array
from layflat.physics.step import COARSE_STEP, STEP

LOOK_SEED_STRIDE = 1000  # between the evaluations of a machine with other noise


@dataclass(frozen=True)
class EvaluationEffort:
    """Effort of an evaluation of machines."""

    counts: tuple[int, int]  # inertias of the braked joint and of the earlier actuator
    repeats: int  # runs with each of them, with other noise
    approaches: int  # of the arm to one place
    step: float  # of the plant, s
    looks: int = 1  # evaluations with other noise each, of which the worst counts
    claimed: bool = False  # True if the claims' own runs count as well
    elsewhere: bool = False  # True if each seed shifts the inertias between their neighbours
    learns: bool = True  # True if a minute of the long-term integral is simulated
    most: float = np.inf  # upper limit of one finding's cost

    def counted(self, lacked: Array) -> Array:
        """Return the cost of shortfalls, saturated at `most`."""
        return lacked / (1.0 + lacked / self.most)

    def each(self, seed: int) -> "Iterator[tuple[int, EvaluationEffort]]":
        """Yield each evaluation's seed and effort."""
        yield from ((seed + LOOK_SEED_STRIDE * number, self) for number in range(self.looks))
        if self.claimed:
            yield OWN_NOISE, EXACT_CLAIM_EFFORT


ROUGH_EFFORT = EvaluationEffort((8, 6), 1, 4, COARSE_STEP, elsewhere=True, learns=False, most=3.0)
"""First effort: costs saturate, so that the number of findings that are met counts more than the largest shortfall."""
OWN_NOISE = 1  # seed of the claims' own noise
CLAIM_EFFORT, ROUGH_CLAIM_EFFORT = (
    EvaluationEffort((25, 16), 5, 20, COARSE_STEP),
    EvaluationEffort((9, 6), 3, 8, COARSE_STEP, learns=False),
)
"""The claims' own runs with a coarse step, and a part of them."""
SINGLE_EFFORT = EvaluationEffort((13, 8), 3, 20, COARSE_STEP)
EXACT_CLAIM_EFFORT = replace(CLAIM_EFFORT, step=STEP)
"""The claims' own runs with their own step."""
FINAL_EFFORT = replace(SINGLE_EFFORT, looks=2, claimed=True)
"""Two evaluations with other noise, then the claims' own: chance would have to repeat itself three times."""
