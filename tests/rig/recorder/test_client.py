"""How much events matter: as much as the worst fault of their cycle."""

from __future__ import annotations

import numpy as np
import pytest

from layflat.rig.process import RecorderClient
from layflat.rig.recorder.ring import Event, EventLevel, RecorderState, Ring
from layflat.rig.safety.faults import Fault
from tests.rig.recorder.rigrows import LAYOUT


@pytest.mark.parametrize(
    ("fault", "level", "change"),
    [
        (Fault.NONE, EventLevel.INFO, EventLevel.INFO),
        (Fault.DEMAND_LIMITED, EventLevel.WARN, EventLevel.INFO),
        (Fault.VALVE_UNRESPONSIVE, EventLevel.ERROR, EventLevel.ERROR),
    ],
)
def test_events_matter_as_their_cycle_does(fault: Fault, level: EventLevel, change: EventLevel) -> None:
    ring = Ring.create(LAYOUT.width)
    ring.beat(RecorderState.RECORDING)
    client = RecorderClient.join(ring.path)
    row = np.zeros(LAYOUT.width)
    row[0], row[LAYOUT.shared["fault"]] = 2.5, fault
    client.push(row)
    client.event("what there is")
    client.event("ready -> moving")
    assert ring.drain_events() == [Event(2.5, level, "what there is"), Event(2.5, change, "ready -> moving")]
    client.end()
    assert ring.head.ended
    ring.remove()
