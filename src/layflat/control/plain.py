"""Control laws in plain Python: what they return is checked in every cycle, since nothing compiles it."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

from layflat.control.checks import check_memory, check_step
from layflat.control.contract import Demand, Sensed
from layflat.errors import KindError
from layflat.kind_checks import naming_law


@dataclass
class CycleClock:
    """Time since a law woke, s, for messages."""

    time: float = 0.0


@dataclass(frozen=True)
class PlainWake:
    """`wake` of a law in plain Python, checked."""

    kind: str  # its name
    function: Callable[..., Any]
    clock: CycleClock = field(compare=False)

    def __call__(self, settings: Any, sensed: Any) -> Any:
        """Call it and return the memory; raise KindError if it fails or returns none."""
        with naming_law(f"control law {self.kind!r}", "wake", self.function):
            memory = self.function(settings, sensed)
            check_memory(memory)
        self.clock.time = 0.0
        return memory


@dataclass(frozen=True)
class PlainStep:
    """`step` of a law in plain Python, checked."""

    kind: str  # its name
    function: Callable[..., Any]
    report: type
    clock: CycleClock = field(compare=False)

    def __call__(self, settings: Any, memory: Any, sensed: Any, demand: Any, elapsed: float) -> Any:
        """Call it and return memory, command and report; raise KindError if it fails or returns something else."""
        with naming_law(f"control law {self.kind!r}", "step", self.function, f" at {self.clock.time:.4g} s"):
            result = self.function(settings, memory, sensed, demand, elapsed)
            check_step(result, memory, len(sensed.angle), self.report)
        self.clock.time += elapsed
        return result


def find_flaw(kind: Any, settings: Any, cycles: Iterable[tuple[Sensed, Demand]], cycle: float) -> str:
    """Return what is wrong with what a law returned in a run, found by repeating its cycles in plain Python.

    Args:
        kind: the `ControlKind`.
        settings: of its law.
        cycles: what it was given in each cycle, from the first on.
        cycle: length of one, s.

    Returns:
        Kind, file, line, time and value; empty where nothing is wrong in these cycles.
    """
    clock = CycleClock()
    wake, step = PlainWake(kind.name, kind.wake, clock), PlainStep(kind.name, kind.step, kind.report, clock)
    memory = None
    try:
        for sensed, demand in cycles:
            memory = wake(settings, sensed) if memory is None else memory
            memory, _, _ = step(settings, memory, sensed, demand, cycle)
    except KindError as error:
        return str(error)
    except (ArithmeticError, ValueError):  # of plain Python alone: compiled, 1/0 is infinite and may be left out
        return ""
    return ""
