"""The device over a plant that only notes what is done to it, and over a machine in motion."""

import time
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from layflat.errors import MachineError
from layflat.machine import changed, load
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import RigCommand
from layflat.sim.plant import SteppedPlant

Array = NDArray[np.float64]

SMALL, ARM = load("paper-small-joint-fast"), load("paper-arm-fast")
AMBIENT, FULL = ARM.supply.ambient_pressure, ARM.supply.pressure
MS = NS_PER_SECOND // 1000
CENTRE, OPEN = [5.0], [10.0]


class Notebook:
    """A plant that does not move and keeps what it was given, with the instant (s)."""

    joints = ("only",)

    def __init__(self) -> None:
        self.supply, self.payload, self.time = AMBIENT, 0.0, 0.0
        self.load = self.angles = self.velocities = np.zeros(1)
        self.pressures = np.full((1, 2), AMBIENT)
        self.drives: list[tuple[float, list[float]]] = []

    def drive(self, voltages: Array) -> None:
        self.drives.append((self.time, voltages.tolist()))

    def advance(self, until: float) -> None:
        assert until >= self.time - 1e-9
        self.time = until

    def sense(self) -> tuple[Array, Array]:
        return np.zeros(1), np.zeros(1)

    def seize(self, joint: int, opening: float | None) -> None: ...

    def burst(self, joint: int, hose: int | None) -> None: ...

    def kink(self, joint: int, share: float) -> None: ...

    def grip(self, joint: int, torque: float) -> None: ...


def noted(*, running: bool = True, **changes: Any) -> tuple[VirtualDevice, Notebook, VirtualClock]:
    machine = SMALL
    for path, value in changes.items():
        machine = changed(machine, f"interface.{path}", value)
    plant, clock = Notebook(), VirtualClock(7 * NS_PER_SECOND + 123)
    return VirtualDevice(machine, plant, clock, running=running), plant, clock  # type: ignore[arg-type]


def drives(plant: Notebook) -> list[Any]:
    return plant.drives


def state(device: VirtualDevice) -> DeviceState:
    return device.state


def asked(voltage: float = 6.0, *, air: bool = True, reset: bool = False) -> RigCommand:
    return RigCommand(np.array([voltage]), air, reset)


def after(clock: VirtualClock, nanoseconds: int) -> None:
    clock.wait(clock.now() + nanoseconds)


def test_it_is_switched_on_dumped_and_without_air() -> None:
    device, plant, _ = noted(running=False)
    reading = device.reading()
    assert (reading.device, reading.supply, reading.stopped) == (DeviceState.DUMPED, AMBIENT, False)
    assert drives(plant) == [(0.0, OPEN)]
    device.obey(asked())
    assert state(device) is DeviceState.DUMPED
    assert len(drives(plant)) == 1


def test_running_it_obeys_at_once() -> None:
    device, plant, clock = noted()
    after(clock, 3 * MS)
    device.obey(asked(7.5))
    assert drives(plant)[-1] == (pytest.approx(0.003), [7.5])
    assert plant.supply == FULL
    assert device.capabilities[:5] == (1, 0.0, 10.0, 5.0, True)


def test_digital_outputs_stay_while_it_is_centred_are_off_once_it_dumps_and_come_on_by_commands_alone() -> None:
    device, _, clock = noted()
    device.obey(asked()._replace(outputs=5))
    after(clock, 50 * MS)
    assert (device.reading().device, device.outputs) == (DeviceState.CENTRED, 5)
    after(clock, NS_PER_SECOND)
    assert (device.reading().device, device.outputs) == (DeviceState.DUMPED, 0)
    device.obey(asked()._replace(outputs=5))
    assert device.outputs == 0
    device.obey(asked(reset=True)._replace(outputs=1))
    assert (state(device), device.outputs) == (DeviceState.RUNNING, 1)
    device.stopped = True
    assert device.outputs == 0


