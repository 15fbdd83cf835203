"""Commands of a rig: rig run, rig serve, rig check, rig faults; what they share. Each stands in a module of its own."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.lazy import LazyTyper
from layflat.errors import InputError

if TYPE_CHECKING:
    from layflat.machine import Machine
    from layflat.rig.driver import Driver

rigs = LazyTyper(
    "rig",
    "Run a machine on a rig, real or virtual.",
    {"run": "rig_run", "check": "rig_check", "serve": "rig_serve", "faults": "rig_faults"},
)


@rigs.callback()
def rig() -> None:
    """Group the commands about rigs."""


Address = Annotated[
    str, typer.Option("--driver", metavar="ADDRESS", help="modbus://HOST:PORT, serial:///dev/NAME or simulated")
]

FAULT, INTERRUPTED = 3, 130  # exit statuses: a fault was found; stopped by hand
SIMULATED = "simulated"  # address of a virtual rig in the loop's own process


def driver_at(address: str, machine: "Machine") -> "tuple[Callable[[], Driver], str]":
    """What makes the driver of an address, and the name of the rig behind it.

    Raises:
        InputError: it is not an address, or a package is missing.
        MachineError: the machine can't be driven.
    """
    from layflat.cli.virtual_rig import simulated_rig  # noqa: PLC0415
    from layflat.machine import parameters  # noqa: PLC0415
    from layflat.rig.drivers.address import driver_of  # noqa: PLC0415

    parameters.control(machine)
    if address != SIMULATED and not machine.control_law.compiled:
        what = f"control law {machine.control_law.name!r} is plain Python, too slow for a rig in real time"
        right = f"--driver {SIMULATED} runs it; write it as laws for {address}"
        raise InputError(what, where=machine.origin, right=right)
    if address == SIMULATED:
        return partial(simulated_rig, machine), f"{SIMULATED} by process {os.getpid()}"
    factory = partial(driver_of, address, machine)
    factory()  # it connects later, in the process that needs it
    return factory, address


@contextmanager
def stopping() -> Iterator[Callable[[], bool]]:
    """Whether somebody has asked for an end (Ctrl-C, SIGTERM, a closed terminal); nothing is interrupted by it."""
    asked = False

    def note(_number: int, _frame: FrameType | None) -> None:
        nonlocal asked
        asked = True

    from layflat.parallel import FROM_TERMINAL  # noqa: PLC0415

    numbers = (signal.SIGTERM, *FROM_TERMINAL)
    before = [signal.signal(number, note) for number in numbers]
    try:
        yield lambda: asked
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
