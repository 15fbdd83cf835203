from __future__ import annotations

from collections.abc import Callable
from math import nan, radians
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.bridge import MujocoPlant, arm_spec
from layflat.errors import DivergedError, InputError
from layflat.machine import Machine, load
from layflat.physics.driven import MachinePlant
from layflat.physics.step import STEP
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device.virtual import SimulatedDriver, VirtualDevice
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import SensorReading
from layflat.rig.loop import RigLoop
from layflat.rig.safety.faults import RigState
from layflat.rig.safety.supervisor import HostRequest
from layflat.sim.plant import SteppedPlant

mujoco: Any = pytest.importorskip("mujoco")
pytestmark = pytest.mark.compiled

ARM = load("paper-arm-fast")
AMBIENT = ARM.supply.ambient_pressure
EMPTY, FULL = (AMBIENT, AMBIENT), (3e5, 3e5)
CYCLE = 0.005


class Wanting:
    """A host that wants angles."""

    def __init__(self) -> None:
        self.demands, self.ended = [nan, nan], False

    def request(self, _now: int) -> HostRequest:
        return HostRequest(list(self.demands))

    def publish(self, row: NDArray[np.float64]) -> None: ...


def led(plant: MachinePlant, seconds: float, machine: Machine = ARM) -> tuple[NDArray[np.float64], RigLoop]:
    """Angles (cycles, joints) of a loop with driver, device and a plant, which is led to two places."""
    clock, host = VirtualClock(3 * NS_PER_SECOND), Wanting()
    driver = SimulatedDriver(VirtualDevice(machine, plant, clock, running=True))
    driver.configure()
    driver.activate()
    loop = RigLoop(machine, driver, clock, host)
    loop.start_filled(
        SensorReading(plant.angles, plant.pressures @ [1.0, -1.0], plant.supply, False, DeviceState.RUNNING)
    )
    angles, cycles = [], round(seconds / CYCLE)
    for k in range(cycles):
        host.demands = [radians(30.0), radians(-20.0)] if k < cycles // 2 else [radians(-10.0), radians(15.0)]
        loop.cycle()
        angles.append(plant.angles)
    return np.array(angles), loop


def test_a_loop_runs_on_it_as_on_our_own_plant() -> None:
    own, _ = led(SteppedPlant(ARM, start=0.0, seed=4), 4.0)
    other, loop = led(MujocoPlant(ARM, seed=4), 4.0)
    rms = np.degrees(np.sqrt(np.mean((own - other) ** 2, axis=0)))
    assert rms.max() < 0.1
    assert loop.supervisor.state is RigState.MOVING
    assert np.degrees(other[-1]) == pytest.approx([-10.0, 15.0], abs=0.5)


def test_a_law_that_plans_its_motion_runs_on_it_as_on_our_own_plant() -> None:
    machine = load("paper-arm-tracking")
    own, _ = led(SteppedPlant(machine, start=0.0, seed=4), 2.0, machine)
    other, loop = led(MujocoPlant(machine, seed=4), 2.0, machine)
    rms = np.degrees(np.sqrt(np.mean((own - other) ** 2, axis=0)))
    assert rms.max() < 0.5
    assert loop.supervisor.state is RigState.MOVING
    assert np.degrees(other[[100, -1]]) == pytest.approx(np.array([[30.0, -20.0], [-10.0, 15.0]]), abs=0.5)


def test_a_loop_runs_at_a_scenes_timestep() -> None:
    spec = arm_spec(ARM)
    spec.option.timestep = 2e-3
    angles, _ = led(MujocoPlant(ARM, spec.compile()), 4.0)
    assert np.degrees(angles[399]) == pytest.approx([30.0, -20.0], abs=0.5)
    assert np.degrees(angles[-1]) == pytest.approx([-10.0, 15.0], abs=0.5)


def test_its_hinges_may_have_other_names_and_another_order() -> None:
    spec = arm_spec(ARM)
    spec.joint("large").name, spec.joint("small").name = "one", "two"
    plant = MujocoPlant(ARM, spec.compile(), joints={"two": "small", "one": "large"}, start=("10 deg", "-20 deg"))
    assert plant.joints == ("large", "small")
    assert np.degrees(plant.angles) == pytest.approx([10.0, -20.0])
    assert plant.data.joint("two").qpos[0] == pytest.approx(radians(-20.0))


