"""Command that runs a virtual rig."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from select import select
from typing import TYPE_CHECKING, Annotated

import typer

from layflat import extras
from layflat.cli.bars import COMPILING_TEXT, busy
from layflat.cli.common import MachineName
from layflat.cli.groups import rigs
from layflat.cli.rig import stopping
from layflat.errors import InputError, LayflatError
from layflat.virtual_rig import VirtualRig

if TYPE_CHECKING:
    from layflat.rig.device.process import DeviceProcess, Port

STOP_POLL_INTERVAL = 0.1  # between two checks whether to end, s


@rigs.register("serve", "paper-arm --modbus 5020", "paper-arm --serial --link /tmp/rig")
def serve(
    machine: MachineName,
    modbus: Annotated[int | None, typer.Option(metavar="PORT", help="Modbus TCP; 0 is any port that is free")] = None,
    serial: Annotated[bool, typer.Option("--serial", help="a pseudo-terminal")] = False,
    link: Annotated[Path | None, typer.Option(metavar="PATH", help="a second name for the pseudo-terminal")] = None,
    seed: Annotated[int, typer.Option(help="of the sensors' noise")] = 0,
) -> None:
    """Run a virtual rig that speaks the real protocol, until Ctrl-C.

    Lines on stdin: fail NAME [JOINT] [SIZE], heal NAME [JOINT], state, failures, quit.
    """
    from layflat.machine import load  # noqa: PLC0415
    from layflat.rig.device.process import DeviceProcess  # noqa: PLC0415

    described = load(machine)
    at = _device_port(modbus, serial or link is not None, link)
    with stopping() as stopped, ExitStack() as stack:
        with busy(f"starting {COMPILING_TEXT}"):
            device = stack.enter_context(DeviceProcess(VirtualRig(described, seed), described, at))
        typer.echo(f"{described.name} at {device.address}")
        sys.stdout.flush()
        _answer(device, stopped)


def _device_port(modbus: int | None, serial: bool, link: Path | None) -> "Port":
    """Return the port of a virtual rig; raise InputError unless exactly one of Modbus (TCP port) and serial is set."""
    from layflat.rig.device.process import ModbusPort, SerialPort  # noqa: PLC0415
    from layflat.rig.drivers import PROTOCOL_PACKAGES  # noqa: PLC0415
    from layflat.rig.system import require_posix  # noqa: PLC0415

    if (modbus is None) is not serial:
        raise InputError("give one of both", where="--modbus, --serial", right="for example --modbus 5020")
    require_posix("rig serve")
    extras.require("rig", *PROTOCOL_PACKAGES["serial" if modbus is None else "modbus"], where="rig serve")
    return SerialPort(link) if modbus is None else ModbusPort(modbus)


def _answer(device: "DeviceProcess", stopped: Callable[[], bool]) -> None:
    """Execute commands from stdin until `quit` or `stopped`; raise LayflatError if the device is gone."""
    from layflat.rig.device.failures import execute_line  # noqa: PLC0415

    for words in _lines(device, stopped):
        if words == ["quit"]:
            return
        try:
            typer.echo(device.call(execute_line, words))
        except LayflatError as error:
            typer.echo(f"layflat: {error}", err=True)
        sys.stdout.flush()
    if not stopped():
        raise LayflatError("the process of the virtual rig has ended: start it again")


def _lines(device: "DeviceProcess", stopped: Callable[[], bool]) -> Iterator[list[str]]:
    """Yield the words of each line of stdin; return once the device ends or `stopped` is true, not at its end."""
    source = [sys.stdin.fileno()] if sys.stdin is not None and not sys.stdin.closed else []
    rest = b""
    while not stopped():
        ready, _, _ = select([*source, device.process.sentinel], [], [], STOP_POLL_INTERVAL)
        if device.process.sentinel in ready:
            return
        if not ready:
            continue
        data = os.read(source[0], 4096)
        if not data:
            source = []
        *whole, rest = (rest + (data or b"\n")).split(b"\n")
        yield from (words for line in whole if (words := line.decode(errors="replace").split()))
