from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from layflat.machine import load
from layflat.rig.plan import EarlyEndError, PlanRunner
from layflat.rig.record import RowLayout
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import RigSnapshot

ARM = load("paper-arm")
LAYOUT = RowLayout.for_machine(ARM)


def shot(state: RigState, fault: Fault = Fault.NONE) -> RigSnapshot:
    row = np.zeros(LAYOUT.width)
    row[LAYOUT.shared["mode"]], row[LAYOUT.shared["fault"]] = state, fault
    return RigSnapshot(LAYOUT, row)


def performance(*shots: RigSnapshot) -> PlanRunner:
    left = list(shots)
    session: Any = SimpleNamespace(start=lambda: None, check=lambda: None, snapshot=lambda: left.pop(0))
    rig: Any = SimpleNamespace(machine=ARM, session=session, is_recording=True)
    return PlanRunner(rig)


def test_air_that_comes_is_told_with_the_held_angles() -> None:
    off, starting, ready = shot(RigState.OFF), shot(RigState.STARTING), shot(RigState.READY)
    LAYOUT.named(ready.row, "demand")[1] = 0.25
    assert performance(off, off, starting, ready).start_air() == [0.0, 0.25]


@pytest.mark.parametrize("ended", [RigState.STOPPED, RigState.OFF])
def test_a_start_that_is_broken_off_is_told_at_once(ended: RigState) -> None:
    broken = performance(shot(RigState.OFF), shot(RigState.STARTING), shot(ended, Fault.SETPOINT_STALE))
    with pytest.raises(EarlyEndError, match="the start was broken off: setpoint stale"):
        broken.start_air()


def test_a_fault_on_the_way_is_told() -> None:
    with pytest.raises(EarlyEndError, match="supply lost") as error:
        performance(shot(RigState.OFF), shot(RigState.FAULT, Fault.SUPPLY_LOST)).start_air()
    assert error.value.fault
