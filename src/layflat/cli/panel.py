"""Command that opens the operator's page of a rig: panel."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat import extras
from layflat.cli.app import MachineName, Out, app, naming_options
from layflat.cli.rig import driver_at, stopping
from layflat.errors import LayflatError

if TYPE_CHECKING:
    from layflat.machine import Machine
    from layflat.pages.panel.desk import Rig
    from layflat.rig.device.process import DeviceProcess
    from layflat.rig.driver import Driver

Host = Annotated[str, typer.Option(help="address by which browsers reach this computer")]
PagePort = Annotated[int, typer.Option("--port", min=0, max=65535, help="of the page; 0 is any that is free")]
Certificate = Annotated[Path | None, typer.Option(metavar="FILE", help="PEM, for other addresses than this computer's")]
CertificateKey = Annotated[Path | None, typer.Option("--key", metavar="FILE", help="of the certificate, PEM")]
Browser = Annotated[bool, typer.Option("--browser/--no-browser", help="open the page")]


@app.command()
def panel(
    machine: MachineName,
    driver: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="modbus://HOST:PORT or serial:///dev/NAME; default: a virtual rig"),
    ] = None,
    out: Out = Path("build/panel"),
    port: PagePort = 8080,
    host: Host = "127.0.0.1",
    certificate: Certificate = None,
    key: CertificateKey = None,
    browser: Browser = True,
) -> None:
    """Open a page on which a person runs a machine's rig, real or virtual, until Ctrl-C.

    Logs and sequences are kept in the folder of --out.
    """
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.pages.server.place import Place  # noqa: PLC0415
    from layflat.rig.system import require_posix  # noqa: PLC0415

    require_posix("panel")
    extras.require("panel", where="panel")
    described = load(machine)
    with naming_options({"host": "--host", "port": "--port", "certificate": "--certificate", "key": "--key"}):
        place = Place(host, port, certificate, key)
        with stopping() as stopped, _rig(described, driver) as rig:
            _serve(described, rig, check_folder(out), place, stopped, browser=browser)


def _serve(machine: Machine, rig: Rig, folder: Path, place: Any, stopped: Callable[[], bool], *, browser: bool) -> None:
    from layflat.pages.panel.desk import Desk  # noqa: PLC0415
    from layflat.pages.panel.page import PanelPage  # noqa: PLC0415
    from layflat.pages.server.serve import serve  # noqa: PLC0415

    def ready(link: str) -> None:
        typer.echo(f"{machine.name} at {link}; Ctrl-C ends it")
        if browser and not webbrowser.open(link):
            typer.echo("no browser was found: open the link in one")

    with Desk(machine, rig, folder) as desk:
        serve(lambda: PanelPage(desk), place, title=f"layflat: {machine.name}", ready=ready, stopped=stopped)


@contextmanager
def _rig(machine: Machine, address: str | None) -> Iterator[Rig]:
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

    def __init__(self, machine: Machine) -> None:
        """Take what it is."""
        self._machine = machine
        self._device: DeviceProcess | None = None

    def reached(self, machine: Machine) -> tuple[Callable[[], Driver], str]:
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
        return str(self._device.call(obey, line.split()))

    def close(self) -> None:
        """End it."""
        if self._device is not None:
            self._device.__exit__(None, None, None)

    def _started(self) -> DeviceProcess:
        from layflat.cli.virtual_rig import VirtualRig  # noqa: PLC0415
        from layflat.rig.device.process import DeviceProcess, ModbusPort  # noqa: PLC0415

        return DeviceProcess(VirtualRig(self._machine), self._machine, ModbusPort(0)).__enter__()
