"""Control laws from outside: what they return is checked before they run and in every cycle, compiled or not."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import nan
from typing import Any

from layflat.control.contract import Command, Demand, Sensed
from layflat.description.expression import unit_of
from layflat.description.factors import is_own
from layflat.errors import KindError
from layflat.jit import composition, law
from layflat.kind_checks import (
    MisfitError,
    check_alike,
    check_items,
    check_nested,
    check_numbers,
    check_record,
    described,
    naming_law,
    tolerating_arithmetic,
)
from layflat.lanes import each, in_lanes, select, zero_if_finite
from layflat.physics.adjustable import Shares


@law
def _in_range(share):
    return select((share >= 0.0) & (share <= 1.0), share, nan)


@law
def _with_flaws(voltage, shares, flaw):
    brake, dither, supply = _in_range(shares.brake), _in_range(shares.dither), _in_range(shares.supply)
    return voltage + zero_if_finite((voltage, brake, dither, supply)) + flaw


def guard_step(step: Callable[..., Any]) -> Callable[..., Any]:
    """Return a compiled `step` whose voltages are not numbers in a cycle in which it returns what it may not.

    That is a number in memory, command or report that is not finite, or a share outside 0 to 1.
    """

    @composition
    def guarded_step(settings, memory, sensed, demand, elapsed):
        zero = 0.0 * sensed.angle[0]
        after, command, report = step(settings, memory, sensed, demand, elapsed)
        flaw = zero_if_finite((in_lanes(after, zero), in_lanes(report, zero)))
        voltages = each(_with_flaws, in_lanes(command.voltage, zero), in_lanes(command.shares, zero), flaw)
        return after, Command(voltages, command.shares), report

    return guarded_step


TRIED = (0.0, 0.2, -0.2, 0.0)  # demands of all joints, rad, with which a law that rests is tried


def check_memory(memory: Any) -> None:
    """Raise MisfitError if something is no memory of a law."""
    check_nested(memory, "the memory")


def check_step(result: Any, memory: Any, joints: int, report: type) -> None:
    """Raise MisfitError if something is not what a law returns after a cycle.

    Args:
        result: what it returned.
        memory: its memory before the cycle.
        joints: how many joints the arm has.
        report: class of what it shows of a joint.
    """
    if type(result) is not tuple or len(result) != 3:
        raise MisfitError(f"it is {described(result)}, not memory, command and report")
    after, command, reports = result
    check_alike(after, memory, "the memory")
    if not isinstance(command, Command):
        raise MisfitError(f"the command is {described(command)}, not a Command of voltages and shares")
    check_numbers(command.voltage, joints, "`voltage`")
    check_items(command.shares, joints, "`shares`")
    for one in command.shares:
        check_record(one, Shares, "an item of `shares`")
        for name, share in one._asdict().items():
            if not 0.0 <= share <= 1.0:
                raise MisfitError(f"{name} of an item of `shares` is {share:g}, not a share from 0 to 1")
    check_items(reports, joints, "the report")
    for one in reports:
        check_record(one, report, "an item of the report")


def try_law(kind: Any, settings: Any, joints: int, cycle: float) -> None:
    """Call the functions of a control law at rest, with demands that jump, and check what they return.

    Args:
        kind: the `ControlKind`.
        settings: for a machine.
        joints: of that machine.
        cycle: of its controller, s.

    Raises:
        KindError: one fails, or returns what it may not.
    """
    nothing, thing = (0.0,) * joints, f"control law {kind.name!r}"
    sensed = Sensed(nothing, nothing)
    with tolerating_arithmetic(kind.step):
        with naming_law(thing, "wake", kind.wake):
            memory = kind.wake(settings, sensed)
            check_memory(memory)
        for angle in TRIED:
            with naming_law(thing, "step", kind.step):
                result = kind.step(
                    settings, memory, sensed, Demand((angle,) * joints, nothing, nothing, nothing), cycle
                )
                check_step(result, memory, joints, kind.report)
            memory = result[0]
        with naming_law(thing, "centre_shift", kind.centre_shift):
            check_numbers(kind.centre_shift(settings, memory, nothing), joints, "the shift")


def check_report(report: Any, signals: Any) -> None:
    """Raise MisfitError if what a kind says of its report does not fit together."""
    if not hasattr(report, "_fields"):
        raise MisfitError("`report` is no named tuple class")
    if not isinstance(signals, dict):
        raise MisfitError(f"`signals` is {described(signals)}, not unit and meaning by name")
    for name, said in signals.items():
        if type(said) is not tuple or len(said) != 2 or not all(isinstance(one, str) for one in said):
            raise MisfitError(f"signal {name!r} has {described(said)}, not unit and meaning")
        if name not in report._fields:
            raise MisfitError(f"signal {name!r} is no field of `report`")
        try:
            known = said[0] == "1" or (unit_of(said[0]) != () and is_own(dict(unit_of(said[0]))))
        except ValueError:
            known = False
        if not known:
            raise MisfitError(f"signal {name!r} has the unit {said[0]!r}, which is none; give one such as rad, V or 1")


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
