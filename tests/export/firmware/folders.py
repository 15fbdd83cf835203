"""Firmware of an exported folder, built as its page tells, on a simulated board."""

import os
import re
import signal
import subprocess
from pathlib import Path

from layflat.machine import Machine
from layflat.rig.drivers.serial import SerialDriver
from layflat.rig.safety.faults import RigState


def check_firmware(folder: Path, machine: Machine) -> None:
    """Build both programs without a warning, and let the first answer its host's driver on a simulated board."""
    built = subprocess.run(["make"], cwd=folder, capture_output=True, text=True, check=False)
    assert (built.returncode, built.stderr) == (0, "")
    assert (folder / "station.elf").exists()
    command = ["make", "-s", "run"]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True, start_new_session=True) as process:
        assert process.stdout is not None
        path = re.search(r"/dev/pts/\d+", process.stdout.readline())
        assert path is not None
        driver = SerialDriver(machine, path[0])
        try:
            driver.configure().check(machine)
            driver.read()
            assert driver.runs_law
            assert driver.status is not None
            assert driver.status.state is RigState.OFF
        finally:
            driver.finalize()
            os.killpg(process.pid, signal.SIGKILL)
