"""Gains of the compiler's private parts (docs/compiler.md): each is switched off in turn, all in one run.

`python -m benchmarks.compiler_parts` prints, for every figure, what it takes without a part over what it takes with
all. In each round a process for each part compiles everything, with a folder of its own; then the processes take turns
in running it, so that a busy moment of the machine meets all. `--option=-misched=ilpmax` measures an option of LLVM in
place of parts, without ordering. Times are those of a processor's work, which do not count who else is at it, but for
the thread of LLVM: its gain is one of time that passes, on a computer that is quiet.
"""

# mypy: disable-error-code="attr-defined,misc"
# Parts are switched off where they are used.

from __future__ import annotations

import argparse
import gc
import os
import random
import statistics
import sys
import time
from collections.abc import Callable
from concurrent.futures import Future
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from llvmlite import binding
from rich.console import Console
from rich.table import Table

from benchmarks import chains, many
from benchmarks.timing import STEP
from layflat import lanes
from layflat.jit import compile_session, compiler, libraries
from layflat.machine import load
from layflat.sim.ensemble import loops, parallel
from layflat.sim.run import prepare_run

RUNS = 128  # of an ensemble
REPEATS = 9  # of a measurement, of which the quickest counts


class Figure(NamedTuple):
    """A workload: kernels that have to be compiled, and the steps that they then simulate."""

    work: Callable[[], object]
    steps: int
    repeats: int = REPEATS


