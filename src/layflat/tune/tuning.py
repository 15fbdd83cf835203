"""Search for better values of a controller: `begin_tuning` checks, `Tuning.search` searches, `save_best` writes."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from layflat.description.tables import Provenance
from layflat.errors import InputError
from layflat.extras import require
from layflat.files import check_folder
from layflat.machine import Machine, load
from layflat.machine.exchanged import member_values
from layflat.machine.listing import derived_path, write_derived
from layflat.sim.ensemble.parallel import check_device
from layflat.tune.conditions import ConditionRanges, Conditions, check_joints_hold
from layflat.tune.knobs import Knob, SearchPart, TunableLaw, current_values, neutral_values
from layflat.tune.laws import tunable_law
from layflat.tune.search import SearchResult, evaluate_costs, panel_conditions, search_knob_values

Progress = Callable[[SearchResult, int, str], None]
"""Callback with the best so far, the generations done, and the name of the part; before the first generation too."""

REPORT_FILE = "tuning.html"
START_VALUES = ("neutral", "current")
SEED_COUNT = 10_000


@dataclass
class Tuning:
    """Search for better values of a machine's controller."""

    source: str  # built-in name or file
    base: Machine  # described by the source; its joints may have no gains
    machine: Machine  # the same with neutral values where it has none
    law: TunableLaw  # knobs and conditions of its control law
    method: str
    start: str
    seed: int
    requested_generations: int | None  # None: as the method needs
    parts: list[SearchPart]  # of the search, in order
    path: Path  # of the tuned description
    ranges: ConditionRanges | None = None  # of conditions about nominal; None: the defaults
    device: str = "cpu"  # for the runs
    history: list[SearchResult] = field(default_factory=list)  # the best after every generation, the start first
    seconds: float = 0.0  # duration of the search, without compilation
    stopped: bool = False
    unchanged: bool = False  # whether the values of before stay, as none better were found

    @property
    def knobs(self) -> list[Knob]:
        """Return the values that are tuned."""
        return self.law.knobs(self.machine)

    def make_conditions(self, runs: int, seed: int) -> Conditions:
        """Return conditions of so many runs (a power of two), by which candidates are judged."""
        return replace(self.law.conditions(self.machine, runs, self.ranges, seed), device=self.device)

    @property
    def generations(self) -> int:
        """Number of generations of all parts."""
        return sum(stage.generations for part in self.parts for stage in part.stages)

    @property
    def round_starts(self) -> dict[str, int]:
        """Generations after which each round of the search began, by its name."""
        starts: dict[str, int] = {}
        done = 0
        for part in self.parts:
            if done < len(self.history):
                starts.setdefault(part.name.partition(",")[0], done)
            done += sum(stage.generations for stage in part.stages)
        return starts

    @property
    def was_complete(self) -> bool:
        """True if the base has all values."""
        return not self.law.complete(self.base)

    @property
    def command(self) -> str:
        """Return the command that reproduces the values."""
        words = f"layflat tune {self.source} --method {self.method} --seed {self.seed}"
        words += f" --from {self.start}" if self.start != START_VALUES[0] else ""
        words += " --over cloud" if self.ranges is not None else ""
        words += f" --generations {self.generations}" if self.requested_generations is not None else ""
        words += f" --device {self.device}" if self.device != "cpu" else ""
        return words + (f", stopped after {len(self.history) - 1} generations" if self.stopped else "")

    def search(self, progress: Progress = lambda *_: None) -> None:
        """Search until the end, or until Ctrl-C, which sets `stopped`, and keep the best so far in `history`.

        Ctrl-C before the first report is raised.
        """
        start = time.perf_counter()

        def report(best: SearchResult, done: int, name: str) -> None:
            """Append the best to the history, set the duration since the first, and call `progress`."""
            nonlocal start
            if not self.history:
                start = time.perf_counter()
            self.history.append(best)
            self.seconds = time.perf_counter() - start
            progress(best, done, name)

        first = neutral_values(self.knobs) if self.start == "neutral" else current_values(self.machine, self.knobs)
        try:
            search_knob_values(
                self.machine, self.knobs, first, self.parts, self.make_conditions, seed=self.seed, progress=report
            )
        except KeyboardInterrupt:
            if not self.history:
                raise
            self.stopped = True

    def save_best(self) -> Machine:
        """Write the description with the best values, or with those of before if none are better, and load it.

        `unchanged` is set if those of before stay. There must be a result of `search`.

        Raises:
            OutputError: the description can't be written.
        """
        best, texts, sources = self.history[-1], dict[str, str | float](), dict[str, Provenance]()
        self.unchanged = (
            self.was_complete
            and evaluate_costs(self.base, [], np.zeros((1, 0)), panel_conditions(self.make_conditions))[0] <= best.cost
        )
        if not self.unchanged:
            for knob, value in zip(self.knobs, best.values, strict=True):
                texts[knob.paths[0]] = knob.text(value)
                sources[knob.paths[0]] = Provenance("calibrated", self.command)
        for path, (text, reason) in self.law.complete(self.base).items():
            texts[path], sources[path] = text, Provenance("assumed", reason)
        return write_derived(self.source, f"{self.base.title}, tuned", texts, sources, self.path)


def begin_tuning(
    source: str | Path,
    out: Path,
    *,
    method: str = "global",
    start: str = "neutral",
    seed: int = 1,
    generations: int | None = None,
    over: str = "",
    device: str = "cpu",
) -> Tuning:
    """Return a tuning, after all checks and before any computation.

    Args:
        source: built-in machine or file.
        out: folder for the results.
        method: one of the methods of its control law.
        start: "neutral" for values that do not depend on the machine, or "current" for its own.
        seed: seed of the search.
        generations: number in all; default: as many as the method needs.
        over: "cloud" for conditions with the values of every member of the machine's cloud; default: its own.
        device: device for the runs, "cpu" or "cuda".

    Raises:
        MachineError: the machine is wrong, has no controller that can be tuned, or can't hold the payloads of the
            conditions.
        InputError: an option is wrong, the machine has no file, cma is not installed, or the device can't be used.
        OutputError: the folder can't be written to.
    """
    if isinstance(source, Machine):
        raise InputError(f"{source.origin} has no file", where="machine", right="give one: save(machine, path)")
    source, base = str(source), load(source)
    law = tunable_law(base)
    machine = law.with_neutral_values(base)
    parts = law.parts(machine, method, generations)
    if start not in START_VALUES:
        raise InputError(f"unknown start {start!r}", where="start", right=f"give {' or '.join(START_VALUES)}")
    if not 0 <= seed < SEED_COUNT:
        raise InputError(f"{seed} is out of range", where="seed", right=f"give 0 to {SEED_COUNT - 1}")
    if over not in {"", "cloud"}:
        raise InputError(f"{over!r} is nothing to tune over", where="over", right="give cloud, or leave it out")
    if over and not law.clouds:
        right = "tune for each member by itself"
        raise InputError("the tracking law is told which machine it has", where="over", right=right)
    require("tune", "cma", where="tune")
    check_device(device)
    path = derived_path(source, out, "tuned")
    check_folder(out, path.name, REPORT_FILE, costly=True)
    ranges = ConditionRanges(members=member_values(source)) if over else None
    tuning = Tuning(source, base, machine, law, method, start, seed, generations, parts, path, ranges, device)
    check_joints_hold(machine, panel_conditions(tuning.make_conditions))
    return tuning
