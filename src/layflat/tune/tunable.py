"""What of a control law is tuned, and by what it is judged."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from layflat.errors import InputError
from layflat.machine import Machine
from layflat.tune.conditions import Conditions, Spread
from layflat.tune.knobs import GENERATIONS, Knob, Part

Methods = Mapping[str, Callable[[Machine, int | None], list[Part]]]
"""Parts of a search by the method's name, from a machine and, where given, the generations in all."""


@dataclass(frozen=True)
class Tunable:
    """What of a control law is tuned."""

    values: str  # name of what is tuned, for people
    begun: Callable[[Machine], Machine]
    """Yields the machine with a value at every knob, neutral where it has none."""
    knobs: Callable[[Machine], list[Knob]]
    methods: Methods
    conditions: Callable[[Machine, int, Spread | None, int], Conditions]
    """`conditions(machine, runs, spread, seed)` yields what candidates are judged by; runs: a power of two."""
    spread: Callable[[Conditions, Machine], str]
    """Yields, in words, how conditions differ from run to run."""
    clouds: bool = False  # whether one controller may be tuned for all machines of a cloud
    complete: Callable[[Machine], Mapping[str, tuple[str, str]]] = lambda machine: {}  # noqa: ARG005
    """Yields text and reason, by path, of what a machine needs besides."""

    def parts(self, machine: Machine, method: str, generations: int | None = None) -> list[Part]:
        """Return what is looked for, in order (InputError: no such method, or generations that make no sense)."""
        if method not in self.methods:
            right = f"give {' or '.join(self.methods)}"
            raise InputError(f"unknown method {method!r} for {self.values}", where="--method", right=right)
        if generations is not None and not 1 <= generations < GENERATIONS:
            right = f"give 1 to {GENERATIONS - 1}"
            raise InputError(f"{generations} is out of range", where="--generations", right=right)
        return self.methods[method](machine, generations)
