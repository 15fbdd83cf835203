"""kill -9 of one process of a rig in the middle of a move; `python -m benchmarks.rig_kills` does it many times."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from benchmarks.rig_kills import VICTIMS, patient, trial
from layflat.machine import load
from layflat.rig.device.process import DeviceProcess, ModbusPort
from layflat.virtual_rig import VirtualRig

ARM = patient(load("paper-arm"))


@pytest.fixture(scope="module")
def device() -> Iterator[DeviceProcess]:
    with DeviceProcess(VirtualRig(ARM), ARM, ModbusPort()) as device:
        yield device


@pytest.mark.parametrize("victim", VICTIMS)
def test_a_kill_leaves_a_log_and_a_vented_rig(device: DeviceProcess, victim: str, tmp_path: Path) -> None:
    result = trial(device, ARM, victim, np.random.default_rng().uniform(0.0, 1.5), tmp_path)
    assert result.missing <= 0.05
    assert result.vented < 10.0
    assert result.repaired is (victim == "recorder")
