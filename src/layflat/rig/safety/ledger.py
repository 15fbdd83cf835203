"""Which faults there are: found in this cycle, and latched; and what has to be told of them."""

from __future__ import annotations

from collections.abc import Sequence

from layflat.rig.safety.faults import LATCHED, REACTIONS, TABLE, Fault, Reaction


class Ledger:
    """Faults of a rig.

    Args:
        names: of the joints.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = names
        self.latched = Fault.NONE
        """The worst that stays until a reset."""
        self.now = Fault.NONE
        """The worst found in this cycle."""
        self.joints = [Fault.NONE] * len(names)
        """The worst of each joint that stays until a reset."""
        self.joints_now = [Fault.NONE] * len(names)
        """The worst of each joint found in this cycle."""
        self.reaction = Reaction.TELL
        """The worst that the latched faults ask for."""
        self.events: list[str] = []
        """What has to be told; who tells it clears it."""
        self._before: set[tuple[int, int]] = set()
        self._noted: set[tuple[int, int]] = set()

    @property
    def worst(self) -> Fault:
        """Latched or found in this cycle."""
        return self.latched if self.latched >= self.now else self.now

    def new_cycle(self) -> None:
        """Forget what was found in the cycle before, so that it is told again only if it comes again."""
        if self._noted or self._before:
            self._before, self._noted = self._noted, set()
            self.now = Fault.NONE
            for j in range(len(self.joints_now)):
                self.joints_now[j] = Fault.NONE

    def note(self, fault: Fault, joint: int = -1) -> None:
        """A fault was found in this cycle."""
        key = (int(fault), joint)
        if key in self._noted:
            return
        self._noted.add(key)
        self.now = max(self.now, fault)
        if key not in self._before:
            where = f"joint {self._names[joint]!r}: " if joint >= 0 else ""
            self.say(f"{where}{TABLE[fault].title}")
        if LATCHED[fault]:
            self.latched = max(self.latched, fault)
            self.reaction = max(self.reaction, REACTIONS[fault])

    def note_joint(self, joint: int, fault: Fault) -> None:
        """A fault of a joint was found in this cycle."""
        self.note(fault, joint)
        self.joints_now[joint] = max(self.joints_now[joint], fault)
        if LATCHED[fault]:
            self.joints[joint] = max(self.joints[joint], fault)

    def worst_of(self, joint: int) -> Fault:
        """Latched or found in this cycle."""
        return max(self.joints[joint], self.joints_now[joint])

    def worsen(self, reaction: Reaction) -> None:
        """Ask for more than the latched faults do."""
        self.reaction = max(self.reaction, reaction)

    def say(self, text: str) -> None:
        """Something to be told."""
        self.events.append(text)

    def clear(self) -> None:
        """A reset: nothing is latched any more."""
        self.latched, self.reaction = Fault.NONE, Reaction.TELL
        self.joints = [Fault.NONE] * len(self._names)
