"""The control cycle of a rig on a microcontroller computes this computer's numbers, while things fail."""

from pathlib import Path

import numpy as np
import pytest

from layflat.machine import load
from layflat.rig.safety.cycle_numbers import CONTROL_STAGE, FAULT_DETECTED, JUDGE_STAGE
from layflat.rig.safety.faults import Fault
from tests.export.firmware.boards import BOARDS, WHOLE_CHECK, require_tools
from tests.export.firmware.cycles import Cycles, record_cycles, replay_cycles
from tests.export.firmware.host_cycles import HostCycle

MAX_INSTRUCTIONS = {  # of a whole cycle
    ("paper-arm", "cortex-m7", "double"): 8_000,
    ("paper-arm", "cortex-m4f", "single"): 8_000,
    ("paper-arm", "cortex-m4f", "double"): 250_000,  # emulated
    ("paper-arm-tracking", "cortex-m7", "double"): 40_000,
    ("paper-arm-tracking", "cortex-m4f", "single"): 40_000,
}
FLASH, RAM = 128 * 1024, 16 * 1024  # of a small microcontroller, bytes
CASES = [pytest.param(*case, marks=WHOLE_CHECK if "tracking" in case[0] else ()) for case in MAX_INSTRUCTIONS]

Recordings = dict[str, tuple[Cycles, list[str]]]
HostCycles = dict[tuple[str, str], HostCycle]


@pytest.fixture(scope="module")
def recordings() -> Recordings:
    """Cycles and events of the machines, each recorded once."""
    return {}


@pytest.fixture(scope="module")
def host_cycles() -> HostCycles:
    """Cycles as object files of this computer, by machine and precision."""
    return {}


def cycles_of(recordings: Recordings, name: str) -> tuple[Cycles, list[str]]:
    if name not in recordings:
        recordings[name] = record_cycles(load(name))
    return recordings[name]


def host_cycle(host_cycles: HostCycles, name: str, precision: str) -> HostCycle:
    if (name, precision) not in host_cycles:
        host_cycles[name, precision] = HostCycle(load(name), precision)
    return host_cycles[name, precision]


def test_the_recorded_cycles_detect_many_faults(recordings: Recordings) -> None:
    cycles, _ = cycles_of(recordings, "paper-arm")
    assert {Fault.ANGLE_AT_RAIL, Fault.OVER_PRESSURE, Fault.SUPPLY_LOST} <= set(cycles.faults.tolist())
    assert set(cycles.stages.tolist()) > {JUDGE_STAGE}
    assert (cycles.outcomes & FAULT_DETECTED).any()


@pytest.mark.parametrize(("name", "target", "precision"), CASES)
def test_a_cycle_on_a_board_computes_the_numbers_of_the_host(
    recordings: Recordings, host_cycles: HostCycles, name: str, target: str, precision: str, tmp_path: Path
) -> None:
    require_tools()
    cycles, _ = cycles_of(recordings, name)
    cycle = host_cycle(host_cycles, name, precision)
    if precision == "single":
        results = [cycle.run(*both) for both in zip(cycles.before, cycles.stages.tolist(), strict=True)]
        outcomes, after = (np.array(one) for one in zip(*results, strict=True))
    else:
        outcomes, after = cycles.outcomes, cycles.after
    done = replay_cycles(cycle, cycles, target, BOARDS[target], tmp_path)
    np.testing.assert_array_equal(done.outcomes, outcomes)
    np.testing.assert_array_equal(done.after, after)
    whole = cycles.stages & (JUDGE_STAGE | CONTROL_STAGE) == JUDGE_STAGE | CONTROL_STAGE
    assert done.instructions[whole].max() <= MAX_INSTRUCTIONS[name, target, precision]
    assert done.flash <= FLASH
    assert done.ram <= RAM


@pytest.mark.parametrize("precision", ["double", "single"])
def test_a_loop_with_the_exported_cycle_finds_what_the_host_finds(
    recordings: Recordings, host_cycles: HostCycles, precision: str
) -> None:
    cycles, events = cycles_of(recordings, "paper-arm")
    others, other_events = record_cycles(load("paper-arm"), cycle=host_cycle(host_cycles, "paper-arm", precision))
    assert other_events == events
    if precision == "double":
        np.testing.assert_array_equal(others.after, cycles.after)
    else:
        assert others.after.shape[0] == pytest.approx(cycles.after.shape[0], abs=len(events))
