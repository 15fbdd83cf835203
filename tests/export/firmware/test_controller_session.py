"""A rig whose device runs the law, as its operator has it: a session over a serial line, in real time."""

import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from layflat.rig.drivers import create_driver
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import RigSession, RigSnapshot
from tests.export.firmware.boards import WHOLE_CHECK
from tests.export.firmware.controllers import Firmware
from tests.export.firmware.served import BoardOnPlant, ServedController, board_on_plant, patient_machine
from tests.rig.fake_drivers import LineRecorder

pytestmark = pytest.mark.realtime
MACHINE = patient_machine()


@pytest.fixture(scope="module", params=["here", pytest.param("cortex-m7", marks=WHOLE_CHECK)])
def served(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[ServedController | BoardOnPlant]:
    folder, firmware = tmp_path_factory.mktemp("served"), Firmware(MACHINE)
    if request.param == "here":
        firmware.build(folder)
        with ServedController(MACHINE, folder / "device.so") as running:
            yield running
    else:
        with board_on_plant(MACHINE, firmware, request.param, folder) as board:
            yield board


def wait(rig: RigSession, condition: Callable[[RigSnapshot], object], seconds: float = 30.0) -> RigSnapshot:
    """Return the first snapshot with a condition."""
    until = time.monotonic() + seconds
    while (shot := rig.snapshot()) is None or not condition(shot):
        assert time.monotonic() < until, shot and (shot.state, shot.fault_text, shot["device"], shot["supply"])
        time.sleep(0.01)
    return shot


def test_it_moves_fails_and_starts_again(served: ServedController | BoardOnPlant, tmp_path: Path) -> None:
    recorder = partial(LineRecorder, tmp_path / "lines")
    with RigSession(MACHINE, partial(create_driver, served.address, MACHINE), recorder) as rig:
        rig.start()
        wait(rig, lambda shot: shot.state is RigState.READY)
        rig.ask([0.3, -0.2])
        wait(rig, lambda shot: np.allclose(shot["averaged_angle"], [0.3, -0.2], atol=0.03))
        served.tell("fail e-stop")
        shot = wait(rig, lambda shot: shot.state is RigState.FAULT)
        assert shot.fault is Fault.E_STOP
        wait(rig, lambda shot: not shot["air"])
        served.tell("heal e-stop")
        wait(rig, lambda shot: not shot["stopped"])
        rig.reset()
        wait(rig, lambda shot: shot.state is RigState.OFF)
        rig.start()
        wait(rig, lambda shot: shot.state is RigState.MOVING)
        served.tell("fail angle-open small")
        shot = wait(rig, lambda shot: shot.fault is Fault.ANGLE_AT_RAIL)
        assert list(shot["joint_fault"]) == [0.0, Fault.ANGLE_AT_RAIL]
        served.tell("heal angle-open small")
        wait(rig, lambda shot: shot["measured_angle"][1] > -1.0)
        rig.reset()
        wait(rig, lambda shot: shot.fault is Fault.NONE)
    assert rig.process.exitcode == 0
    lines = (tmp_path / "lines").read_text().splitlines()
    for line in ("off -> starting", "ready -> moving", "e-stop", "joint 'small': angle sensor open or shorted"):
        assert line in lines
