"""How closely machines are looked at, and with which noise."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from layflat.arrays import Array
from layflat.physics.step import COARSE, STEP

APART = 1000  # seeds of the looks at a machine


@dataclass(frozen=True)
class Effort:
    """How closely machines are looked at."""

    counts: tuple[int, int]  # inertias of the braked joint and of the earlier actuator
    repeats: int  # runs with each of them, with other noise
    approaches: int  # of the arm to one place
    step: float  # of the plant, s
    looks: int = 1  # with other noise each, of which the worst counts: luck does not last
    claimed: bool = False  # whether the claims' own runs count as well
    elsewhere: bool = False  # whether inertias lie elsewhere between their neighbours with each seed
    learns: bool = True  # whether the long-term integral is looked at, for a minute of its time
    most: float = np.inf  # what a finding counts that is missed altogether

    def counted(self, lacked: Array) -> Array:
        """What findings count of which so much is lacked."""
        return lacked / (1.0 + lacked / self.most)

    def each(self, seed: int) -> "Iterator[tuple[int, Effort]]":
        """Yield looks one after the other, each with the seed of its noise."""
        yield from ((seed + APART * number, self) for number in range(self.looks))
        if self.claimed:
            yield OWN_NOISE, EXACTLY


ROUGH = Effort((8, 6), 1, 4, COARSE, elsewhere=True, learns=False, most=3.0)
"""Far from all, it counts how many findings come out: who minds the farthest alone is led to where the others can't."""
OWN_NOISE = 1  # the seed of the claims
CLAIMED, ROUGHLY_CLAIMED = Effort((25, 16), 5, 20, COARSE), Effort((9, 6), 3, 8, COARSE, learns=False)
"""With the claims' own noise their own runs, but for the step, and some of them."""
ONCE = Effort((13, 8), 3, 20, COARSE)
EXACTLY = replace(CLAIMED, step=STEP)
"""The claims' own runs."""
SURE = replace(ONCE, looks=2, claimed=True)
"""With other noise each time, then as the claims do: who passes by luck has to have it three times."""
