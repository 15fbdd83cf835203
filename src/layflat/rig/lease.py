"""Who minds a rig renews a lease; a rig that nobody minds is held, then stops.

The host's own process may well live while nobody is there: a page was closed, a cable pulled, a browser is frozen. So
setpoints are not kept fresh on anybody's behalf. Once a lease is over they go stale, and the loop itself stops.
"""

import time
from math import inf

HELD_AFTER = 0.19  # without a renewal the joints are held, s
STALE_AFTER = 0.7  # without one, setpoints are no longer kept fresh while there is air: the loop stops, 0.1 s later, s


class Lease:
    """A lease that has to be renewed again and again, by whoever minds a rig; it begins as one that has lapsed."""

    def __init__(self) -> None:
        self._renewed = -inf

    def renew(self) -> None:
        """Somebody is there."""
        self._renewed = time.monotonic()

    @property
    def age(self) -> float:
        """Time since it was renewed, s."""
        return time.monotonic() - self._renewed

    @property
    def lives(self) -> bool:
        """Whether somebody is there: then the rig obeys."""
        return self.age <= HELD_AFTER

    @property
    def over(self) -> bool:
        """Whether nobody has been there for so long that the rig stops."""
        return self.age > STALE_AFTER