@given(st.integers(0, NS_PER_SECOND), st.lists(st.integers(0, NS_PER_SECOND), max_size=5), st.booleans())
def test_the_watchdog_bites_to_the_instant_however_long_nobody_looks(
    gap: int, looks: list[int], commanded: bool
) -> None:
    device, plant, clock = noted()
    if commanded:
        after(clock, 11 * MS)
        device.obey(asked())
    begin = len(drives(plant))
    heard, since = clock.now(), plant.time
    for look in sorted(look for look in looks if look < gap):
        clock.wait(heard + look)
        device.tick()
    clock.wait(heard + gap)
    state = device.reading().device
    assert state is (
        DeviceState.RUNNING if gap < 20 * MS else DeviceState.CENTRED if gap < 200 * MS else DeviceState.DUMPED
    )
    due = [(at, voltages) for at, voltages in ((0.02, CENTRE), (0.5, OPEN)) if gap >= round(at * NS_PER_SECOND)]
    assert drives(plant)[begin:] == [(pytest.approx(since + at, abs=1e-9), voltages) for at, voltages in due]
    assert plant.time == pytest.approx(since + gap / NS_PER_SECOND)
    if state is DeviceState.DUMPED and gap > 600 * MS:
        assert plant.supply == AMBIENT


def test_centred_it_keeps_the_air_and_obeys_the_next_command() -> None:
    device, plant, clock = noted()
    after(clock, 150 * MS)
    assert device.reading().device is DeviceState.CENTRED
    assert plant.supply == FULL
    device.obey(asked(8.0))
    assert state(device) is DeviceState.RUNNING
    assert drives(plant)[-1][1] == [8.0]
    after(clock, 19 * MS)
    assert device.reading().device is DeviceState.RUNNING


def test_a_dump_before_the_watchdog_leaves_out_the_centre() -> None:
    device, plant, clock = noted(watchdog_cycles=100, dump_after=0.1)
    after(clock, NS_PER_SECOND)
    assert device.reading().device is DeviceState.DUMPED
    assert [voltages for _, voltages in drives(plant)] == [CENTRE, CENTRE, OPEN]
    assert [at for at, _ in drives(plant)[1:]] == pytest.approx([0.1, 0.4])


def test_a_command_that_is_no_number_is_no_command() -> None:
    device, plant, clock = noted()
    for _ in range(3):
        after(clock, 10 * MS)
        device.obey(asked(float("nan")))
    assert state(device) is DeviceState.CENTRED
    assert [voltages for _, voltages in drives(plant)] == [CENTRE, CENTRE]


def test_a_reset_is_an_edge_and_a_stuck_one_is_none() -> None:
    device, _, _ = noted(running=False)
    device.obey(asked(reset=True))
    assert state(device) is DeviceState.DUMPED
    device.obey(asked())
    assert state(device) is DeviceState.DUMPED
    device.obey(asked(reset=True))
    assert state(device) is DeviceState.RUNNING


def test_the_e_stop_dumps_at_once_and_a_reset_held_through_it_does_nothing() -> None:
    device, plant, clock = noted()
    after(clock, 2 * MS)
    device.stopped = True
    assert drives(plant)[-1] == (pytest.approx(0.002), CENTRE)
    assert not device.line.air
    assert (device.reading().stopped, state(device)) == (True, DeviceState.DUMPED)
    for reset in (False, True):
        device.obey(asked(reset=reset))
        assert state(device) is DeviceState.DUMPED
    device.stopped = False
    device.obey(asked(reset=True))
    assert state(device) is DeviceState.DUMPED
    after(clock, 300 * MS)
    device.tick()
    assert drives(plant)[-1] == (pytest.approx(0.302), OPEN)
    device.obey(asked(reset=False))
    device.obey(asked(9.0, reset=True))
    assert state(device) is DeviceState.RUNNING
    assert drives(plant)[-1][1] == [9.0]


steps = st.one_of(
    st.tuples(st.just("obey"), st.booleans(), st.booleans()),
    st.tuples(st.just("press"), st.booleans(), st.just(False)),
    st.tuples(st.just("wait"), st.integers(0, 300), st.just(False)),
)


