"""Which faults there are: found in this cycle, and latched; and what has to be told of them."""

from collections.abc import Sequence

from layflat.rig.safety.faults import Fault, Reaction


class Ledger:
    """Faults of a rig with joints of these names."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = names
        self.clear()
        self.now = Fault.NONE  # the worst found in this cycle
        self.joints_now = [Fault.NONE] * len(names)  # the worst of each joint found in this cycle
        self.events: list[str] = []  # what has to be told; who tells it clears it
        self._before: set[tuple[Fault, int | None]] = set()
        self._noted: set[tuple[Fault, int | None]] = set()

    def clear(self) -> None:
        """A reset: nothing is latched any more."""
        self.latched = Fault.NONE  # the worst that stays until a reset
        self.joints = [Fault.NONE] * len(self._names)  # the worst of each joint that stays until a reset
        self.reaction = Reaction.TELL  # the worst that the latched faults ask for

    @property
    def worst(self) -> Fault:
        """Latched or found in this cycle."""
        return self.latched if self.latched >= self.now else self.now

    def worst_of(self, joint: int) -> Fault:
        """The same of a joint."""
        return max(self.joints[joint], self.joints_now[joint])

    def new_cycle(self) -> None:
        """Forget what was found in the cycle before, so that it is told again only if it comes again."""
        if self._noted or self._before:
            self._before, self._noted = self._noted, set()
            self.now = Fault.NONE
            for j in range(len(self.joints_now)):
                self.joints_now[j] = Fault.NONE

    def note(self, fault: Fault, joint: int | None = None) -> None:
        """A fault was found in this cycle, of a joint or of the machine as a whole."""
        if (fault, joint) in self._noted:
            return
        self._noted.add((fault, joint))
        if (fault, joint) not in self._before:
            where = "" if joint is None else f"joint {self._names[joint]!r}: "
            self.events.append(f"{where}{fault.title}")
        self.now = max(self.now, fault)
        if joint is not None:
            self.joints_now[joint] = max(self.joints_now[joint], fault)
        if fault.latched:
            self.latched = max(self.latched, fault)
            self.reaction = max(self.reaction, fault.reaction)
            if joint is not None:
                self.joints[joint] = max(self.joints[joint], fault)
