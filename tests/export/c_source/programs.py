"""Exported laws as programs of this computer, cycle by cycle beside the host's own machine code."""

import ctypes
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from layflat.export.c_interface import CInterface
from layflat.export.c_source.c_types import Type
from layflat.export.c_source.function import CFunction, translate
from layflat.export.c_source.program import Program
from layflat.export.c_source.text import program_text
from layflat.export.compiled import portable_entry
from layflat.export.host import NUMBER_TYPES, HostControl, Numbers
from layflat.export.recording import record
from layflat.lanes import leaves
from layflat.machine import Machine, load
from tests.export.builds import LANGUAGES, SANITIZED, STRICT, needing, run

EXACT = [*LANGUAGES["C"], *STRICT]


def library(compiler: str, sources: list[str], folder: Path) -> ctypes.CDLL:
    """Sources of C as a library that is loaded."""
    run([needing(compiler), *EXACT, "-shared", "-fPIC", *sources, "-lm", "-o", f"law-{compiler}.so"], folder)
    return ctypes.CDLL(str(folder / f"law-{compiler}.so"))


class SourceControl:
    """A control law of an exported folder, with the methods of `HostControl`."""

    def __init__(self, interface: CInterface, folder: Path, compiler: str) -> None:
        prefix, entries = interface.prefix, interface.control
        self.dtype, self._real = NUMBER_TYPES[interface.precision]
        loaded = library(compiler, [f"{prefix}.c", "parameters.c"], folder)
        self._wake, self._step = (getattr(loaded, f"{prefix}_control_{name}") for name in ("wake", "step"))
        tuples = (entries.settings, entries.memory, entries.command, entries.report)
        self._settings, self.memory, self.command, self.report = (
            np.array(list(leaves(one)), self.dtype) for one in tuples
        )

    def wake(self, sensed: Numbers) -> None:
        self._wake(*map(address, (self._settings, sensed, self.memory)))

    def step(self, sensed: Numbers, demand: Numbers, elapsed: float) -> None:
        inputs, outputs = (self._settings, self.memory, sensed, demand), (self.memory, self.command, self.report)
        self._step(*map(address, inputs), self._real(elapsed), *map(address, outputs))


def address(numbers: Numbers) -> ctypes.c_void_p:
    return ctypes.c_void_p(numbers.ctypes.data)


def different_cycles(machine: Machine, folder: Path, precision: str, compiler: str) -> Iterator[int]:
    """Cycles of a closed loop of 2 s with noise in which any number of memory, command or report is another one."""
    interface = CInterface(machine, precision, plant=False)
    texts = {one.name: portable_entry(one, interface.prefix, precision) for one in interface.control}
    host = HostControl(interface.control, texts, interface.prefix, precision)
    recorded = record(machine, host)
    source = SourceControl(interface, folder, compiler)
    rest, sensed, demand = (one.astype(host.dtype) for one in (recorded.rest, recorded.sensed, recorded.demand))
    for law in (host, source):
        law.wake(rest)
    for k in range(len(sensed)):
        for law in (host, source):
            law.step(sensed[k], demand[k], machine.cycle)
        pairs = [(getattr(host, name), getattr(source, name)) for name in ("memory", "command", "report")]
        if any(one.tobytes() != other.tobytes() for one, other in pairs):
            yield k


def last_line_of_example(folder: Path, compiler: str) -> str:
    """What the example of an exported folder prints at its end, built without a warning and with sanitizers."""
    sources = sorted(path.name for path in folder.glob("*.c"))
    words = [*LANGUAGES["C"], *STRICT, *SANITIZED, *sources, "-lm", "-o", f"strict-{compiler}"]
    run([needing(compiler), *words], folder)
    return run([f"./strict-{compiler}"], folder).splitlines()[-1]


def translated(law: Any, kinds: list[Type], precision: str = "double") -> tuple[Program, CFunction]:
    """A law of any machine as a function of C."""
    program = Program(CInterface(load("paper-arm"), precision, plant=False).api, precision)
    names = list(law.py_func.__code__.co_varnames[: law.py_func.__code__.co_argcount])
    return program, translate(program, law.py_func, law.__name__, names, list(kinds), ())


def compiled(law: Any, kinds: list[Type], folder: Path) -> Callable[..., float]:
    """A law of numbers as a function that is compiled from its C."""
    program, function = translated(law, kinds)
    program.functions[law] = function
    numbers = [f"x_{i}" for i in range(len(kinds))]
    head = f"double called({', '.join(f'double {one}' for one in numbers)})"
    entry = [f"{head}", "{", f"    return {function.name}({', '.join(numbers)});", "}"]
    lines = ["#include <math.h>", "#include <stdbool.h>", "", f"{head};", *program_text(program, {"called": entry}), ""]
    (folder / "law.c").write_text("\n".join(lines))
    called = library("gcc", ["law.c"], folder).called
    called.restype, called.argtypes = ctypes.c_double, [ctypes.c_double] * len(kinds)
    return called
