"""Checks of the values that users' control laws return, before a run and in every cycle, compiled or not."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import nan
from typing import Any

from layflat.control.signals import Command, Demand, Sensed
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
from layflat.physics.adjustable import DriveFractions


@law
def _share_or_nan(share):
    return select((share >= 0.0) & (share <= 1.0), share, nan)


@law
def _add_flaws(voltage, shares, flaw):
    """Return the voltage, V; NaN if it or `flaw` is not finite, or a share is outside 0 to 1."""
    brake, dither, supply = _share_or_nan(shares.brake), _share_or_nan(shares.dither), _share_or_nan(shares.supply)
    return voltage + zero_if_finite((voltage, brake, dither, supply)) + flaw


def guard_step(step: Callable[..., Any]) -> Callable[..., Any]:
    """Return a compiled `step` whose voltages are NaN in a cycle in which it returns an invalid value.

    Invalid are a number in memory, command or report that is not finite, and a share outside 0 to 1.
    """

    @composition
    def guarded_step(settings, memory, sensed, demand, elapsed):
        zero = 0.0 * sensed.angle[0]
        after, command, report = step(settings, memory, sensed, demand, elapsed)
        flaw = zero_if_finite((in_lanes(after, zero), in_lanes(report, zero)))
        voltages = each(_add_flaws, in_lanes(command.voltage, zero), in_lanes(command.shares, zero), flaw)
        return after, Command(voltages, command.shares), report

    return guarded_step


TRIAL_DEMANDS = (0.0, 0.2, -0.2, 0.0)  # demands of all joints in the test of a law at rest, rad


def check_memory(memory: Any) -> None:
    """Raise MisfitError if a value is no valid memory of a law."""
    check_nested(memory, "the memory")


def check_step(result: Any, memory: Any, joints: int, report: type) -> None:
    """Check the result of a control cycle.

    Args:
        result: value that the law's `step` returned.
        memory: the law's memory before the cycle.
        joints: number of the arm's joints.
        report: class of a joint's report.

    Raises:
        MisfitError: the result is no memory, command and report, or holds an invalid value.
    """
    if type(result) is not tuple or len(result) != 3:
        raise MisfitError(f"it is {described(result)}, not memory, command and report")
    after, command, reports = result
    check_alike(after, memory, "the memory")
    if not isinstance(command, Command):
        raise MisfitError(f"the command is {described(command)}, not a Command of voltages and shares")
    check_numbers(command.voltage, joints, "`voltage`")
    check_items(command.shares, joints, "`shares`")
    for shares in command.shares:
        check_record(shares, DriveFractions, "an item of `shares`")
        for name, share in shares._asdict().items():
            if not 0.0 <= share <= 1.0:
                raise MisfitError(f"{name} of an item of `shares` is {share:g}, not a share from 0 to 1")
    check_items(reports, joints, "the report")
    for item in reports:
        check_record(item, report, "an item of the report")


def try_law(kind: Any, settings: Any, joints: int, cycle: float) -> None:
    """Call the functions of a control law at rest, with demands that jump, and check the values that they return.

    Args:
        kind: the `ControlKind`.
        settings: settings of the law for a machine.
        joints: number of that machine's joints.
        cycle: control cycle, s.

    Raises:
        KindError: a function fails, or returns an invalid value.
    """
    zeros, law_name = (0.0,) * joints, f"control law {kind.name!r}"
    sensed = Sensed(zeros, zeros)
    with tolerating_arithmetic(kind.step):
        with naming_law(law_name, "wake", kind.wake):
            memory = kind.wake(settings, sensed)
            check_memory(memory)
        for angle in TRIAL_DEMANDS:
            with naming_law(law_name, "step", kind.step):
                result = kind.step(settings, memory, sensed, Demand((angle,) * joints, zeros, zeros, zeros), cycle)
                check_step(result, memory, joints, kind.report)
            memory = result[0]
        with naming_law(law_name, "centre_shift", kind.centre_shift):
            check_numbers(kind.centre_shift(settings, memory, zeros), joints, "the shift")


def check_report(report: Any, signals: Any) -> None:
    """Raise MisfitError for a report that is no named tuple class, or for signals that do not describe its fields.

    Each signal (unit and meaning by name) must be a field of the report; fields without a signal are not looked for.
    """
    if not hasattr(report, "_fields"):
        raise MisfitError("`report` is no named tuple class")
    if not isinstance(signals, dict):
        raise MisfitError(f"`signals` is {described(signals)}, not unit and meaning by name")
    for name, entry in signals.items():
        if type(entry) is not tuple or len(entry) != 2 or not all(isinstance(text, str) for text in entry):
            raise MisfitError(f"signal {name!r} has {described(entry)}, not unit and meaning")
        if name not in report._fields:
            raise MisfitError(f"signal {name!r} is no field of `report`")
        try:
            is_unit = entry[0] == "1" or (unit_of(entry[0]) != () and is_own(dict(unit_of(entry[0]))))
        except ValueError:
            is_unit = False
        if not is_unit:
            raise MisfitError(f"signal {name!r} has the unit {entry[0]!r}, which is none; give one such as rad, V or 1")


@dataclass
class CycleClock:
    """Clock of the control cycles since a law's `wake`, for messages."""

    time: float = 0.0  # s


@dataclass(frozen=True)
class PlainWake:
    """`wake` of a law in plain Python, with its result checked."""

    kind: str  # name of the control law
    function: Callable[..., Any]
    clock: CycleClock = field(compare=False)

    def __call__(self, settings: Any, sensed: Any) -> Any:
        """Call the function, reset the clock, and return the memory; raise KindError if it fails or that is invalid."""
        with naming_law(f"control law {self.kind!r}", "wake", self.function):
            memory = self.function(settings, sensed)
            check_memory(memory)
        self.clock.time = 0.0
        return memory


@dataclass(frozen=True)
class PlainStep:
    """`step` of a law in plain Python, with its result checked."""

    kind: str  # name of the control law
    function: Callable[..., Any]
    report: type
    clock: CycleClock = field(compare=False)

    def __call__(self, settings: Any, memory: Any, sensed: Any, demand: Any, elapsed: float) -> Any:
        """Call the function for one cycle, and advance the clock by `elapsed`.

        Args:
            settings: settings of the law.
            memory: memory before the cycle.
            sensed: readings of the sensors.
            demand: demand of the joints.
            elapsed: time since the last cycle, s.

        Returns:
            Memory, command and report.

        Raises:
            KindError: the function fails or returns an invalid value.
        """
        with naming_law(f"control law {self.kind!r}", "step", self.function, f" at {self.clock.time:.4g} s"):
            result = self.function(settings, memory, sensed, demand, elapsed)
            check_step(result, memory, len(sensed.angle), self.report)
        self.clock.time += elapsed
        return result


def find_flaw(kind: Any, settings: Any, cycles: Iterable[tuple[Sensed, Demand]], cycle: float) -> str:
    """Return the first invalid value that a law returned in a run, by repetition of its cycles in plain Python.

    Args:
        kind: the `ControlKind`.
        settings: settings of its law.
        cycles: inputs of the law in each cycle, from the first on.
        cycle: control cycle, s.

    Returns:
        Kind, file, line, time and value in one line; empty if all are valid, or if arithmetic fails in plain Python.
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
    except (ArithmeticError, ValueError):  # in plain Python only: compiled, 1/0 is infinite and may be unused
        return ""
    return ""
