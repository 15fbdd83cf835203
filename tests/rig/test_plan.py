from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from layflat.machine import load
from layflat.rig.plan import EarlyEndError, PlanRunner
from layflat.rig.record import Layout
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.states import State
from layflat.rig.session import Snapshot

ARM = load("paper-arm")
LAYOUT = Layout.of(ARM)


def shot(state: State, fault: Fault = Fault.NONE) -> Snapshot:
    row = np.zeros(LAYOUT.width)
    row[LAYOUT.shared["mode"]], row[LAYOUT.shared["fault"]] = state, fault
    return Snapshot(LAYOUT, row)


def performance(*shots: Snapshot) -> PlanRunner:
    left = list(shots)
    session: Any = SimpleNamespace(start=lambda: None, check=lambda: None, snapshot=lambda: left.pop(0))
    rig: Any = SimpleNamespace(machine=ARM, session=session, recording=True)
    return PlanRunner(rig)


def test_air_that_comes_is_told_with_the_held_angles() -> None:
    off, starting, ready = shot(State.OFF), shot(State.STARTING), shot(State.READY)
    LAYOUT.named(ready.row, "demand")[1] = 0.25
    assert performance(off, off, starting, ready).bring_air() == [0.0, 0.25]


@pytest.mark.parametrize("ended", [State.STOPPED, State.OFF])
def test_a_start_that_is_broken_off_is_told_at_once(ended: State) -> None:
    broken = performance(shot(State.OFF), shot(State.STARTING), shot(ended, Fault.SETPOINT_STALE))
    with pytest.raises(EarlyEndError, match="the start was broken off: setpoint stale"):
        broken.bring_air()


def test_a_fault_on_the_way_is_told() -> None:
    with pytest.raises(EarlyEndError, match="supply lost") as error:
        performance(shot(State.OFF), shot(State.FAULT, Fault.SUPPLY_LOST)).bring_air()
    assert error.value.fault
