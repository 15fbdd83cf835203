"""Snapshots of a rig over the last half minute, for charts."""

from collections import deque
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.physics.air import NORMAL_DENSITY
from layflat.rig.session import Snapshot

SPAN = 30.0  # that is kept, s
EVERY = 0.1  # between two instants that are kept, s
PER_JOINT = ("averaged_angle", "demand", "averaged_pressure", "voltage", "estimated_air")
SHARED = ("supply", "lateness", "link")
WHOLE = "brake_share"  # is 1 where the control law leaves the brakes alone


class Seen(NamedTuple):
    """Columns of what was kept."""

    times: Array  # before now, s, (instants,), the last one 0
    joints: dict[str, Array]  # (instants, joints) each, by the names of `rig.record`
    shared: dict[str, Array]  # (instants,) each


class History:
    """Rows of the last `SPAN` seconds, thinned out, and the worst that was seen of the loop's timing."""

    def __init__(self) -> None:
        self._rows: deque[tuple[float, Array]] = deque()
        self._last: Snapshot | None = None
        self._seen: tuple[object, Seen] | None = None  # with the last row of it
        self.worst_lateness = 0.0  # s, since the rig was reached

    def add(self, shot: Snapshot, machine: Machine) -> None:
        """Keep what was seen, if it is time."""
        now = float(shot["time"])
        if self._rows and now < self._rows[-1][0]:
            self.pause()  # another session
        self.worst_lateness = max(self.worst_lateness, float(shot["lateness"])) if now > 1.0 else 0.0
        if self._rows and now - self._rows[-1][0] < EVERY - 0.5 * machine.cycle:
            return
        self._last = shot
        parts = [*(shot[name] for name in PER_JOINT), shot.told(WHOLE, 1.0)]
        self._rows.append((now, np.concatenate([*parts, [shot[name] for name in SHARED]])))
        while now - self._rows[0][0] > SPAN:
            self._rows.popleft()

    def pause(self) -> None:
        """The rig is gone."""
        self._rows.clear()
        self._last = None
        self.worst_lateness = 0.0

    def seen(self) -> Seen | None:
        """Return what is kept, the same object as long as nothing new is; None where nothing is."""
        rows, known = list(self._rows), self._seen
        if not rows:
            return None
        if known is not None and known[0] is rows[-1]:
            return known[1]
        times = np.array([time for time, _ in rows])
        table = np.array([row for _, row in rows])
        names = (*PER_JOINT, WHOLE)
        n = (table.shape[1] - len(SHARED)) // len(names)
        joints = {name: table[:, i * n : (i + 1) * n] for i, name in enumerate(names)}
        seen = Seen(times - times[-1], joints, {name: table[:, i - len(SHARED)] for i, name in enumerate(SHARED)})
        self._seen = rows[-1], seen
        return seen


def air_taken(seen: Seen) -> Array:
    """Return the air that each joint has taken since the first of what is kept, normal litres, (instants, joints)."""
    taken = seen.joints["estimated_air"]
    litres: Array = (taken - taken[0]) / NORMAL_DENSITY * 1000.0
    return litres


def air_rate(seen: Seen) -> float:
    """Return the air taken over what is kept, normal litres a minute."""
    lasted = -float(seen.times[0])
    return float(air_taken(seen)[-1].sum()) * 60.0 / lasted if lasted > 0.0 else 0.0