def test_time_passes_up_to_the_last_whole_step() -> None:
    plant = MujocoPlant(ARM)
    for until, reached in ((0.001, 0.001), (0.00199, 0.0015), (0.0014, 0.0015), (0.005, 0.005)):
        plant.advance(until)
        assert plant.time == pytest.approx(reached)


def test_others_act_before_and_after_every_step() -> None:
    model = arm_spec(ARM).compile()
    data = mujoco.MjData(model)
    before, after = [], []

    def step(advance: Callable[[Any], None]) -> None:
        before.append(data.time)
        data.qfrc_applied[0] = 25.0
        advance(data)
        after.append(data.time)

    plant = MujocoPlant(ARM, model, data, pressures=EMPTY, step=step)
    plant.supply = AMBIENT
    plant.advance(0.1)
    assert len(before) == round(0.1 / STEP)
    assert before == pytest.approx(np.arange(len(before)) * STEP)
    assert before[1:] == after[:-1]
    alone = MujocoPlant(ARM, pressures=EMPTY)
    alone.supply, alone.load[0] = AMBIENT, 25.0
    alone.advance(0.1)
    assert plant.angles[0] > 0.01
    assert plant.angles == pytest.approx(alone.angles, rel=1e-9)


def test_a_burst_hose_empties_and_a_seized_valve_fills() -> None:
    plant = MujocoPlant(ARM, pressures=FULL)
    plant.burst(0, 1)
    plant.seize(1, 0.5)
    plant.advance(0.4)
    assert plant.pressures[0, 1] < AMBIENT + 5e4
    assert plant.pressures[1, 0] > 4e5
    plant.burst(0, None)
    plant.seize(1, None)
    plant.drive(np.array([0.0, 0.0]))
    plant.advance(1.5)
    assert plant.pressures[0, 1] > 4e5
    assert plant.pressures[1, 1] > 4e5


def test_a_kink_narrows_what_a_valve_lets_through() -> None:
    free, kinked = MujocoPlant(ARM, pressures=FULL), MujocoPlant(ARM, pressures=FULL)
    kinked.kink(0, 0.0)
    for plant in (free, kinked):
        plant.drive(np.array([10.0, 5.0]))
        plant.advance(0.02)
    assert free.pressures[0, 0] > FULL[0] + 1e4
    assert kinked.pressures[0, 0] == pytest.approx(FULL[0], abs=100.0)


def test_a_grip_holds_and_lets_go() -> None:
    plant = MujocoPlant(ARM, pressures=EMPTY)
    plant.supply, plant.load[0] = AMBIENT, 25.0
    plant.grip(0, 30.0)
    plant.advance(0.1)
    assert plant.angles.tolist() == [0.0, 0.0]
    plant.grip(0, 0.0)
    plant.advance(0.2)
    assert plant.angles[0] > 0.01


def test_the_payload_is_a_bodys_mass() -> None:
    plant, heavy = MujocoPlant(ARM, pressures=EMPTY), MujocoPlant(ARM, pressures=EMPTY)
    assert plant.payload == 1.5
    heavy.payload = 6.0
    for one in (plant, heavy):
        one.supply, one.load[0] = AMBIENT, 25.0
        one.advance(0.1)
    assert 0.1 * plant.angles[0] < heavy.angles[0] < 0.7 * plant.angles[0]
    empty = MujocoPlant(ARM)
    empty.payload = 0.0
    empty.advance(CYCLE)
    assert empty.payload == 0.0


def test_a_model_without_payload_has_none_to_set() -> None:
    spec = arm_spec(ARM)
    spec.delete(spec.body("payload"))
    plant = MujocoPlant(ARM, spec.compile())
    assert plant.payload == 0.0
    with pytest.raises(InputError, match="payload: the model has no such body"):
        plant.payload = 1.0


def test_a_machine_that_diverges_says_so() -> None:
    plant = MujocoPlant(ARM)
    plant.load[:] = 0.0, 1e9
    with pytest.raises(DivergedError, match=r"diverged at t = .* in joint"):
        plant.advance(5.0)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"pressures": ("0 bar", "3 bar")}, "pressures: 0 Pa is not above vacuum"),
        ({"start": "1 bar"}, "start: '1 bar' is not an angle"),
        ({"start": ("1 deg",)}, "start: has 1 values; give 2: large, small"),
        ({"joints": {"large": "large"}}, "joints: are large; give one hinge for each of large, small"),
    ],
)
def test_wrong_options(options: dict[str, Any], expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        MujocoPlant(ARM, **options)
