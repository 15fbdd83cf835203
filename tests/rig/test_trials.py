"""A sound rig moves at random and nothing is found; a failing one is found, and made safe."""

import numpy as np
import pytest

from layflat.machine import changed, load
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device.process import DeviceProcess, SerialPort
from layflat.rig.device.virtual import SimulatedDriver, VirtualDevice
from layflat.rig.driver import SensorReading
from layflat.rig.drivers import create_driver
from layflat.rig.trials.campaign import FaultTrial, run_campaign, summarize_outcomes
from layflat.rig.trials.cases import FAULT_CASES
from layflat.rig.trials.rig import TrialRig
from layflat.rig.trials.soak import RandomWork, run_soak
from layflat.virtual_rig import VirtualRig

ARM = load("paper-arm")
PATIENT = changed(ARM, "interface.serial.timeout", 0.03)


class LateClock(VirtualClock):
    """Now and then it wakes up late, as a clock does on a computer that others use too."""

    def __init__(self) -> None:
        super().__init__()
        self.random = np.random.default_rng(5)

    def wait(self, until: int) -> None:
        late = self.random.uniform(0.001, 0.013) if self.random.uniform() < 0.05 else 0.0
        super().wait(until + round(late * NS_PER_SECOND))


class SlowDriver(SimulatedDriver):
    """Now and then its replies take long: what they hold was sampled later than the loop asked."""

    random = np.random.default_rng(6)

    def read(self) -> SensorReading:
        if self.random.uniform() < 0.12:
            clock = self.device.clock
            clock.wait(clock.now() + round(self.random.uniform(0.001, 0.009) * NS_PER_SECOND))
        return super().read()


@pytest.mark.parametrize("clock", [VirtualClock, LateClock])
def test_nothing_is_found_of_a_sound_rig(clock: type[VirtualClock]) -> None:
    found = run_soak(ARM, VirtualRig(ARM), 60.0 / 3600.0, seed=3, clock=clock())
    assert found.moves > 20
    assert found.payloads > 5
    assert found.trips == 0, found.messages


def test_replies_that_take_long_are_no_fault_of_the_air() -> None:
    found = run_soak(ARM, VirtualRig(ARM), 60.0 / 3600.0, seed=3, driver_of=SlowDriver)
    assert found.trips == 0, found.messages


def test_payloads_wait_for_motions_to_end() -> None:
    host = RandomWork(load("paper-arm-tracking"), np.random.default_rng(2))
    told, rests, now = [], [], 0
    for _ in range(4000):
        host.send_due_demand(now)
        asked = host.request(now)
        told.append(any((*(asked.velocities or ()), *(asked.accelerations or ()))))
        rests.append(host.is_resting)
        now += round(0.005 * NS_PER_SECOND)
    assert any(told)
    assert rests == [not moves for moves in told]


def test_every_fault_is_found_over_the_wire_in_time_and_the_rig_is_made_safe() -> None:
    with DeviceProcess(VirtualRig(PATIENT), PATIENT, SerialPort(), lockstep=True) as device:
        rig = TrialRig(PATIENT, device, create_driver(device.address, PATIENT))
        outcomes = list(run_campaign(rig, 1))
    assert [outcome.row for outcome in outcomes] == list(FAULT_CASES)
    assert all(outcome.is_good for outcome in outcomes), [outcome for outcome in outcomes if not outcome.is_good]
    assert all(of["good"] == of["trials"] == 1 for of in summarize_outcomes(outcomes).values())


def test_a_rig_that_stops_before_it_is_made_to_fail_is_no_good_trial() -> None:
    row = "following error"
    with DeviceProcess(VirtualRig(PATIENT), PATIENT, SerialPort(), lockstep=True) as device:
        rig = TrialRig(PATIENT, device, create_driver(device.address, PATIENT))
        device.call(press)
        outcome = FaultTrial(rig, row, FAULT_CASES[row][0], np.random.default_rng(1)).run()
    assert not outcome.is_good
    assert outcome.detected.startswith("stopped before it failed")


def press(device: VirtualDevice) -> None:
    device.stopped = True


def test_a_law_with_a_model_bears_cycles_that_are_much_too_short_or_long() -> None:
    machine = load("paper-arm-tracking")
    found = run_soak(machine, VirtualRig(machine), 8.0 / 3600.0, seed=3, driver_of=SlowDriver)
    assert found.trips == 0, found.messages
