from typing import Any

import pytest

from layflat.control.paper.law import Settings
from layflat.lanes import leaves, slots
from layflat.physics.adjustable import FULL_FRACTIONS
from layflat.physics.driver import ZERO_COMMANDS
from layflat.physics.plant import states_at_rest
from layflat.sim.loop import (
    NO_INJECTION,
    ZERO_JOINT_SIGNALS,
    ZERO_NOISE,
    CycleSpan,
    LoopPorts,
    MachineState,
    Timing,
    initial_memory,
    run_span,
)
from tests.physics.plants import AROUND, CYCLE, GAINS, JOINTS, TWO_LINKS

CYCLES = 6
TIMING = Timing(CYCLE, 20, 2)
NOT_NUMBER = float("nan")


def begun() -> MachineState:
    unknown = (NOT_NUMBER,) * len(JOINTS)
    joints = slots(JOINTS)
    states = slots(states_at_rest(TWO_LINKS, JOINTS, (0.1, -0.2), unknown, unknown, AROUND))
    settings = Settings((GAINS,) * len(JOINTS))
    acting, leads = slots(joints, ZERO_JOINT_SIGNALS), slots(joints, NO_INJECTION)
    lines, shares = slots(joints, ZERO_COMMANDS), slots(joints, FULL_FRACTIONS)
    memory = slots((initial_memory(settings, joints, states),))
    around = slots((AROUND,))
    return MachineState(TWO_LINKS, settings, AROUND, around, acting, joints, states, lines, shares, leads, memory)


def meet(run: dict[str, Any], arm: Any, states: Any, k: int, cycle: float) -> bool:
    del arm, states, cycle
    run["met"].append(k)
    return False


def give(run: dict[str, Any], air: Any, around: Any, acting: Any, noise: Any, k: int) -> None:
    del run
    around[0] = air
    if k % 2:
        return  # nothing new
    for j in range(len(acting)):
        demand = 0.1 * (k % 4) - 0.2 * j
        acting[j] = ZERO_JOINT_SIGNALS._replace(
            demand=demand, opening=NOT_NUMBER, voltage=NOT_NUMBER, brake=1.0, dither=1.0
        )
        noise[j] = ZERO_NOISE


def record(run: dict[str, Any], *seen: Any) -> None:
    *_, voltages, _, k, i = seen
    run["recorded"].append((k, i, tuple(voltages)))


def check(run: dict[str, Any], states: Any, k: int, i: int) -> bool:
    del states
    return bool((k, i) == run["stop"])


def gone(*spans: CycleSpan, stop: tuple[int, int] | None = None) -> tuple[list[float], dict[str, Any]]:
    """Numbers of a machine after these spans, and what the ports saw."""
    machine = begun()
    run: dict[str, Any] = {"met": [], "recorded": [], "stop": stop}
    for span in spans:
        run_span(machine, span, TIMING, LoopPorts(meet, give, record, check), run)
    changing = machine.states, machine.lines, machine.shares, machine.memory
    return list(leaves(tuple(map(tuple, changing)))), run


def test_a_run_that_stops_after_every_cycle_is_the_run_that_does_not() -> None:
    whole, seen = gone(CycleSpan(0, CYCLES))
    stopped, also = gone(*(CycleSpan(k, k + 1) for k in range(CYCLES)))
    assert whole == stopped
    assert seen == also
    assert seen["met"] == list(range(CYCLES))
    assert len(seen["recorded"]) == CYCLES * TIMING.records
    assert whole != gone(CycleSpan(0, CYCLES - 1))[0]


@pytest.mark.parametrize("i", [0, 1])
def test_a_run_ends_where_a_port_says_so(i: int) -> None:
    _, seen = gone(CycleSpan(0, CYCLES), stop=(2, i))
    assert seen["met"] == [0, 1, 2]
    assert [(k, part) for k, part, _ in seen["recorded"]][-1] == (2, i)
