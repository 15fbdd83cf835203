"""The device in C that runs the law: its control cycles in lock-step with the loop's, number by number."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from layflat.machine import load
from layflat.rig.safety.faults import Fault, RigState
from tests.export.firmware.boards import WHOLE_CHECK
from tests.export.firmware.controllers import Firmware
from tests.export.firmware.lockstep import LockStep
from tests.export.firmware.loop_cycles import Cycle, run_cycles


def compare(step: LockStep, cycles: Iterator[Cycle]) -> None:
    """Let a device live through cycles: everything is as in the loop, events too."""
    events = []
    for cycle in cycles:
        step.cycle(cycle)
        events += cycle.events
    assert step.mirror.events == events
    assert step.states >= {RigState.STARTING, RigState.MOVING, RigState.FAULT}
    assert {Fault.E_STOP, Fault.ANGLE_AT_RAIL} <= step.faults


def test_it_does_what_the_loop_does(library: Any) -> None:
    machine = load("paper-arm")
    compare(LockStep(machine, library), run_cycles(machine, 14.0))


@WHOLE_CHECK
@pytest.mark.parametrize("name", ["paper-arm", "paper-arm-tracking", "picking-arm"])
def test_it_does_for_long_what_the_loop_does(name: str, tmp_path: Path) -> None:
    """Each failure comes once in 62 s."""
    machine = load(name)
    step = LockStep(machine, Firmware(machine).build(tmp_path))
    compare(step, run_cycles(machine, 62.0))
    assert len(step.faults) > 6
