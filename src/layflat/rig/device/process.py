"""A device in a process of its own, and the handle by which a host starts, tells and ends it."""

import asyncio
import gc
import multiprocessing
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Self

from layflat.errors import LayflatError
from layflat.machine.model import Machine
from layflat.parallel import start_process
from layflat.rig.clock import Clock, MonotonicClock, VirtualClock
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import DriverError
from layflat.rig.system import first_in

TICK = 5e-3  # between two looks at the clock in real time, s; a device makes up for what happened between them
START = 300.0  # until a device has to be there, s: laws may have to be compiled first, on a busy computer

Factory = Callable[[Clock], VirtualDevice]  # makes the device in the process, with the clock that it lives by


@dataclass(frozen=True)
class ModbusPort:
    """Where a Modbus station listens; port 0 is any that is free."""

    port: int = 0
    host: str = "127.0.0.1"


@dataclass(frozen=True)
class SerialPort:
    """A pseudo-terminal, with a second name if one is wanted."""

    link: Path | None = None


Port = ModbusPort | SerialPort


class DeviceProcess:
    """A device in another process: `with DeviceProcess(...) as device: driver_of(device.address, machine)`.

    The factory is pickled. In lockstep time passes there only where a called function waits for the device's clock.
    """

    def __init__(self, factory: Factory, machine: Machine, at: Port, *, lockstep: bool = False) -> None:
        self._control, self._theirs = multiprocessing.Pipe()
        self._arguments = factory, machine, at, self._theirs, lockstep
        self.address = ""

    def __enter__(self) -> Self:
        """Start it, and wait until it can be reached; raise LayflatError with the other process's message if not."""
        self.process = start_process(_serve, self._arguments, "layflat device", daemon=True)
        self._theirs.close()
        if not self._control.poll(START):
            self.process.kill()
            raise LayflatError(f"the device was not there after {START:g} s")
        try:
            self.address = self._answer()
        except BaseException:
            self.process.join()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        """End it, kindly at first."""
        self._control.close()
        self.process.join(2.0)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function over there: `function(device, *arguments)`; it stands in a module, so that it can be sent.

        Raise LayflatError if the device is gone, or the function raised what the message says.
        """
        with suppress(OSError):
            self._control.send((function, *arguments))
        # Where that failed there may still be a last word.
        return self._answer()

    def _answer(self) -> Any:
        try:
            well, what = self._control.recv()
        except (EOFError, OSError):
            raise LayflatError("the device is gone") from None
        if not well:
            raise LayflatError(what)
        return what


def _serve(factory: Factory, machine: Machine, at: Port, control: Connection, lockstep: bool) -> None:
    """Main function of the process: be a device until left alone by whoever holds the handle."""
    try:
        device = factory(VirtualClock() if lockstep else MonotonicClock())
        asyncio.run(_be(device, machine, at, control, lockstep))
    except Exception as error:
        with suppress(OSError):
            control.send((False, _told(error)))


def _told(error: Exception) -> str:
    return str(error) if isinstance(error, LayflatError) else f"{type(error).__name__} on the device: {error}"


async def _be(device: VirtualDevice, machine: Machine, at: Port, control: Connection, lockstep: bool) -> None:
    loop: asyncio.AbstractEventLoop = asyncio.get_running_loop()
    done: asyncio.Future[None] = loop.create_future()

    def end(error: BaseException | None = None) -> None:
        if error is not None and not done.done():
            done.set_exception(error)
        elif not done.done():
            done.set_result(None)

    def tick() -> None:
        device.tick()
        loop.call_later(TICK, tick)

    loop.set_exception_handler(lambda _, context: end(context.get("exception")))
    loop.add_signal_handler(signal.SIGTERM, end)
    # Who holds the handle hears an interrupt too, and quits in its own way.
    loop.add_signal_handler(signal.SIGINT, lambda: None)
    address, close = await _listen(device, machine, at)
    loop.add_reader(control.fileno(), lambda: None if _hear(device, control) else end())
    # To look through all that was imported takes a tenth of a second, for which nobody would be answered.
    gc.freeze()
    if not lockstep:
        # What it stands for has a processor to itself.
        with suppress(OSError, AttributeError):
            first_in()
        tick()
    try:
        control.send((True, address))
        await done
    finally:
        loop.remove_reader(control.fileno())
        close()


def _hear(device: VirtualDevice, control: Connection) -> bool:
    """Call what the handle sends, and answer whether it went well, and what came of it; false: it was let go."""
    try:
        function, *arguments = control.recv()
    except (EOFError, OSError):
        return False
    try:
        answer = True, function(device, *arguments)
    except Exception as error:  # whatever it is, it is the host's to see
        answer = False, _told(error)
    with suppress(OSError):
        control.send(answer)
    return True


async def _listen(device: VirtualDevice, machine: Machine, at: Port) -> tuple[str, Callable[[], None]]:
    if isinstance(at, SerialPort):
        from layflat.rig.device.serial_server import SerialStation  # noqa: PLC0415  (needs an extra)

        terminal = SerialStation(device, machine)
        return f"serial://{terminal.listen(at.link)}", terminal.close
    from layflat.rig.device.modbus_server import ModbusStation  # noqa: PLC0415  (needs an extra)

    station = ModbusStation(device, machine)
    try:
        port = await station.listen(at.host, at.port)
    except (OSError, OverflowError) as error:
        what = f"can't be listened at ({getattr(error, 'strerror', None) or error})"
        raise DriverError(what, where=f"modbus://{at.host}:{at.port}", right="give another port") from None
    return f"modbus://{at.host}:{port}", station.close
