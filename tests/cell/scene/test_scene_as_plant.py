from __future__ import annotations

import numpy as np
import pytest

from layflat.bridge import MujocoPlant
from layflat.cell import Cell
from layflat.cell.scene import Scene
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import RigCommand

CYCLE = NS_PER_SECOND // 200
pytestmark = pytest.mark.compiled


def test_a_rigs_far_side_runs_on_a_scene_with_its_lift(packing: Cell) -> None:
    scene, clock, machine = Scene(packing, 1), VirtualClock(0), packing.machine
    plant = MujocoPlant(machine, scene.model, scene.data, step=lambda advance: scene.step(1, advance))
    device = VirtualDevice(machine, plant, clock, running=True)
    centred = np.full(2, device.capabilities.centre_voltage)
    opened = np.add(centred, [0.0, 1.0])
    home, scene.lift.demand = device.reading().angles, 0.03
    for cycle in range(100):
        device.obey(RigCommand(centred if cycle < 60 else opened, True))
        clock.wait(clock.now() + CYCLE)
        if cycle == 60:
            assert device.reading().angles == pytest.approx(home, abs=2e-3)
            assert scene.stroke == pytest.approx(0.03, abs=2e-3)
    assert scene.data.time == pytest.approx(0.495)
    assert device.reading().angles[1] > home[1] + 0.1
    assert scene.truth().tip[2] == pytest.approx(scene.cell.lift.clearance - 0.03, abs=2e-3)


def test_a_load_on_a_scenes_arm_can_be_set(packing: Cell) -> None:
    scene = Scene(packing, 1)
    plant = MujocoPlant(packing.machine, scene.model, scene.data)
    assert plant.payload == packing.lift.body
    plant.payload = 1.0
    assert scene.model.body("payload").mass[0] == plant.payload == 1.0
    scene.step(20, plant.step)
    assert np.isfinite(scene.data.qpos).all()
