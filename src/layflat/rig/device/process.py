"""Device in a process of its own, and the handle by which a host starts, calls and ends it."""

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
from layflat.parallel import end_process, start_process
from layflat.rig.clock import LoopClock, MonotonicClock, VirtualClock
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import DriverError
from layflat.rig.system import set_fifo_priority

TICK_INTERVAL = 5e-3  # between two advances of a device in real time, s; each covers the time since the last
START_TIMEOUT = 300.0  # within which a device has to start, s: laws may have to be compiled first, on a busy computer

Factory = Callable[[LoopClock], VirtualDevice]  # creates the device in the process, with its clock


@dataclass(frozen=True)
class ModbusPort:
    """Address at which a Modbus station listens; port 0 is any that is free."""

    port: int = 0
    host: str = "127.0.0.1"


@dataclass(frozen=True)
class SerialPort:
    """Pseudo-terminal, with an optional link to it."""

    link: Path | None = None


Port = ModbusPort | SerialPort


class DeviceProcess:
    """A device in another process: `with DeviceProcess(...) as device: create_driver(device.address, machine)`.

    The factory is pickled. In lockstep time passes there only where a called function waits for the device's clock.
    """

    def __init__(self, factory: Factory, machine: Machine, at: Port, *, lockstep: bool = False) -> None:
        self._control, self._theirs = multiprocessing.Pipe()
        self._arguments = factory, machine, at, self._theirs, lockstep
        self.address = ""

    def __enter__(self) -> Self:
        """Start the process and wait until the device is served; raise LayflatError with its message on failure."""
        self.process = start_process(_serve, self._arguments, "layflat device", daemon=True)
        self._theirs.close()
        if not self._control.poll(START_TIMEOUT):
            self.process.kill()
            raise LayflatError(f"the device did not start within {START_TIMEOUT:g} s; run fewer programs beside it")
        try:
            self.address = self._receive_result()
        except BaseException:
            self.process.join()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        """End the process, gracefully at first; kill it after 2 s."""
        self._control.close()
        end_process(self.process, 2.0)

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call `function(device, *arguments)` in the process and return its result; all of them are pickled.

        Raises:
            LayflatError: the process has ended, or the function raised an error, which is the message.
        """
        with suppress(OSError):
            self._control.send((function, *arguments))
        # If sending failed, a last message may still be there.
        return self._receive_result()

    def _receive_result(self) -> Any:
        """Return the result of a call to the device; raise LayflatError with its message, or if its process is gone."""
        try:
            well, what = self._control.recv()
        except (EOFError, OSError):
            raise LayflatError("the device is gone: its process has ended; start it again") from None
        if not well:
            raise LayflatError(what)
        return what


def _serve(factory: Factory, machine: Machine, at: Port, control: Connection, lockstep: bool) -> None:
    """Serve a device, as the main function of the process, until the handle is closed; send it any error."""
    try:
        device = factory(VirtualClock() if lockstep else MonotonicClock())
        asyncio.run(_run_device(device, machine, at, control, lockstep))
    except Exception as error:
        with suppress(OSError):
            control.send((False, _error_text(error)))


def _error_text(error: Exception) -> str:
    return str(error) if isinstance(error, LayflatError) else f"{type(error).__name__} on the device: {error}"


async def _run_device(device: VirtualDevice, machine: Machine, at: Port, control: Connection, lockstep: bool) -> None:
    """Serve a device at a port until its control pipe closes or SIGTERM arrives, in lockstep or in real time.

    First it sends (True, address) into the pipe. An error in the event loop ends it, and is raised.
    """
    loop: asyncio.AbstractEventLoop = asyncio.get_running_loop()
    done: asyncio.Future[None] = loop.create_future()

    def end(error: BaseException | None = None) -> None:
        if error is not None and not done.done():
            done.set_exception(error)
        elif not done.done():
            done.set_result(None)

    def tick() -> None:
        device.tick()
        loop.call_later(TICK_INTERVAL, tick)

    loop.set_exception_handler(lambda _, context: end(context.get("exception")))
    loop.add_signal_handler(signal.SIGTERM, end)
    # The process with the handle receives the interrupt too, and ends in its own way.
    loop.add_signal_handler(signal.SIGINT, lambda: None)
    address, close = await _open_station(device, machine, at)
    loop.add_reader(control.fileno(), lambda: None if _handle_call(device, control) else end())
    # A garbage collection of all imported modules takes a tenth of a second, without any reply.
    gc.freeze()
    if not lockstep:
        # A real device has a processor of its own.
        with suppress(OSError, AttributeError):
            set_fifo_priority()
        tick()
    try:
        control.send((True, address))
        await done
    finally:
        loop.remove_reader(control.fileno())
        close()


def _handle_call(device: VirtualDevice, control: Connection) -> bool:
    """Perform a call of the handle and send (success, result or message); return False once the handle is closed."""
    try:
        function, *arguments = control.recv()
    except (EOFError, OSError):
        return False
    try:
        answer = True, function(device, *arguments)
    except Exception as error:  # whatever it is, it is the host's to see
        answer = False, _error_text(error)
    with suppress(OSError):
        control.send(answer)
    return True


async def _open_station(device: VirtualDevice, machine: Machine, at: Port) -> tuple[str, Callable[[], None]]:
    """Open a serial or Modbus station for a device; return its address and a function that closes it.

    Raise DriverError if the port can't be used, OutputError if the link to the terminal can't be made.
    """
    if isinstance(at, SerialPort):
        from layflat.rig.device.serial_server import SerialStation  # noqa: PLC0415  (needs an extra)

        terminal = SerialStation(device, machine)
        return f"serial://{terminal.listen(at.link)}", terminal.close
    from layflat.rig.device.modbus_server import ModbusStation  # noqa: PLC0415  (needs an extra)

    station = ModbusStation(device, machine)
    try:
        port = await station.listen(at.host, at.port)
    except (OSError, OverflowError) as error:
        what = f"can't listen here ({getattr(error, 'strerror', None) or error})"
        raise DriverError(
            what, where=f"modbus://{at.host}:{at.port}", right="give a free port, and a host of this computer"
        ) from None
    return f"modbus://{at.host}:{port}", station.close