@given(st.lists(steps, max_size=40), st.booleans())
def test_only_an_edge_with_the_e_stop_released_ends_a_dump(steps: list[tuple[str, int, bool]], running: bool) -> None:
    device, plant, clock = noted(running=running)
    reset = True
    for step, value, air in steps:
        before = state(device)
        if step == "press":
            device.stopped = bool(value)
        elif step == "wait":
            after(clock, value * MS)
            device.tick()
        else:
            device.obey(asked(6.0, air=air, reset=bool(value)))
            edge, reset = bool(value) and not reset, bool(value)
            assert (state(device) is DeviceState.DUMPED) == (
                before is DeviceState.DUMPED and not (edge and not device.stopped)
            )
        if step != "obey" and before is DeviceState.DUMPED:
            assert state(device) is DeviceState.DUMPED
        if device.stopped:
            assert state(device) is DeviceState.DUMPED
        if state(device) is DeviceState.DUMPED:
            assert not device.line.air
            assert drives(plant)[-1][1] in (CENTRE, OPEN)


def test_the_supply_is_reported_as_its_converter_sees_it() -> None:
    device, _, clock = noted(supply_bits=8)
    lsb = 10e5 / 256
    assert device.reading().supply - AMBIENT == lsb * round(4e5 / lsb)
    device.line.regulator = 20e5
    after(clock, 15 * MS)
    device.obey(asked())
    for _ in range(100):
        after(clock, 15 * MS)
        device.obey(asked())
    assert device.reading().supply - AMBIENT == pytest.approx(10e5)


def test_a_rig_without_valves_is_refused() -> None:
    with pytest.raises(MachineError, match="has no valve or sensors"):
        VirtualDevice(load("rig-kevlar"), Notebook(), VirtualClock())  # type: ignore[arg-type]


def test_air_comes_softly_and_goes_when_nobody_commands() -> None:
    clock, plant = VirtualClock(), SteppedPlant(SMALL, pressures=(AMBIENT, AMBIENT))
    device = VirtualDevice(SMALL, plant, clock)
    device.obey(asked(5.0))
    device.obey(asked(5.0, reset=True))
    highest, readings = AMBIENT, []
    for _ in range(3000):
        after(clock, 5 * MS)
        readings.append(device.reading().supply)
        rise = np.max(plant.pressures) - highest
        # Full of air at once, a hose would gain a bar in 20 ms.
        assert rise < 5e3
        highest += rise
        device.obey(asked(5.0))
    assert readings == sorted(readings)
    assert AMBIENT + 0.5e5 < readings[20] < AMBIENT + 2e5
    assert plant.pressures[0].min() > 3e5
    after(clock, NS_PER_SECOND)
    assert device.reading().device is DeviceState.DUMPED
    assert plant.pressures == pytest.approx(AMBIENT, abs=1e4)


def test_idle_for_an_hour_it_rests_and_is_cheap() -> None:
    clock, plant = VirtualClock(), SteppedPlant(ARM, start=(0.2, -0.2), pressures=(3e5, 3e5))
    device = VirtualDevice(ARM, plant, clock, running=True)
    after(clock, 60 * NS_PER_SECOND)
    device.tick()
    at_rest = plant.angles
    begin = time.process_time()
    after(clock, 3600 * NS_PER_SECOND)
    assert device.reading().device is DeviceState.DUMPED
    assert time.process_time() - begin < 36.0
    assert np.array_equal(plant.angles, at_rest)
    assert plant.velocities.tolist() == [0.0, 0.0]
    assert plant.pressures == pytest.approx(AMBIENT, abs=1.0)


@settings(max_examples=8)
@given(st.integers(0, 2**32))
def test_pressures_of_joints_at_rest_stay_between_the_atmosphere_and_the_supply(seed: int) -> None:
    held = changed(changed(ARM, "joint.large.brake.torque", 1e4), "joint.small.brake.torque", 1e4)
    rng, clock, plant = np.random.default_rng(seed), VirtualClock(), SteppedPlant(held)
    device = VirtualDevice(held, plant, clock, running=True)
    for _ in range(60):
        voltages, air = rng.uniform(0.0, 10.0, 2), rng.uniform() < 0.9
        device.obey(RigCommand(np.round(voltages / 5.0) * 5.0, air, reset=True))
        device.obey(RigCommand(voltages, air))
        after(clock, int(rng.integers(1, 40)) * MS)
        device.tick()
        assert plant.pressures.min() > AMBIENT - 100.0
        assert plant.pressures.max() < FULL + 100.0
        assert AMBIENT <= plant.supply <= FULL
