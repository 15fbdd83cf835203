"""The suction cup: how its vacuum builds up and leaks, and what it can hold."""

from __future__ import annotations

from math import exp, pi

from layflat.cell.file.parts import Cup


class SuctionCup:
    """The vacuum in a cup and the force that it holds with.

    The ejector draws the vacuum p (below ambient) towards its level while it is on; air that leaks in, more through an
    open cup than through skin, draws it to zero; a valve that is off lets air in besides:
    p' = on (level - p) / build_up - p / leak - off p / release. Each step is solved exactly.

    Args:
        described: the cup of a cell.

    Attributes:
        on: whether the ejector is on; settable.
        vacuum: below ambient, Pa.
        air: what the ejector has taken so far, m^3 of normal volume.
    """

    def __init__(self, described: Cup) -> None:
        self._cup = described
        self._area = pi / 4.0 * described.effective_diameter**2
        self.on = False
        self.vacuum = 0.0
        self.air = 0.0

    @property
    def force(self) -> float:
        """Force with which the vacuum draws what is under the cup to it, N."""
        return self.vacuum * self._area

    def advance(self, sealed: bool, step: float) -> None:
        """Advance by a step (s), on a skin or open."""
        rate = 1.0 / (self._cup.leak if sealed else self._cup.open_leak)
        if self.on:
            rate += 1.0 / self._cup.build_up
            self.air += self._cup.air * step
        else:
            rate += 1.0 / self._cup.release
        end = self._cup.vacuum / (self._cup.build_up * rate) if self.on else 0.0
        self.vacuum = end + (self.vacuum - end) * exp(-rate * step)

    def holds(self, pull: float, shear: float) -> bool:
        """Return whether it holds against a force away from it and one sideways, N.

        The lip presses with what the pull leaves of the vacuum's force, and friction follows from that; moments are
        left out, as bellows give way to them.
        """
        return self.force >= pull and shear <= self._cup.friction * (self.force - pull)
