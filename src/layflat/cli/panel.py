"""Command that opens the operator's page of a rig: panel."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat import extras
from layflat.cli.app import MachineName, Out, app, expanded
from layflat.cli.pages import PageOptions
from layflat.cli.rig import driver_at, stopping
from layflat.errors import LayflatError

if TYPE_CHECKING:
    from layflat.machine import Machine
    from layflat.pages.panel.desk import Rig
    from layflat.rig.device.process import DeviceProcess
    from layflat.rig.driver import Driver


@app.command()
@expanded
def panel(
    machine: MachineName,
    page: PageOptions,
    driver: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="modbus://HOST:PORT or serial:///dev/NAME; default: a virtual rig"),
    ] = None,
    out: Out = Path("build/panel"),
) -> None:
    """Open a page on which a person runs a machine's rig, real or virtual, until Ctrl-C.

    Logs and sequences are kept in the folder of --out.
    """
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.rig.system import require_posix  # noqa: PLC0415

    require_posix("panel")
    extras.require("panel", where="panel")
    described, place = load(machine), page.place()
    with stopping() as stopped, _rig(described, driver) as rig:
        from layflat.pages.panel.desk import Desk  # noqa: PLC0415
        from layflat.pages.panel.page import panel_page  # noqa: PLC0415  # it needs the extra

        with Desk(described, rig, check_folder(out)) as desk:
            page.serve(lambda: panel_page(desk), place, described, stopped, idle=lambda: desk.link.at_rest)


@contextmanager
def _rig(machine: "Machine", address: str | None) -> "Iterator[Rig]":
    """The rig of an address, or a virtual one of our own."""
    from layflat.pages.panel.desk import Rig  # noqa: PLC0415

    if address is not None:
        driver_at(address, machine)
        yield Rig(lambda described: driver_at(address, described), address)
        return
    own = VirtualBench(machine)
    try:
        yield Rig(own.reached, "a virtual rig", own.tell)
    finally:
        own.close()


class VirtualBench:
    """A virtual rig in a process of its own, started when it is first needed, and anew where it is gone."""

    def __init__(self, machine: "Machine") -> None:
        """Take what it is."""
        self._machine = machine
        self._device: DeviceProcess | None = None
        self._guard = threading.Lock()  # of words to the device, which pages may give at the same time

    def reached(self, machine: "Machine") -> "tuple[Callable[[], Driver], str]":
        """Return what makes its driver for a machine whose controller may be another, and its address."""
        if self._device is None or not self._device.process.is_alive():
            self._device = self._started()
        factory, _ = driver_at(self._device.address, machine)
        return factory, self._device.address

    def tell(self, line: str) -> str:
        """Let it do what a line says, such as "fail e-stop", and return its answer.

        Raises:
            LayflatError: it makes no sense, or the rig is gone.
        """
        from layflat.rig.device.console import obey  # noqa: PLC0415

        if self._device is None:
            raise LayflatError("the virtual rig is not there yet")
        with self._guard:
            return str(self._device.call(obey, line.split()))

    def close(self) -> None:
        """End it."""
        if self._device is not None:
            self._device.__exit__(None, None, None)

    def _started(self) -> "DeviceProcess":
        from layflat.cli.virtual_rig import VirtualRig  # noqa: PLC0415
        from layflat.rig.device.process import DeviceProcess, ModbusPort  # noqa: PLC0415

        return DeviceProcess(VirtualRig(self._machine), self._machine, ModbusPort(0)).__enter__()
