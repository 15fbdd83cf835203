"""A device in C that runs the law, with a virtual rig behind its board, in a process of its own, in real time."""

import ctypes
import multiprocessing
import os
import re
import subprocess
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

import numpy as np

from layflat import load
from layflat.description.change import changed_all
from layflat.export.firmware.station import DEVICE_FOLDER
from layflat.export.targets import EXPORT_TARGETS
from layflat.machine import Machine
from layflat.rig.clock import NS_PER_SECOND, LoopClock, MonotonicClock
from layflat.rig.device.failures import execute_line
from layflat.rig.device.process import DeviceProcess, SerialPort
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import RigCommand
from layflat.rig.wire import Wire
from layflat.sim.plant import SteppedPlant
from layflat.virtual_rig import VirtualRig
from tests.export.firmware.boards import BOARDS, SOURCES, link, require_tools
from tests.export.firmware.controllers import CController, Firmware
from tests.export.firmware.loop_cycles import counts_of

PATIENCE = {
    "interface.serial.timeout": 0.3, "safety.setpoint_age": 0.9, "interface.watchdog_cycles": 100,
    "interface.dump_after": 0.9,
}  # fmt: skip
"""Times of a rig on a computer that does other things, too, s."""

PACE = 5 * NS_PER_SECOND // 1000  # control cycle, ns


def patient_machine(name: str = "paper-arm") -> Machine:
    """Return a machine whose link may take long."""
    return changed_all(load(name), PATIENCE)


class RigBoard:
    """Board of a device whose sensors and valves are those of a virtual rig, and whose line is a file."""

    def __init__(self, machine: Machine, library: Path, line: int) -> None:
        self.rig: VirtualDevice = VirtualRig(machine)(MonotonicClock())
        self.wire, self.line, self.cycle = Wire.for_machine(machine), line, machine.cycle
        self.device = CController(ctypes.CDLL(str(library)), len(machine.joints))
        self._resets = False  # alternates, so that the virtual rig obeys whenever it can
        self._begun = self._due = time.monotonic()

    def step(self) -> None:
        """Sample once a control cycle, step the device, and drive."""
        now, device, bench = time.monotonic(), self.device, self.device.bench
        fresh = now >= self._due
        if fresh:
            self._due = max(self._due + self.cycle, now)
            reading = self.rig.reading()
            bench.open, bench.counts = reading.stopped, counts_of(self.wire, reading)
        bench.time = int(1e6 * (now - self._begun)) & 0xFFFFFFFF
        with suppress(BlockingIOError):
            bench.bytes += os.read(self.line, 4096)
        device.step()
        if bench.sent:
            os.write(self.line, bench.sent)
            bench.sent = b""
        if fresh:
            self._resets = not self._resets
            voltages = np.array([self.wire.voltage.value(count) for count in device.counts()])
            self.rig.obey(RigCommand(voltages, bench.on, self._resets, bench.switched))
        time.sleep(2e-4)


def _serve(machine: Machine, library: Path, pipe: Connection) -> None:
    """Serve the device at a pseudo-terminal until the pipe closes; lines from it act on the virtual rig."""
    near, far = os.openpty()
    tty.setraw(far)
    os.set_blocking(near, False)
    board = RigBoard(machine, library, near)
    pipe.send(os.ttyname(far))
    with suppress(EOFError):
        while True:
            if pipe.poll():
                pipe.send(execute_line(board.rig, pipe.recv().split()))
            board.step()


class ServedController:
    """Process with a device: `with ServedController(machine, library) as served: served.address`."""

    def __init__(self, machine: Machine, library: Path) -> None:
        self._pipe, theirs = multiprocessing.Pipe()
        self._process = multiprocessing.get_context("spawn").Process(
            target=_serve, args=(machine, library, theirs), daemon=True
        )
        self._theirs = theirs
        self.address = ""

    def __enter__(self) -> Self:
        self._process.start()
        self._theirs.close()
        self.address = f"serial://{self._pipe.recv()}"
        return self

    def tell(self, line: str) -> Any:
        """Return the virtual rig's answer to a line, such as "fail e-stop"."""
        self._pipe.send(line)
        return self._pipe.recv()

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._pipe.close()
        self._process.join(5.0)
        self._process.kill()


class PacedDevice(VirtualDevice):
    """Virtual rig for which a control cycle passes with each command, however long it takes."""

    def obey(self, command: RigCommand) -> None:
        self.clock.wait(self.clock.now() + PACE)
        super().obey(command)


def paced_rig(machine: Machine, clock: LoopClock) -> PacedDevice:
    """Return a virtual rig without air."""
    ambient = machine.supply.ambient_pressure
    return PacedDevice(machine, SteppedPlant(machine, pressures=(ambient, ambient)), clock)


class BoardOnPlant(NamedTuple):
    """Simulated board at whose second UART there is a virtual rig."""

    address: str
    rig: DeviceProcess

    def tell(self, line: str) -> Any:
        """Return the virtual rig's answer to a line."""
        return self.rig.call(execute_line, line.split())


@contextmanager
def board_on_plant(machine: Machine, firmware: Firmware, target: str, folder: Path) -> Iterator[BoardOnPlant]:
    """Yield a simulated board with a machine's firmware, which a virtual rig serves as sensors and valves.

    Args:
        machine: the machine.
        firmware: its firmware.
        target: the board's target.
        folder: folder for the program.
    """
    require_tools()
    board = BOARDS[target]
    sources, objects = firmware.write(folder, EXPORT_TARGETS[target])
    for path in (*DEVICE_FOLDER.glob("*.h"), DEVICE_FOLDER / "board_mps2.c"):
        (folder / path.name).write_text(path.read_text())
    image = link(board, [*sources, SOURCES / "plant.c"], objects, folder)
    with DeviceProcess(partial(paced_rig, machine), machine, SerialPort(), lockstep=True) as rig:
        command: list[str | Path] = [
            *board.emulator.replace("-nographic", "-display none").split(),
            "-chardev", "pty,id=host", "-serial", "chardev:host",
            "-chardev", f"serial,id=plant,path={rig.address.removeprefix('serial://')}", "-serial", "chardev:plant",
            "-kernel", image.path,
        ]  # fmt: skip
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            try:
                terminal = re.search(r"/dev/pts/\d+", process.stdout.readline())
                assert terminal is not None
                yield BoardOnPlant(f"serial://{terminal[0]}", rig)
            finally:
                process.kill()
