import numpy as np
import pytest

from layflat.machine import Machine, load, parameters
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device.virtual import ReplyFault, SimulatedDriver, VirtualDevice
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import DriverError, Lifecycle, LinkError, RigCommand
from layflat.sim import rollout
from layflat.sim.plant import SteppedPlant
from tests.physics.controllers import Controller

SMALL = load("paper-small-joint")
CYCLE = 5_000_000


def driver_of(machine: Machine, **options: object) -> tuple[SimulatedDriver, VirtualClock]:
    clock = VirtualClock(3 * NS_PER_SECOND)
    plant = SteppedPlant(machine, start=0.0, **options)  # type: ignore[arg-type]
    driver = SimulatedDriver(VirtualDevice(machine, plant, clock, running=True))
    driver.configure()
    driver.activate()
    return driver, clock


@pytest.mark.parametrize("name", ["paper-arm", "paper-small-joint"])
def test_a_loop_over_it_is_the_rollout_bit_for_bit(name: str) -> None:
    machine = load(name)
    run = rollout(machine, "20 deg", start=0.0, duration=0.3, seed=9)
    driver, clock = driver_of(machine, seed=9)
    n, begin = len(machine.joints), clock.now()
    controller = Controller(parameters.control(machine), np.zeros(n), np.zeros(n))
    for k in range(60):
        clock.wait(begin + k * CYCLE)
        reading = driver.read()
        voltages = controller.voltages(reading.angles, reading.pressures, 0.005, np.full(n, np.radians(20.0)))
        driver.write(RigCommand(voltages, air=True))
        assert np.array_equal(reading.angles, run["measured_angle"][k])
        assert np.array_equal(reading.pressures, run["measured_pressure"][k])
        assert np.array_equal(voltages, run["voltage"][k])
        assert reading.device is DeviceState.RUNNING


def test_only_an_active_driver_writes() -> None:
    driver, _ = driver_of(SMALL)
    command = RigCommand(np.array([5.0]), air=True)
    driver.write(command)
    driver.deactivate()
    with pytest.raises(DriverError, match="SimulatedDriver: can't write while inactive"):
        driver.write(command)
    assert driver.read().device is DeviceState.RUNNING


def test_put_down_it_centres_and_lets_out_the_air() -> None:
    driver, clock = driver_of(SMALL)
    driver.write(RigCommand(np.array([9.0]), air=True))
    driver.finalize()
    assert driver.state is Lifecycle.FINALIZED
    clock.wait(clock.now() + NS_PER_SECOND)
    reading = driver.read()
    assert reading.device is DeviceState.DUMPED
    assert reading.supply == SMALL.supply.ambient_pressure


@pytest.mark.parametrize(
    ("kind", "told"),
    [(ReplyFault.LOST, "lost"), (ReplyFault.LATE, "lost"), (ReplyFault.CRC, "crc"), (ReplyFault.SEQUENCE, "sequence")],
)
def test_spoilt_replies_are_told_and_counted(kind: ReplyFault, told: str) -> None:
    driver, _ = driver_of(SMALL)
    driver.device.link.spoil(kind, 2)
    for _ in range(2):
        with pytest.raises(LinkError) as caught:
            driver.read()
        assert caught.value.kind == told
    driver.read()


def test_over_a_cut_wire_nothing_is_heard() -> None:
    driver, clock = driver_of(SMALL)
    driver.device.link.silent = True
    for _ in range(5):
        clock.wait(clock.now() + CYCLE)
        with pytest.raises(LinkError, match="lost"):
            driver.read()
        driver.write(RigCommand(np.array([9.0]), air=True))
    driver.device.link.mend()
    assert driver.read().device is DeviceState.CENTRED
