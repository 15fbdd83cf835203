"""Checks of a virtual rig in simulated time: a sound one passes, and what is wired wrongly is told."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.rig.check import check_rig, estimate_noise
from layflat.rig.clock import VirtualClock
from layflat.rig.device.failures import get_failure
from layflat.rig.device.virtual import SimulatedDriver
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Capabilities, Lifecycle, RigCommand, SensorReading
from layflat.rig.open_loop import CheckResult
from layflat.virtual_rig import VirtualRig

ARM = load("paper-arm")
CENTRE = 5.0


class Wired(SimulatedDriver):
    """A virtual rig with something wrong about its wires; it notes how far the joints went."""

    def __init__(self, machine: str = "paper-arm") -> None:
        self.clock = VirtualClock()
        self.machine = load(machine)
        super().__init__(VirtualRig(self.machine)(self.clock))
        n = len(self.machine.joints)
        self.signs = {"valve": np.ones(n), "angle": np.ones(n), "pressure": np.ones(n)}
        self.order = list(range(n))
        self.breaks: tuple[float, Callable[[], None]] = (1e9, lambda: None)
        self.reached = self.pressed = 0.0

    def read(self) -> SensorReading:
        if self.clock.now() > self.breaks[0] * 1e9:
            begin, self.breaks = self.breaks[1], (1e9, lambda: None)
            begin()
        reading = super().read()
        self.reached = max(self.reached, np.degrees(np.abs(self.device.plant.angles)).max())
        self.pressed = max(self.pressed, self.device.line.pressure)
        return reading._replace(
            angles=self.signs["angle"] * reading.angles, pressures=self.signs["pressure"] * reading.pressures
        )

    def write(self, command: RigCommand) -> None:
        volts = CENTRE + self.signs["valve"] * (command.voltages - CENTRE)
        super().write(command._replace(voltages=volts[self.order]))


def checked(driver: Wired, *, air: bool = True) -> dict[str, CheckResult]:
    found = check_rig(driver.machine, driver, driver.clock, air=air)
    assert driver.state is Lifecycle.FINALIZED
    return {one.what: one for one in found}


def wrong(found: dict[str, CheckResult]) -> dict[str, str]:
    return {one.what: one.action for one in found.values() if not one.has_passed}


def test_a_sound_rig_passes_and_is_left_without_air() -> None:
    driver = Wired()
    found = checked(driver)
    assert wrong(found) == {}
    assert {"air", "signs of large", "signs of small", "e-stop", "angle of large", "pressure of small"} <= set(found)
    assert 1.5 < driver.reached < 12.0
    assert not driver.device.line.air
    assert driver.device.plant.pressures.max() < ARM.supply.ambient_pressure + 0.2e5


@pytest.mark.parametrize(
    ("part", "what", "right"),
    [
        ("", "", ""),
        ("valve", "ended early", "joint 'small': moves though its valve vents its hose"),
        ("angle", "signs of small", "its angle sensor goes the wrong way"),
        ("pressure", "signs of small", "its pressure sensor goes the wrong way"),
    ],
)
def test_a_single_hose_is_checked_from_its_exhaust(part: str, what: str, right: str) -> None:
    driver = Wired("single-joint-lift")
    if part:
        driver.signs[part][0] = -1.0
    found = checked(driver)
    assert [name for name, one in found.items() if not one.has_passed] == [what][: len(part)]
    if part:
        assert right in found[what].finding + found[what].action
    assert np.degrees(driver.device.plant.angles[0]) < -50.0  # it does not rise on the leaks of its valve
    assert driver.device.plant.pressures.max() < ARM.supply.ambient_pressure + 0.2e5


def test_without_air_nothing_is_moved() -> None:
    driver = Wired()
    assert wrong(checked(driver, air=False)) == {}
    assert driver.pressed == ARM.supply.ambient_pressure
    assert driver.device.state is DeviceState.DUMPED


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize(
    ("part", "right"),
    [
        ("valve", "its valve goes the wrong way"),
        ("angle", "its angle sensor goes the wrong way"),
        ("pressure", "its pressure sensor goes the wrong way"),
    ],
)
def test_a_wrong_sign_is_told_of_that_joint(part: str, joint: int, right: str) -> None:
    driver = Wired()
    driver.signs[part][joint] = -1.0
    found = wrong(checked(driver))
    assert list(found) == [f"signs of {list(ARM.joints)[joint]}"]
    assert right in next(iter(found.values()))
    assert driver.reached < 12.0


def test_swapped_valves_are_told() -> None:
    driver = Wired()
    driver.order = [1, 0]
    found = wrong(checked(driver))
    assert "its valve moves small" in found["signs of large"]
    assert "its valve moves large" in found["signs of small"]


@pytest.mark.parametrize(
    ("name", "joint", "what", "right"),
    [
        ("angle-shorted", 1, "angle of small", "open or shorted"),
        ("pressure-open", 0, "pressure of large", "at its rail"),
        ("angle-frozen", 0, "angle of large", "it repeats itself"),
        ("pressure-frozen", 1, "pressure of small", "it repeats itself"),
        ("e-stop", 0, "e-stop", "release it"),
    ],
)
def test_what_is_wrong_without_air_keeps_the_air_off(name: str, joint: int, what: str, right: str) -> None:
    driver = Wired()
    get_failure(name).inject(driver.device, joint)
    found = wrong(checked(driver))
    assert set(found) == {what, "air"}
    assert right in found[what]
    assert driver.pressed == ARM.supply.ambient_pressure


def test_a_line_with_air_in_it_is_told() -> None:
    driver = Wired()
    driver.device = VirtualRig(ARM, filled=True)(driver.clock)
    take = driver.device.reading

    def offset() -> SensorReading:
        return take()._replace(supply=ARM.supply.ambient_pressure + 0.4e5)

    driver.device.reading = offset  # type: ignore[method-assign]
    assert "shut off the air" in wrong(checked(driver))["supply"]


@pytest.mark.parametrize(
    ("name", "size", "what", "right"),
    [("supply-lost", None, "air", "look at compressor"), ("kinked-hose", 0.0, "signs of large", "nothing stirs")],
)
def test_what_is_wrong_with_air(name: str, size: float | None, what: str, right: str) -> None:
    driver = Wired()
    get_failure(name).inject(driver.device, 0, size)
    assert right in wrong(checked(driver))[what]


@pytest.mark.parametrize(
    ("after", "name", "right"),
    [(4.2, "e-stop", "e-stop"), (4.2, "silence", "link lost"), (5.0, "angle-open", "open or shorted")],
)
def test_what_happens_with_air_ends_the_check(after: float, name: str, right: str) -> None:
    driver = Wired()
    driver.breaks = (after, lambda: get_failure(name).inject(driver.device, 0))
    found = checked(driver)
    assert right in found["ended early"].finding
    assert "signs of small" not in found


def test_an_interrupt_lets_the_air_out() -> None:
    driver = Wired()

    def interrupt() -> None:
        raise KeyboardInterrupt

    driver.breaks = (4.5, interrupt)
    with pytest.raises(KeyboardInterrupt):
        checked(driver)
    assert driver.pressed > 4e5
    assert driver.device.plant.pressures.max() < ARM.supply.ambient_pressure + 0.2e5


def test_a_rig_of_another_size_is_refused() -> None:
    driver = Wired()
    driver._configure = lambda: Capabilities(1, 0.0, 10.0, 5.0, True, 1e-3)  # type: ignore[method-assign]
    with pytest.raises(InputError, match="it has 1 joints, the machine 2"):
        check_rig(ARM, driver, driver.clock)


@pytest.mark.parametrize(
    ("noise", "told"),
    [("0.009 deg", ""), ("0.002 deg", "less noise than described, so that it would be taken for frozen at rest")],
)
def test_an_angle_that_is_told_by_its_noise_to_live_has_to_have_it(noise: str, told: str) -> None:
    described, clock = load("picking-arm"), VirtualClock()
    driver = SimulatedDriver(VirtualRig(changed(described, "angle_sensor.noise", noise))(clock))
    found = {one.what: one.action for one in check_rig(described, driver, clock)}
    assert [found[f"angle of {name}"].partition(":")[0] for name in described.joints] == [told] * 4


@pytest.mark.parametrize("count", [1e-9, 0.5, 3.0])
def test_noise_is_told_from_a_motion_and_a_jolt(count: float) -> None:
    draw, time = np.random.default_rng(5), 0.005 * np.arange(400)
    samples = -4.0 * np.minimum(time, 1.1) ** 2 + np.where(time > 1.1, 0.05 * np.sin(300.0 * time), 0.0) * (time < 1.2)
    samples = count * np.round((samples + 1.0 * draw.standard_normal(400)) / count)
    assert estimate_noise(samples) == pytest.approx(np.hypot(1.0, count / np.sqrt(12.0)), rel=0.15)
    assert estimate_noise(samples[:2]) == estimate_noise(np.full(400, 0.3)) == 0.0
