"""Commands that open a page in the browser: panel, for a rig's operator, and studio, to design; what they share."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat import extras
from layflat.cli.common import MACHINE_HELP, MachineName, Out, expanded, naming_options
from layflat.cli.completers import complete_name
from layflat.cli.foxglove import FoxglovePort, showing_in_foxglove
from layflat.cli.groups import app
from layflat.cli.rig import driver_at, stopping
from layflat.errors import LayflatError
from layflat.virtual_rig import VirtualRig

if TYPE_CHECKING:
    from layflat.machine import Machine
    from layflat.pages.panel.desk import PanelRig
    from layflat.pages.server.place import Endpoint
    from layflat.rig.device.process import DeviceProcess
    from layflat.rig.driver import Driver


OPTIONS = {name: f"--{name}" for name in ("host", "port", "certificate", "key")}


@dataclass(frozen=True)
class PageOptions:
    """Options about the page of a command (see `expanded`)."""

    port: Annotated[int, typer.Option(min=0, max=65535, help="of the page; 0 is any that is free")] = 8080
    host: Annotated[str, typer.Option(help="address by which browsers reach this computer")] = "127.0.0.1"
    certificate: Annotated[
        Path | None, typer.Option(metavar="FILE", help="PEM, for other addresses than this computer's")
    ] = None
    key: Annotated[Path | None, typer.Option(metavar="FILE", help="of the certificate, PEM")] = None
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="open the page")] = True

    @property
    def changed_option(self) -> str:
        """First option that is not at its default; "" where all are."""
        others = (one.name for one in fields(self) if getattr(self, one.name) != one.default)
        return next((OPTIONS.get(name, "--no-browser") for name in others), "")

    def endpoint(self) -> "Endpoint":
        """Return the endpoint of the page; raise InputError naming the option if it can't be used."""
        from layflat.pages.server.place import Endpoint  # noqa: PLC0415

        with naming_options(OPTIONS):
            return Endpoint(self.host, self.port, self.certificate, self.key)

    def serve(
        self,
        root: Callable[[], object],
        place: "Endpoint",
        machine: "Machine",
        stopped: Callable[[], bool],
        **more: Any,
    ) -> None:
        """Serve the page of a machine, print its link, and open it in a browser.

        Args:
            root: builds the page of a browser tab.
            place: endpoint of the page.
            machine: machine that the page shows.
            stopped: True ends the server.
            more: further arguments of `layflat.pages.server.serve`.
        """
        from layflat.pages.server.serve import serve  # noqa: PLC0415

        def ready(link: str) -> None:
            self.announce(machine.name, link)

        with naming_options(OPTIONS):
            serve(root, place, title=f"layflat: {machine.name}", ready=ready, stopped=stopped, **more)

    def announce(self, name: str, link: str) -> None:
        """Print the link of a page, and open it in a browser."""
        import webbrowser  # noqa: PLC0415  # the list of commands needs none

        print_link(name, link)
        if self.browser and not webbrowser.open(link):
            typer.echo("no browser was found: open the link in one")


def print_link(name: str, link: str) -> None:
    """Print the link of a page, alone on its line, so that the line can be copied."""
    typer.echo(f"{name} is at the link below; Ctrl-C ends it")
    typer.echo(link)


@app.register("panel", "paper-arm", "mine.toml --driver modbus://192.168.1.10:502")
@expanded
def open_panel(
    machine: MachineName,
    page: PageOptions,
    driver: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="modbus://HOST:PORT or serial:///dev/NAME; default: a virtual rig"),
    ] = None,
    foxglove: FoxglovePort = None,
    out: Out = Path("build/panel"),
) -> None:
    """Open the page on which an operator runs a rig.

    The rig is real or virtual. Ctrl-C ends the page, stops the rig and vents its air. Logs and sequences are kept in
    the folder of --out.
    """
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.rig.system import require_posix  # noqa: PLC0415

    require_posix("panel")
    extras.require("panel", where="panel")
    described, place = load(machine), page.endpoint()
    with stopping() as stopped, showing_in_foxglove(described, foxglove) as show, _rig(described, driver) as rig:
        from layflat.pages.panel.desk import Desk  # noqa: PLC0415
        from layflat.pages.panel.page import panel_page  # noqa: PLC0415  # it needs the extra

        with Desk(described, rig, check_folder(out)) as desk:
            show(desk.link.snapshot)
            page.serve(lambda: panel_page(desk), place, described, stopped, idle=lambda: desk.link.is_at_rest)


@contextmanager
def _rig(machine: "Machine", address: str | None) -> "Iterator[PanelRig]":
    """Yield the rig at an address, or a virtual rig without one."""
    from layflat.pages.panel.desk import PanelRig  # noqa: PLC0415

    if address is not None:
        driver_at(address, machine)
        yield PanelRig(lambda described: driver_at(address, described), address)
        return
    bench = VirtualBench(machine)
    try:
        yield PanelRig(bench.connect, "a virtual rig", bench.send_line)
    finally:
        bench.close()


class VirtualBench:
    """Virtual rig in a process of its own, started when it is first needed, and again if it is gone."""

    def __init__(self, machine: "Machine") -> None:
        """Store the machine; the process starts with the first `connect`."""
        self._machine = machine
        self._device: DeviceProcess | None = None
        self._guard = threading.Lock()  # of words to the device, which pages may give at the same time

    def connect(self, machine: "Machine") -> "tuple[Callable[[], Driver], str]":
        """Return a factory of its driver for a machine with the same arm, and its address; start it if need be."""
        if self._device is None or not self._device.process.is_alive():
            self._device = self._start()
        factory, _ = driver_at(self._device.address, machine)
        return factory, self._device.address

    def send_line(self, line: str) -> str:
        """Send it a command line, such as "fail e-stop", and return its answer.

        Raises:
            LayflatError: the line is no command, or the rig is gone or not started yet.
        """
        from layflat.rig.device.failures import execute_line  # noqa: PLC0415

        if self._device is None:
            raise LayflatError("the virtual rig is not started yet: connect to it first")
        with self._guard:
            return str(self._device.call(execute_line, line.split()))

    def close(self) -> None:
        """End the process, if it was started."""
        if self._device is not None:
            self._device.__exit__(None, None, None)

    def _start(self) -> "DeviceProcess":
        from layflat.rig.device.process import DeviceProcess, ModbusPort  # noqa: PLC0415

        return DeviceProcess(VirtualRig(self._machine), self._machine, ModbusPort(0)).__enter__()


OpenedMachine = Annotated[
    str, typer.Argument(metavar="[NAME|FILE]", help=MACHINE_HELP, autocompletion=complete_name("machine"))
]


@app.register("studio", "", "mine.toml")
@expanded
def open_studio(page: PageOptions, machine: OpenedMachine = "paper-arm") -> None:
    """Open the page on which a machine is designed.

    Change a value, and see torque, strap and step response at once. Needs the extra `panel`. Saves in the current
    folder and below it, under names that the page asks for. Each tab edits a design of its own.
    """
    from layflat.machine import load  # noqa: PLC0415

    extras.require("panel", "nicegui", where="studio")
    described, place = load(machine), page.endpoint()
    from layflat.pages.studio.page import shared_worker, studio_page  # noqa: PLC0415  # it needs the extra

    worker, folder = shared_worker(), Path.cwd()
    with stopping() as stopped:
        page.serve(
            lambda: studio_page(machine, folder),
            place,
            described,
            stopped,
            started=worker.start_simulator,
            ended=worker.end,
        )
