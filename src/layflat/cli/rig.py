"""Parts that the commands of a rig share."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.completers import complete_choice
from layflat.errors import InputError
from layflat.virtual_rig import SIMULATED_ADDRESS, simulated_rig

if TYPE_CHECKING:
    from layflat.machine import Machine
    from layflat.rig.driver import Driver


FAULT_EXIT, INTERRUPT_EXIT = 3, 130  # exit statuses: a fault was found; stopped by hand

Address = Annotated[
    str,
    typer.Option(
        "--driver",
        metavar="ADDRESS",
        help="modbus://HOST:PORT, serial:///dev/NAME or simulated",
        autocompletion=complete_choice(SIMULATED_ADDRESS),
    ),
]


def driver_at(address: str, machine: "Machine") -> "tuple[Callable[[], Driver], str]":
    """Return a function that makes the driver of an address, and the name of the rig behind it.

    Raises:
        InputError: it is not an address, a package is missing, or a law in plain Python is to run a real rig.
        MachineError: the machine can't be driven.
    """
    from layflat.machine import parameters  # noqa: PLC0415
    from layflat.rig.drivers import create_driver  # noqa: PLC0415

    parameters.control(machine)
    if address != SIMULATED_ADDRESS and not machine.control_law.compiled:
        what = f"control law {machine.control_law.name!r} is plain Python, too slow for a rig in real time"
        right = f"--driver {SIMULATED_ADDRESS} runs it; write it as laws for {address}"
        raise InputError(what, where=machine.origin, right=right)
    if address == SIMULATED_ADDRESS:
        return partial(simulated_rig, machine), f"{SIMULATED_ADDRESS} by process {os.getpid()}"
    factory = partial(create_driver, address, machine)
    factory()  # it connects later, in the process that needs it
    return factory, address


@contextmanager
def stopping() -> Iterator[Callable[[], bool]]:
    """Yield a function that returns whether Ctrl-C, SIGTERM or a closed terminal requested the end.

    Until the context is left, these do not end the process.
    """
    requested = False

    def note(_number: int, _frame: FrameType | None) -> None:
        nonlocal requested
        requested = True

    from layflat.parallel import FROM_TERMINAL  # noqa: PLC0415

    numbers = (signal.SIGTERM, *FROM_TERMINAL)
    before = [signal.signal(number, note) for number in numbers]
    try:
        yield lambda: requested
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
