"""Both drivers against devices over TCP and a pseudo-terminal."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from layflat import changed, load
from layflat.machine.model import Machine
from layflat.rig.device.exchange import LATE_REPLY_RATIO
from layflat.rig.device.process import ModbusPort, SerialPort
from layflat.rig.device.virtual import ReplyFault
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Capabilities, Driver, DriverError, Lifecycle, LinkError, RigCommand
from layflat.rig.drivers import create_driver
from layflat.rig.drivers.linked import lock_rig
from layflat.rig.wire import SEQUENCE_MODULUS
from tests.rig.devices import ARM, WIRE, Threaded, angle_after, heal, spoil, truth

FORWARD = RigCommand(np.array([6.0, 5.5]), air=True)


@pytest.fixture(scope="module", params=[ModbusPort(), SerialPort()], ids=["modbus", "serial"])
def device(request: pytest.FixtureRequest) -> Iterator[Threaded]:
    with Threaded(request.param) as running:
        yield running


@pytest.fixture
def driver(device: Threaded) -> Iterator[Driver]:
    device.call(heal)
    found = create_driver(device.address, ARM)
    found.configure()
    found.activate()
    yield found
    device.call(heal)
    found.finalize()


def obeyed(device: Threaded) -> list[RigCommand]:
    commands: list[RigCommand] = device.call(truth)["obeyed"]
    return commands


def test_what_is_there_is_told(device: Threaded) -> None:
    driver = create_driver(device.address, ARM)
    before = len(obeyed(device))
    assert driver.configure() == Capabilities(2, 0.0, 10.0, 5.0, True, 1e-3)
    assert driver.state is Lifecycle.INACTIVE
    driver.finalize()
    assert len(obeyed(device)) == before


def test_a_cycle_gives_the_command_and_takes_the_sensors_exactly(device: Threaded, driver: Driver) -> None:
    before = len(obeyed(device))
    driver.write(FORWARD)
    reading = driver.read()
    sent = obeyed(device)
    assert len(sent) == before + 1
    assert np.abs(sent[-1].voltages - FORWARD.voltages).max() <= WIRE.voltage.lsb / 2
    assert (sent[-1].air, sent[-1].reset) == (True, False)
    assert reading.angles.tolist() == [angle_after(len(sent)), WIRE.angle.low]
    assert reading.pressures.tolist() == [WIRE.pressure.value(4096), WIRE.pressure.value(7)]
    assert (reading.supply, reading.stopped, reading.device) == (WIRE.supply.value(1638), False, DeviceState.CENTRED)


def test_until_something_is_asked_for_it_is_the_centre_without_air(device: Threaded, driver: Driver) -> None:
    driver.read()
    assert obeyed(device)[-1].voltages.tolist() == [5.0, 5.0]
    assert not obeyed(device)[-1].air


def test_who_is_deactivated_centres_and_lets_out_the_air_even_over_bad_wires(device: Threaded, driver: Driver) -> None:
    driver.write(FORWARD)
    driver.read()
    device.call(spoil, ReplyFault.LOST, 2)
    driver.deactivate()
    assert obeyed(device)[-1].voltages.tolist() == [5.0, 5.0]
    assert not obeyed(device)[-1].air
    with pytest.raises(DriverError, match="can't write while inactive"):
        driver.write(FORWARD)
    driver.activate()


@pytest.mark.parametrize(
    ("how", "kind", "heard"),
    [
        (ReplyFault.LOST, "lost", 1),
        (ReplyFault.CRC, "crc", 1),
        (ReplyFault.SEQUENCE, "sequence", 1),
        (ReplyFault.LATE, "lost", 1),
        (None, "lost", 0),
    ],
)
def test_a_bad_reply_is_told_and_the_next_cycle_is_good(
    device: Threaded, driver: Driver, how: ReplyFault | None, kind: str, heard: int
) -> None:
    driver.read()
    before = len(obeyed(device))
    device.call(spoil, how)
    with pytest.raises(LinkError) as error:
        driver.read()
    assert error.value.kind == kind
    assert len(obeyed(device)) == before + heard
    device.call(heal)
    # A late reply comes in the midst of these: none takes it for its own.
    end, more = (
        time.monotonic() + (LATE_REPLY_RATIO * ARM.interface.modbus.timeout if how is ReplyFault.LATE else 0.0),
        0,
    )
    while more < 3 or time.monotonic() < end:
        more += 1
        assert driver.read().angles[0] == angle_after(before + heard + more)
        time.sleep(1e-3)


def test_numbers_of_transactions_go_round(device: Threaded, driver: Driver) -> None:
    driver._sequence = SEQUENCE_MODULUS - 3  # type: ignore[attr-defined]
    fresh = create_driver(device.address, ARM)
    driver.finalize()
    fresh.configure()
    fresh._sequence = SEQUENCE_MODULUS - 3  # type: ignore[attr-defined]
    before = len(obeyed(device))
    for more in range(1, 7):
        assert fresh.read().angles[0] == angle_after(before + more)
    fresh.finalize()


def test_a_command_that_comes_again_is_not_obeyed_again(device: Threaded, driver: Driver) -> None:
    driver.read()
    before = len(obeyed(device))
    driver._sequence -= 1  # type: ignore[attr-defined]
    with suppress(LinkError):
        driver.read()
    assert len(obeyed(device)) == before


def test_two_loops_on_one_rig(device: Threaded, driver: Driver) -> None:
    second = create_driver(device.address, ARM)
    with pytest.raises(DriverError, match=f"is driven by process {os.getpid()} .*end the other first") as error:
        second.configure()
    assert str(error.value).startswith(device.address.split("://")[0])
    assert second.state is Lifecycle.UNCONFIGURED
    driver.read()
    driver.finalize()
    second.configure()
    second.finalize()


def test_a_driver_reads_only_what_it_is_connected_to(device: Threaded) -> None:
    driver = create_driver(device.address, ARM)
    with pytest.raises(DriverError, match="can't read while unconfigured"):
        driver.read()
    driver.finalize()
    driver.finalize()
    with pytest.raises(DriverError, match="finalized"):
        driver.configure()


@pytest.mark.parametrize(
    ("machine", "what"),
    [
        (load("paper-small-joint"), "the rig has 2 joint(s), the machine 'paper-small-joint' 1 joint(s)"),
        (changed(ARM, "valve.volts_to_full", 4.0), "voltages from 0 mV on"),
        (changed(ARM, "angle_sensor.bits", 16), "angles of 12 bits"),
    ],
)
def test_a_machine_that_is_not_this_rig(device: Threaded, machine: Machine, what: str) -> None:
    driver = create_driver(device.address, machine)
    with pytest.raises(DriverError, match=re.escape(what)):
        driver.configure()
    create_driver(device.address, ARM).finalize()


HOLDER = """
import sys
from layflat.rig.drivers.linked import lock_rig
file = lock_rig("modbus://rig:502")
print("held", flush=True)
sys.stdin.read()
"""


def test_one_holder_at_a_time() -> None:
    first = lock_rig("serial:///dev/rig")
    with pytest.raises(DriverError, match="is driven by process"):
        lock_rig("serial:///dev/rig")
    os.close(lock_rig("serial:///dev/other"))
    os.close(first)
    os.close(lock_rig("serial:///dev/rig"))


def test_a_holder_in_another_process_is_named_and_its_death_frees_the_rig() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        with pytest.raises(DriverError, match=f"is driven by process {holder.pid} "):
            lock_rig("modbus://rig:502")
        holder.kill()
    os.close(lock_rig("modbus://rig:502"))


def test_where_no_lock_can_be_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LAYFLAT_RUNTIME_DIR", str(tmp_path / "file"))
    with pytest.raises(DriverError, match="LAYFLAT_RUNTIME_DIR"):
        lock_rig("modbus://rig:502")


def test_locks_lie_in_the_users_runtime_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LAYFLAT_RUNTIME_DIR")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    os.close(lock_rig("modbus://rig:502"))
    assert [path.name for path in (tmp_path / "layflat").iterdir()] == ["modbus-rig-502.lock"]
