from __future__ import annotations

import os
import signal
import socket
import time
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import LayflatError
from layflat.rig.clock import LoopClock
from layflat.rig.device.process import DeviceProcess, ModbusPort, SerialPort
from layflat.rig.driver import RigCommand
from layflat.rig.drivers import create_driver
from tests.rig.devices import ARM, FakeDevice, advance, angle_after, burst, device_process, frozen, patient, truth

PATIENT = patient(ARM, 5.0)


class Stuck(FakeDevice):
    """A device whose plant diverges as time passes."""

    def __init__(self, clock: LoopClock) -> None:
        super().__init__(clock)
        self.began = clock.now()

    def tick(self) -> None:
        if self.clock.now() > self.began + 200_000_000:
            raise LayflatError("the run diverged")


def test_in_lockstep_time_passes_when_told(tmp_path: Path) -> None:
    with device_process(SerialPort(tmp_path / "rig")) as device:
        assert device.address == f"serial://{tmp_path / 'rig'}"
        driver = create_driver(device.address, PATIENT)
        driver.configure()
        driver.activate()
        for cycle in range(1, 4):
            assert device.call(advance, cycle * 5_000_000) == cycle * 5_000_000
            driver.write(RigCommand(np.array([5.0, 5.0]), air=True))
            assert driver.read().angles[0] == angle_after(cycle)
        found = device.call(truth)
        assert (found["ticks"], found["now"]) == (3, 15_000_000)
        assert device.call(frozen) > 10_000, "a collection of all that was imported would stop it for 100 ms"
        with pytest.raises(LayflatError, match="ZeroDivisionError on the device: no such hose"):
            device.call(burst)
        driver.read()
        driver.finalize()
    assert not device.process.is_alive()
    assert not (tmp_path / "rig").is_symlink()


def test_in_real_time_it_ticks_by_itself_and_a_failure_ends_it() -> None:
    with device_process(ModbusPort(), lockstep=False) as device:
        driver = create_driver(device.address, PATIENT)
        driver.configure()
        driver.activate()
        assert driver.read().angles[0] == angle_after(1)
        driver.finalize()
        one = device.call(truth)
        time.sleep(0.2)
        other = device.call(truth)
        assert other["now"] - one["now"] >= 200_000_000
        assert other["ticks"] > one["ticks"]
        assert device.process.pid is not None
        os.kill(device.process.pid, signal.SIGINT)
        assert device.call(truth)["ticks"] >= other["ticks"], "an interrupt is for who holds the handle"
        device._control.close()
        device.process.join(10.0)
        assert device.process.exitcode == 0, "it ends with whoever holds the handle"
    with DeviceProcess(Stuck, ARM, ModbusPort()) as device:
        device.process.join(10.0)
        assert not device.process.is_alive()
        with pytest.raises(LayflatError, match="the run diverged"):
            device.call(truth)
        with pytest.raises(LayflatError, match="the device is gone"):
            device.call(truth)


def test_a_port_that_is_taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        what = f"modbus://127.0.0.1:{port}: can't listen here .*give a free port"
        with pytest.raises(LayflatError, match=what), device_process(ModbusPort(port)):
            pass


def test_who_is_terminated_leaves_nothing_behind() -> None:
    with device_process(SerialPort()) as device:
        assert device.address.startswith("serial:///dev/")
        assert device.process.pid is not None
        os.kill(device.process.pid, signal.SIGTERM)
        device.process.join(10.0)
        assert device.process.exitcode == 0
    assert not Path(device.address.removeprefix("serial://")).exists()


def test_noise_on_the_line_is_not_told(capfd: pytest.CaptureFixture[str]) -> None:
    noise = np.random.default_rng(0)
    with device_process(ModbusPort()) as device:
        port = int(device.address.rpartition(":")[2])
        for _ in range(20):
            with socket.create_connection(("127.0.0.1", port), timeout=5.0) as line:
                line.sendall(noise.bytes(400))
        driver = create_driver(device.address, PATIENT)
        driver.configure()
        driver.finalize()
    assert capfd.readouterr().err == ""
