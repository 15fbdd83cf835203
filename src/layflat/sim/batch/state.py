"""State of a batch that was saved, to return to it or to branch from it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from layflat._version import __version__
from layflat.arrays import Array
from layflat.errors import InputError
from layflat.sim.batch.arrays import BatchArrays


@dataclass(frozen=True)
class BatchState:
    """Whole state of the arms of a batch: machines, motion, air, memory of the control law, inputs and noise.

    It can be pickled, and set in any batch of the same kind of machine, control law, action and precision.
    """

    arrays: BatchArrays
    vary: Mapping[str, Array]  # values, (arms,), by the key that they change
    structure: str  # of the machine's and the law's numbers, of action and precision
    version: str = __version__

    @property
    def count(self) -> int:
        """Number of arms."""
        return len(self.arrays.cycles)

    def take(self, arms: ArrayLike) -> "BatchState":
        """Return the state of some arms, in the order of their numbers; a number may occur many times.

        Args:
            arms: numbers of arms, (any,), such as `[0] * 64` for 64 branches of the first arm.

        Raises:
            InputError: there is no such arm.
        """
        numbers = check_arms(arms, self.count, "arms")
        return replace(
            self,
            arrays=BatchArrays(*(array[..., numbers] for array in self.arrays)),
            vary={key: values[numbers] for key, values in self.vary.items()},
        )

    def check_fits(self, structure: str, count: int) -> None:
        """Check that it fits arms of a structure.

        Args:
            structure: that of the batch.
            count: number of the arms.

        Raises:
            InputError: it is the state of another version, of other arms, or of another number of them.
        """
        if self.version != __version__:
            what = f"was saved by layflat {self.version}"
            raise InputError(what, where="state", right=f"save it with this version, {__version__}")
        if self.structure != structure:
            right = "set it in a batch of that machine, control law, action, precision and step"
            raise InputError("is the state of arms of another kind", where="state", right=right)
        if self.count != count:
            right = f"take {count} of its arms: state.take([...])"
            raise InputError(f"holds {self.count} arms, for {count}", where="state", right=right)


def check_arms(arms: ArrayLike | None, count: int, where: str) -> np.ndarray:
    """Return the numbers of arms that a mask (count,), numbers, or None for all of them select.

    Args:
        arms: mask or numbers.
        count: number of arms that there are.
        where: the argument, for messages.

    Raises:
        InputError: there is no such arm, or it is neither mask nor whole numbers.
    """
    if arms is None:
        return np.arange(count)
    chosen = np.asarray(arms)
    right = f"give a mask of {count} arms, or numbers from 0 to {count - 1}"
    if chosen.dtype == bool:
        if chosen.shape != (count,):
            raise InputError(f"has shape {chosen.shape}", where=where, right=right)
        return np.flatnonzero(chosen)
    if chosen.ndim != 1 or (chosen.dtype.kind not in "iu" and chosen.size):
        raise InputError("holds no numbers of arms", where=where, right=right)
    outside = chosen[(chosen < 0) | (chosen >= count)]
    if outside.size:
        raise InputError(f"{outside[0]} is no arm", where=where, right=right)
    return chosen.astype(np.intp)