def figures() -> dict[str, Figure]:
    """Return what is compiled and measured, by key."""
    paper, four, picking = load("paper-arm"), chains.four(), load("picking-arm")
    tracking = load("paper-arm-tracking")

    def several(seconds: Callable[..., float], machine: Any, runs: int, **options: Any) -> Figure:
        return Figure(lambda: seconds(machine, runs, **options), runs * many.STEPS, 3)

    return {
        "rollout": Figure(prepare_run(paper, many.MOVES, step=STEP).run, many.STEPS),
        "tracking": Figure(prepare_run(tracking, many.MOVES, step=STEP).run, many.STEPS),
        "chain4": Figure(prepare_run(four, chains.moves(four), step=STEP).run, many.STEPS),
        "chain4 tracking": Figure(prepare_run(picking, chains.moves(picking), step=STEP).run, many.STEPS),
        "ensemble": several(many.seconds, paper, RUNS, threads=1),
        "ensemble single": several(many.seconds, paper, RUNS, threads=1, precision="single"),
        "chain4 ensemble": several(chains.ensemble_seconds, four, RUNS // 2),
        "chain4 ensemble single": several(chains.ensemble_seconds, four, RUNS // 2, precision="single"),
    }


class _AtOnce:
    """In place of the thread in which LLVM works."""

    def __init__(self, _threads: int) -> None: ...

    def submit(self, part: Callable[[], None]) -> Future[None]:
        done: Future[None] = Future()
        try:
            part()
            done.set_result(None)
        except Exception as error:
            done.set_exception(error)
        return done

    def shutdown(self) -> None: ...


def _optimise_laws_fully() -> None:
    own = compiler.LawCompiler.__init__

    class Plain(libraries.LawCompiler):
        def __init__(self, typing_context: Any, context: Any, library: Any, *rest: Any) -> None:
            if library is None:
                library = context.codegen().create_library("law")
            own(self, typing_context, context, library, *rest)

    compiler.LawCompiler = Plain


def _be_one_lane_wide() -> None:
    for module in (lanes, loops, parallel):
        module.host_width = lambda *_, **__: 1


def _set(place: Any, name: str, value: Any) -> Callable[[], None]:
    return lambda: setattr(place, name, value)


def _all_of(*parts: Callable[[], None]) -> Callable[[], None]:
    def off() -> None:
        for part in parts:
            part()

    return off


OFF: dict[str, Callable[[], None]] = {
    "instructions in order": _set(libraries, "order_instructions", lambda text: text),
    "laws without machine code": _optimise_laws_fully,
    "named tuples whole": lambda: delattr(libraries._LawContext, "get_arg_packer"),
    "no references counted": lambda: delattr(libraries._References, "get_meminfos"),
    "LLVM in a thread": _set(compile_session, "ThreadPoolExecutor", _AtOnce),
    "garbage seldom": _set(compile_session, "GC_THRESHOLDS", gc.get_threshold()),
    "threads in turn": _set(compile_session, "SWITCH_INTERVAL", sys.getswitchinterval()),
    "counts without lock": _set(
        compile_session.ffi.lib.LLVMPY_DumpRefPruneStats, "_lock", compile_session.ffi.lib.LLVMPY_SetCommandLine._lock
    ),
    "lanes": _be_one_lane_wide,
}
"""How each part is switched off, in a process that has compiled nothing but a line."""
OFF["turns, lock"] = _all_of(OFF["threads in turn"], OFF["counts without lock"])
OFF["context"] = lambda: setattr(libraries, "law_context", lambda context: context)
OFF["thread and its helpers"] = _all_of(OFF["LLVM in a thread"], OFF["turns, lock"])
OFF["all of compile"] = _all_of(
    _set(compiler, "LawCompiler", libraries.Compiler), OFF["thread and its helpers"], OFF["garbage seldom"]
)


def _work(off: str, keys: list[str], folder: str, there: Connection) -> None:
    os.environ["LAYFLAT_CACHE_DIR"] = folder
    if off.startswith("-"):
        OFF["instructions in order"]()
        binding.set_option("layflat", off)
    elif off in OFF:
        OFF[off]()
    all_figures = figures()
    for key in keys:
        begin = time.perf_counter(), time.process_time()
        all_figures[key].work()
        there.send((time.perf_counter() - begin[0], time.process_time() - begin[1]))
    while (key := there.recv()) is not None:
        figure, quickest = all_figures[key], float("inf")
        for _ in range(figure.repeats):
            start = time.process_time()
            figure.work()
            quickest = min(quickest, time.process_time() - start)
        there.send(1e9 * quickest / figure.steps)


def measure(parts: list[str], keys: list[str], rounds: int, turns: int) -> dict[tuple[str, str], list[float]]:
    """Return all figures by part and name, one for each round (of those in turn, the quickest)."""
    processes, found = get_context("fork"), dict[tuple[str, str], list[float]]()
    for number in range(rounds):
        with TemporaryDirectory() as folder:
            workers = {}
            for i, part in enumerate(random.sample(parts, len(parts))):
                here, there = processes.Pipe()
                process = processes.Process(target=_work, args=(part, keys, str(Path(folder, str(i))), there))
                process.start()
                workers[part] = here, process
                for key in keys:
                    for name, taken in zip(("compile, s passed", "compile, s of work"), here.recv(), strict=True):
                        found.setdefault((part, f"{key}: {name}"), []).append(taken)
            for _ in range(turns):
                for key in keys:
                    for part in random.sample(parts, len(parts)):
                        here = workers[part][0]
                        here.send(key)
                        best = found.setdefault((part, f"{key}: step, ns"), [])
                        best.extend([float("inf")] * (number + 1 - len(best)))
                        best[number] = min(best[number], here.recv())
            for here, process in workers.values():
                here.send(None)
                process.join()
    return found


def main() -> None:
    """Measure and print."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--rounds", type=int, default=5)
    arguments.add_argument("--turns", type=int, default=5)
    arguments.add_argument("--part", action="append", choices=list(OFF), help="this one alone; more than once: these")
    arguments.add_argument("--key", action="append", help="of what is measured; the default is all")
    arguments.add_argument("--option", action="append", default=[], help="of LLVM, in place of parts")
    given = arguments.parse_args()
    parts = ["", "again", *(["instructions in order", *given.option] if given.option else given.part or OFF)]
    compiler.compile_cached(lambda x: 2.0 * x, None)(1.0)  # what the compiler does once is no gain of a part
    found = measure(parts, given.key or list(figures()), given.rounds, given.turns)
    table = Table("without", "figure", "with all", "times as much", "rounds", header_style="bold", show_edge=False)
    for (part, name), values in found.items():
        if part:
            ratios = [one / other for one, other in zip(values, found["", name], strict=True)]
            middle = statistics.median(found["", name])
            spread = f"{min(ratios):.3f} to {max(ratios):.3f}"
            table.add_row(part, name, f"{middle:.1f}", f"{statistics.median(ratios):.3f}", spread)
    Console(width=120).print(table)


if __name__ == "__main__":
    main()
