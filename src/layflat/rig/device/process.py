"""A device in a process of its own, and the handle by which a host starts, tells and ends it."""

from __future__ import annotations

import asyncio
import gc
import multiprocessing
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from layflat.errors import LayflatError
from layflat.machine.model import Machine
from layflat.rig.clock import SECOND, Clock, MonotonicClock, VirtualClock
from layflat.rig.device.exchange import Device
from layflat.rig.driver import DriverError
from layflat.rig.realtime import first_in
from layflat.rig.shielded import shielded

TICK = 5e-3
"""Between two looks at the clock in real time, s; a device makes up for what happened between them."""
START = 60.0
"""Until a device has to be there, s: laws may have to be compiled first."""

Factory = Callable[[Clock], Device]
"""Makes the device, inside the process, with the clock that it lives by; it can be pickled."""


@dataclass(frozen=True)
class ModbusPort:
    """Where a Modbus station listens; port 0 is any that is free."""

    port: int = 0
    host: str = "127.0.0.1"


@dataclass(frozen=True)
class SerialPort:
    """A pseudo-terminal, with a second name if one is wanted."""

    link: Path | None = None


def serve(
    factory: Factory,
    machine: Machine,
    at: ModbusPort | SerialPort,
    *,
    control: Connection | None = None,
    lockstep: bool = False,
    ready: Callable[[str], object] = str,
) -> None:
    """Be a device until told to quit, interrupted, or left alone by whoever holds the other end of `control`.

    Args:
        factory: makes the device.
        machine: its description.
        at: the transport.
        control: takes what `DeviceProcess` sends, and answers (whether it went well, what came of it).
        lockstep: whether time passes only while "advance" says so.
        ready: called with the address, as drivers take it, when all is ready.

    Raises:
        DriverError: the port can't be had.
        OutputError: the link can't be made.
    """
    asyncio.run(_Serving(factory, machine, control, lockstep).run(at, ready))


class _Serving:
    def __init__(self, factory: Factory, machine: Machine, control: Connection | None, lockstep: bool) -> None:
        self._clock: Clock = VirtualClock() if lockstep else MonotonicClock()
        self._device = factory(self._clock)
        self._machine, self._control, self._lockstep = machine, control, lockstep

    async def run(self, at: ModbusPort | SerialPort, ready: Callable[[str], object]) -> None:
        self._done = asyncio.Event()
        self._failed: BaseException | None = None
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(self._fail)
        loop.add_signal_handler(signal.SIGTERM, self._done.set)
        # Who holds the other end hears an interrupt too, and quits in its own way.
        loop.add_signal_handler(signal.SIGINT, self._done.set if self._control is None else lambda: None)
        address, close = await self._listen(at)
        if self._control is not None:
            loop.add_reader(self._control.fileno(), self._hear, self._control)
        # To look through all that was imported takes a tenth of a second, for which nobody would be answered.
        gc.freeze()
        if not self._lockstep:
            # What it stands for has a processor to itself.
            with suppress(OSError, AttributeError):
                first_in()
            self._tick()
        try:
            ready(address)
            await self._done.wait()
        finally:
            close()
            gc.unfreeze()
        if self._failed is not None:
            raise self._failed

    def _tick(self) -> None:
        self._device.tick()
        asyncio.get_running_loop().call_later(TICK, self._tick)

    def _fail(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:  # noqa: ARG002  (as asyncio calls)
        self._failed = context.get("exception")
        self._done.set()

    async def _listen(self, at: ModbusPort | SerialPort) -> tuple[str, Callable[[], None]]:
        if isinstance(at, SerialPort):
            from layflat.rig.device.serial_server import SerialStation  # noqa: PLC0415  (needs an extra)

            terminal = SerialStation(self._device, self._machine)
            return f"serial://{terminal.listen(at.link)}", terminal.close
        from layflat.rig.device.modbus_server import ModbusStation  # noqa: PLC0415  (needs an extra)

        station = ModbusStation(self._device, self._machine, lambda: self._clock.now() / SECOND)
        try:
            port = await station.listen(at.host, at.port)
        except (OSError, OverflowError) as error:
            what = getattr(error, "strerror", None) or str(error)
            raise DriverError(
                f"can't be listened at ({what})", where=f"modbus://{at.host}:{at.port}", right="give another port"
            ) from None
        return f"modbus://{at.host}:{port}", station.close

    def _hear(self, control: Connection) -> None:
        try:
            name, *arguments = control.recv()
        except (EOFError, OSError):
            self._done.set()
            asyncio.get_running_loop().remove_reader(control.fileno())
            return
        try:
            answer = True, self._do(name, arguments)
        except Exception as error:  # whatever it is, it is the host's to see
            answer = False, _told(error)
        with suppress(OSError):
            control.send(answer)

    def _do(self, name: str, arguments: list[Any]) -> Any:
        match name:
            case "quit":
                self._done.set()
                return None
            case "advance":
                (until,) = arguments
                self._clock.wait(until)
                self._device.tick()
                return self._clock.now()
            case _:
                function, *others = arguments
                return function(self._device, *others)


def _process(factory: Factory, machine: Machine, at: ModbusPort | SerialPort, control: Connection, lock: bool) -> None:
    try:
        serve(factory, machine, at, control=control, lockstep=lock, ready=lambda where: control.send((True, where)))
    except Exception as error:
        with suppress(OSError):
            control.send((False, _told(error)))


def _told(error: Exception) -> str:
    return str(error) if isinstance(error, LayflatError) else f"{type(error).__name__} on the device: {error}"


class DeviceProcess:
    """A device in another process: `with DeviceProcess(...) as device: driver_of(device.address, machine)`.

    Args:
        factory: makes the device, in the other process.
        machine: its description.
        at: the transport.
        lockstep: whether time passes there only with `advance`.
    """

    def __init__(
        self, factory: Factory, machine: Machine, at: ModbusPort | SerialPort, *, lockstep: bool = False
    ) -> None:
        context = multiprocessing.get_context("spawn")
        self._control, theirs = context.Pipe()
        self._process = context.Process(
            target=_process, args=(factory, machine, at, theirs, lockstep), name="layflat device", daemon=True
        )
        self._theirs = theirs
        self.address = ""

    def __enter__(self) -> Self:
        """Start it, and wait until it can be reached.

        Raises:
            LayflatError: it can't; the message is that of the other process.
        """
        with shielded():
            self._process.start()
        self._theirs.close()
        if not self._control.poll(START):
            self._process.kill()
            raise LayflatError(f"the device was not there after {START:g} s")
        try:
            self.address = self._answer()
        except BaseException:
            self._process.join()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End it, kindly at first."""
        with suppress(OSError):
            self._control.send(("quit",))
        self._process.join(2.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._control.close()

    @property
    def pid(self) -> int:
        """Of the other process."""
        assert self._process.pid is not None
        return self._process.pid

    @property
    def sentinel(self) -> int:
        """A handle that `select` finds ready once the other process is gone."""
        return self._process.sentinel

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function over there: `function(device, *arguments)`; it stands in a module, so that it can be sent.

        Raises:
            LayflatError: the device is gone, or the function raised what the message says.
        """
        return self._ask("call", function, *arguments)

    def advance(self, until: int) -> int:
        """In lockstep: let time pass up to an instant (ns); returns the instant reached."""
        reached: int = self._ask("advance", until)
        return reached

    def _ask(self, *message: Any) -> Any:
        with suppress(OSError):
            self._control.send(message)
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
