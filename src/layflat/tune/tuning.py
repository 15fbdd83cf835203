"""A tuning from its beginning to a description with better values. `begin` checks, `seek` searches, `keep` writes."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from layflat.description.provenance import Provenance
from layflat.errors import InputError
from layflat.extras import require
from layflat.files import check_folder
from layflat.machine import Machine, load
from layflat.machine.exchanged import differing
from layflat.machine.listing import derived_path, write_derived
from layflat.sim.ensemble.parallel import check_device
from layflat.tune.conditions import Conditions, Spread, check_carried
from layflat.tune.knobs import Knob, Part, Tunable, neutral_values, values_of
from layflat.tune.laws import tunable
from layflat.tune.search import Found, judge, panel, search

Progress = Callable[[Found, int, str], None]
"""Told the best so far, the generations done, and what is looked for; before the first generation too."""

PAGE = "tuning.html"
STARTS = ("neutral", "current")
SEEDS = 10_000


@dataclass
class Tuning:
    """A search for the values of a machine's controller."""

    given: str  # built-in name or file
    base: Machine  # what it describes; its joints may have no gains
    machine: Machine  # the same with neutral values where it has none
    law: Tunable  # what of its control law is tuned
    method: str
    start: str
    seed: int
    asked: int | None  # generations, where they were given
    parts: list[Part]  # what is looked for, in order
    path: Path  # where the tuned description is put
    spread: Spread | None = None  # how far conditions may be from nominal; none: as usual
    device: str = "cpu"  # that makes the runs
    history: list[Found] = field(default_factory=list)  # the best after every generation, the start first
    seconds: float = 0.0  # that the search took, compilation not counted
    stopped: bool = False
    kept: bool = False  # whether the values that were there stay, since none better were found

    @property
    def knobs(self) -> list[Knob]:
        """Return what is turned."""
        return self.law.knobs(self.machine)

    def meet(self, runs: int, seed: int) -> Conditions:
        """Return so many runs that candidates are judged by."""
        return replace(self.law.conditions(self.machine, runs, self.spread, seed), device=self.device)

    @property
    def generations(self) -> int:
        """That were asked for."""
        return sum(stage.generations for part in self.parts for stage in part.stages)

    @property
    def begun(self) -> dict[str, int]:
        """After how many generations each round began, or the search where there are none."""
        found: dict[str, int] = {}
        done = 0
        for part in self.parts:
            if done < len(self.history):
                found.setdefault(part.name.partition(",")[0], done)
            done += sum(stage.generations for stage in part.stages)
        return found

    @property
    def was_complete(self) -> bool:
        """True if all values were there before."""
        return not self.law.complete(self.base)

    @property
    def command(self) -> str:
        """Return what finds the same values again."""
        words = f"layflat tune {self.given} --method {self.method} --seed {self.seed}"
        words += f" --from {self.start}" if self.start != STARTS[0] else ""
        words += " --over cloud" if self.spread is not None else ""
        words += f" --generations {self.generations}" if self.asked is not None else ""
        words += f" --device {self.device}" if self.device != "cpu" else ""
        return words + (f", stopped after {len(self.history) - 1} generations" if self.stopped else "")

    def seek(self, progress: Progress = lambda *_: None) -> None:
        """Search until the end, or until Ctrl-C: the best so far counts then, if there is any."""
        begun = time.perf_counter()

        def tell(best: Found, done: int, name: str) -> None:
            nonlocal begun
            if not self.history:
                begun = time.perf_counter()
            self.history.append(best)
            self.seconds = time.perf_counter() - begun
            progress(best, done, name)

        first = neutral_values(self.knobs) if self.start == "neutral" else values_of(self.machine, self.knobs)
        try:
            search(self.machine, self.knobs, first, self.parts, self.meet, seed=self.seed, progress=tell)
        except KeyboardInterrupt:
            if not self.history:
                raise
            self.stopped = True

    def keep(self) -> Machine:
        """Write the best values and load them; where none better were found, those that were there stand as they do."""
        best, texts, sources = self.history[-1], dict[str, str | float](), dict[str, Provenance]()
        self.kept = self.was_complete and judge(self.base, [], np.zeros((1, 0)), panel(self.meet))[0] <= best.cost
        if not self.kept:
            for knob, value in zip(self.knobs, best.values, strict=True):
                texts[knob.paths[0]] = knob.text(value)
                sources[knob.paths[0]] = Provenance("calibrated", self.command)
        for path, (text, reason) in self.law.complete(self.base).items():
            texts[path], sources[path] = text, Provenance("assumed", reason)
        return write_derived(self.given, f"{self.base.title}, tuned", texts, sources, self.path)


def begin(
    given: str,
    out: Path,
    *,
    method: str = "global",
    start: str = "neutral",
    seed: int = 1,
    generations: int | None = None,
    over: str = "",
    device: str = "cpu",
) -> Tuning:
    """Check everything before any work is done.

    Args:
        given: built-in machine or file.
        out: folder for the results.
        method: one of the methods of its control law.
        start: "neutral", values that know nothing of the machine, or "current", its own.
        seed: of the search.
        generations: in all; default: as many as the method needs.
        over: "cloud": conditions have the values of every member of the machine's cloud; default: its own.
        device: that makes the runs, "cpu" or "cuda".

    Raises:
        MachineError: the machine is wrong, or has no controller that can be tuned.
        InputError: an option is wrong, cma is not installed, or the device can't be used.
        OutputError: the folder can't be written to.
    """
    base = load(given)
    law = tunable(base)
    machine = law.begun(base)
    wanted = law.parts(machine, method, generations)
    if start not in STARTS:
        raise InputError(f"unknown start {start!r}", where="--from", right=f"give {' or '.join(STARTS)}")
    if not 0 <= seed < SEEDS:
        raise InputError(f"{seed} is out of range", where="--seed", right=f"give 0 to {SEEDS - 1}")
    if over not in {"", "cloud"}:
        raise InputError(f"{over!r} is nothing to tune over", where="--over", right="give cloud, or leave it out")
    if over and not law.clouds:
        right = "tune for each member by itself"
        raise InputError("the tracking law is told which machine it has", where="--over", right=right)
    require("tune", "cma", where="tune")
    check_device(device)
    path = derived_path(given, out, "tuned")
    check_folder(out, path.name, PAGE, costly=True)
    spread = Spread(members=differing(given)) if over else None
    tuning = Tuning(given, base, machine, law, method, start, seed, generations, wanted, path, spread, device)
    check_carried(machine, panel(tuning.meet))
    return tuning
