"""Compiled control laws from outside: a number that is none ends the run, whoever returned it."""

from math import inf, isfinite, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from layflat.control import CONTROL_LAWS, FULL_FRACTIONS, Command, Demand, Sensed
from layflat.control.checks import find_flaw, guard_step
from layflat.errors import KindError
from layflat.jit import law
from layflat.lanes import Lanes


class Memory(NamedTuple):
    cycles: float


class Report(NamedTuple):
    error: float


class Kind(NamedTuple):
    """What is asked of a kind here."""

    name: str
    wake: Any
    step: Any
    report: type = Report


LATE = 3.0  # cycles after which a law goes wrong
FLAWS: dict[str, tuple[Any, str]] = {
    "voltage": (lambda x: (x, 0.0, 0.0, 1.0), "item 1 of `voltage` is"),
    "memory": (lambda x: (5.0, 0.0 * x, 0.0, 1.0), "cycles of the memory is nan"),
    "report": (lambda x: (5.0, 0.0, x, 1.0), "error of an item of the report is"),
    "share": (lambda x: (5.0, 0.0, 0.0, x), "brake of an item of `shares` is"),
}


def step_with(flawed: Any) -> Any:
    @law
    def step(settings: Any, memory: Any, sensed: Any, demand: Any, elapsed: float) -> Any:
        late = memory.cycles >= LATE
        voltage, kept, error, share = flawed if late else (5.0, 0.0, 0.0, 1.0)
        return (
            Memory(memory.cycles + 1.0 + kept),
            Command((voltage,), (FULL_FRACTIONS._replace(brake=share),)),
            (Report(error),),
        )

    return step


def wake(settings: Any, sensed: Any) -> Memory:
    return Memory(0.0)


NOTHING = Sensed((0.0,), (0.0,)), Demand(*[(0.0,)] * 4)


@pytest.mark.parametrize("value", [inf, -inf, nan])
@pytest.mark.parametrize("flaw", FLAWS)
def test_a_number_that_is_none_spoils_the_voltage_at_once_and_is_found_again(flaw: str, value: float) -> None:
    flawed, said = FLAWS[flaw]
    step = step_with(flawed(value))
    guarded = guard_step(step)
    memory = Memory(0.0)
    for k in range(5):
        after, command, report = guarded(None, memory, *NOTHING, 0.005)
        assert isfinite(command.voltage[0]) == (k < LATE)
        if k < LATE:
            assert (after, command, report) == step(None, memory, *NOTHING, 0.005)
        memory = Memory(k + 1.0)
    found = find_flaw(Kind("tried", wake, step), None, [NOTHING] * 5, 0.005)
    assert said in found
    assert f"{Path(__file__).name}:" in found
    assert "`step` of control law 'tried' returns a wrong result at 0.015 s" in found


@pytest.mark.parametrize("share", [1.5, -0.1])
def test_a_share_out_of_range_spoils_the_voltage(share: float) -> None:
    step = step_with((5.0, 0.0, 0.0, share))
    _, command, _ = guard_step(step)(None, Memory(LATE), *NOTHING, 0.005)
    assert not isfinite(command.voltage[0])
    assert f"is {share:g}, not a share from 0 to 1" in find_flaw(Kind("tried", wake, step), None, [NOTHING] * 5, 0.005)


def test_runs_side_by_side_are_spoilt_one_by_one() -> None:
    @law
    def step(settings: Any, memory: Any, sensed: Any, demand: Any, elapsed: float) -> Any:
        return memory, Command(sensed.angle, (FULL_FRACTIONS,)), (Report(0.0),)

    sensed: Any = Sensed((Lanes((1.0, inf, 3.0, nan)),), (Lanes((0.0,) * 4),))  # type: ignore[arg-type]
    _, command, _ = guard_step(step)(None, Memory(0.0), sensed, NOTHING[1], 0.005)
    assert np.array_equal(np.isfinite(command.voltage[0]), [True, False, True, False])


def test_what_is_sound_is_not_found() -> None:
    assert find_flaw(Kind("tried", wake, step_with((5.0, 0.0, 0.0, 1.0))), None, [NOTHING] * 5, 0.005) == ""


def test_laws_of_the_package_run_as_they_are() -> None:
    from layflat import control

    for kind in CONTROL_LAWS:
        if not CONTROL_LAWS.is_from_outside(kind):
            assert control.step.kinds[kind.parameter_types[0]] is kind.step  # type: ignore[attr-defined]


def test_a_plain_law_s_shares_are_checked() -> None:
    from layflat.control.checks import CycleClock, PlainStep

    step = PlainStep("tried", step_with((5.0, 0.0, 0.0, 2.0)), Report, CycleClock())
    with pytest.raises(KindError, match="brake of an item of `shares` is 2, not a share from 0 to 1"):
        step(None, Memory(LATE), *NOTHING, 0.005)
