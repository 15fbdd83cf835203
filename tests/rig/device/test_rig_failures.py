"""Every failure of the virtual rig shows in what the device says, and is gone once it is healed."""

from collections.abc import Callable
from math import radians

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine import load
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device.failures import FAILURES_BY_NAME, get_failure
from layflat.rig.device.virtual import SimulatedDriver, VirtualDevice
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import LinkError, RigCommand, SensorReading
from layflat.sim.plant import SteppedPlant

ARM = load("paper-arm-fast")
JOINT = 1


class OpenLoopRig:
    """The arm on a virtual rig, its second joint driven by a voltage."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.plant = SteppedPlant(ARM, start=0.0)
        self.device = VirtualDevice(ARM, self.plant, self.clock, running=True)
        self.driver = SimulatedDriver(self.device)
        self.driver.configure()
        self.driver.activate()

    def run(self, cycles: int, voltage: float = 5.0, *, reset: bool = False) -> list[SensorReading | str]:
        """What each cycle is told: a reading, or how the link failed."""
        told: list[SensorReading | str] = []
        for _ in range(cycles):
            self.clock.wait(self.clock.now() + NS_PER_SECOND // 200)
            try:
                told.append(self.driver.read())
            except LinkError as error:
                told.append(error.kind)
            self.driver.write(RigCommand(np.array([5.0, voltage]), air=True, reset=reset))
        return told

    def readings(self, cycles: int, voltage: float = 5.0) -> list[SensorReading]:
        """As `run`, where the link is sound."""
        told = self.run(cycles, voltage)
        assert all(isinstance(one, SensorReading) for one in told)
        return [one for one in told if isinstance(one, SensorReading)]

    def angles(self, cycles: int = 50) -> list[float]:
        return [float(reading.angles[JOINT]) for reading in self.readings(cycles)]

    def pressures(self, cycles: int = 50, voltage: float = 5.0) -> list[float]:
        return [float(reading.pressures[JOINT]) for reading in self.readings(cycles, voltage)]


def spoilt(kind: str) -> Callable[[OpenLoopRig], bool]:
    return lambda bench: bench.run(5) == [kind] * 5


def device_state(bench: OpenLoopRig) -> DeviceState:
    bench.device.tick()
    return bench.device.state


def unheard(bench: OpenLoopRig) -> bool:
    return bench.run(5) == ["lost"] * 5 and device_state(bench) is DeviceState.CENTRED


def reads_low(bench: OpenLoopRig) -> bool:
    return set(bench.angles()) == {-radians(75.0)}


def reads_high(bench: OpenLoopRig) -> bool:
    return min(bench.angles()) > radians(74.9)


def angle_repeats(bench: OpenLoopRig) -> bool:
    return len(set(bench.angles())) == 1


def pressure_reads_low(bench: OpenLoopRig) -> bool:
    return set(bench.pressures()) == {-5e5}


def pressure_repeats(bench: OpenLoopRig) -> bool:
    return len(set(bench.pressures())) == 1


def both_repeat(bench: OpenLoopRig) -> bool:
    readings = bench.readings(50)
    return len({(reading.angles[JOINT], reading.pressures[JOINT]) for reading in readings}) == 1


def does_not_answer_its_voltage(bench: OpenLoopRig) -> bool:
    before = np.mean(bench.pressures(8))
    return bool(abs(bench.pressures(60, 10.0)[-1] - before) < 0.3e5)


def filled_by_itself(bench: OpenLoopRig) -> bool:
    return bench.pressures(100)[-1] > 1e5


def hose_a_is_empty(bench: OpenLoopRig) -> bool:
    bench.readings(60, 8.0)
    return bool(bench.plant.pressures[JOINT, 0] < ARM.supply.ambient_pressure + 1e5)


def supply(bench: OpenLoopRig) -> float:
    return bench.readings(60)[-1].supply


def supply_is_gone(bench: OpenLoopRig) -> bool:
    return supply(bench) == ARM.supply.ambient_pressure


def supply_is_high(bench: OpenLoopRig) -> bool:
    return supply(bench) > ARM.supply.pressure + 1.9e5


def pushed(bench: OpenLoopRig) -> bool:
    return max(bench.angles(60)) > radians(60.0)


def held_fast(bench: OpenLoopRig) -> bool:
    before = bench.angles(1)[0]
    bench.pressures(60, 10.0)
    return abs(bench.angles(1)[0] - before) < radians(1.0)


def stopped(bench: OpenLoopRig) -> bool:
    reading: SensorReading = bench.readings(2)[-1]
    return reading.stopped and reading.device is DeviceState.DUMPED


SHOWS: dict[str, Callable[[OpenLoopRig], bool]] = {
    "reply-lost": spoilt("lost"),
    "reply-crc": spoilt("crc"),
    "reply-sequence": spoilt("sequence"),
    "reply-late": spoilt("lost"),
    "silence": unheard,
    "angle-open": reads_low,
    "angle-shorted": reads_high,
    "angle-frozen": angle_repeats,
    "pressure-open": pressure_reads_low,
    "pressure-frozen": pressure_repeats,
    "converter-frozen": both_repeat,
    "stuck-spool": filled_by_itself,
    "burst-hose": hose_a_is_empty,
    "kinked-hose": does_not_answer_its_voltage,
    "supply-lost": supply_is_gone,
    "supply-high": supply_is_high,
    "e-stop": stopped,
    "grip": held_fast,
    "push": pushed,
}


def test_every_failure_is_looked_for() -> None:
    assert set(SHOWS) == set(FAILURES_BY_NAME)


@pytest.mark.parametrize("name", FAILURES_BY_NAME)
def test_a_failure_shows_and_heals(name: str) -> None:
    bench, shows = OpenLoopRig(), SHOWS[name]
    bench.readings(20)
    get_failure(name).inject(bench.device, JOINT)
    assert shows(bench)
    get_failure(name).heal(bench.device, JOINT)
    # What was disturbed comes back: joint and pressures are driven the other way, and a dump is ended.
    bench.run(1)
    bench.run(1, reset=True)
    bench.run(60, 2.0)
    bench.run(100)
    assert not shows(bench)
    assert device_state(bench) is DeviceState.RUNNING


@pytest.mark.parametrize("name", ["angle-open", "angle-shorted", "pressure-open"])
def test_a_failed_sensor_leaves_the_others_alone(name: str) -> None:
    sound, failed = OpenLoopRig(), OpenLoopRig()
    get_failure(name).inject(failed.device, JOINT)
    for one, other in zip(sound.readings(10), failed.readings(10), strict=True):
        assert one.angles[0] == other.angles[0]
        assert one.pressures[0] == other.pressures[0]
        assert (one.angles[1] == other.angles[1]) == name.startswith("pressure")
        assert (one.pressures[1] == other.pressures[1]) == name.startswith("angle")


def test_sizes_may_be_given() -> None:
    bench = OpenLoopRig()
    get_failure("reply-crc").inject(bench.device, size=2)
    told = bench.run(4)
    assert told[:2] == ["crc", "crc"]
    assert not any(isinstance(one, str) for one in told[2:])
    get_failure("push").inject(bench.device, 0, -0.5)
    assert bench.plant.load == pytest.approx([-0.5 * 84.0, 0.0], rel=0.05)


def test_an_unknown_failure_and_an_unknown_joint_are_told() -> None:
    with pytest.raises(InputError, match="'fire' is not a failure; failures are reply-lost, reply-crc"):
        get_failure("fire")
    with pytest.raises(InputError, match="has no joint 2; joints are 0 to 1"):
        get_failure("push").inject(OpenLoopRig().device, 2)


@pytest.mark.parametrize(
    ("name", "size", "expected"),
    [
        ("stuck-spool", 1.5, "stuck-spool: 1.5 is out of range; give -1 to 1: opening of the valve"),
        ("kinked-hose", float("nan"), "kinked-hose: nan is out of range"),
        ("e-stop", 1.0, "e-stop: 1 was given; it has no size"),
    ],
)
def test_a_size_that_makes_no_sense_is_told(name: str, size: float, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        get_failure(name).inject(OpenLoopRig().device, size=size)


def test_each_says_what_it_does_in_a_line() -> None:
    for one in FAILURES_BY_NAME.values():
        assert 10 < len(one.what) < 70
        assert one.size is None or one.size.unit
