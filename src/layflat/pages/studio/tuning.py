"""Tune the controller of a design in a process of its own: what `layflat tune` does, begun from the values it has."""

import tempfile
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

from layflat.description.provenance import Provenance
from layflat.errors import LayflatError
from layflat.extras import require
from layflat.files import write_text
from layflat.machine.listing import to_toml
from layflat.pages.studio.design import Change, Changes, Design, sources_of
from layflat.parallel import start_process

GENERATIONS = 40


@dataclass
class Progress:
    """Progress of a tuning."""

    done: int = 0  # generations
    wanted: int = GENERATIONS
    first: float | None = None  # cost of what it began with, s
    best: float | None = None  # cost of the best so far, s
    ended: bool = False
    error: str = ""  # what it ended with, if it failed
    found: Changes = field(default_factory=dict)  # the best values, where they are better


class TuningRun:
    """A tuning that goes on in another process. Ask `progress` now and then."""

    def __init__(self, design: Design, generations: int = GENERATIONS, seed: int = 1) -> None:
        """Begin.

        Raises:
            MissingExtraError: cma is not installed.
        """
        require("tune", "cma", where="tune")
        context = get_context("spawn")
        self._ours, theirs = context.Pipe(duplex=False)
        self._cancelled = context.Event()
        self._progress = Progress(wanted=generations)
        text = to_toml(design.plain, sources_of(design.opened, design.changes))
        arguments = (text, generations, seed, theirs, self._cancelled)
        self._process = start_process(_tune, arguments, "layflat-studio-tune", daemon=True)
        theirs.close()

    def cancel(self) -> None:
        """Ask for an end with the generation that goes on; the best so far is kept."""
        self._cancelled.set()

    def close(self) -> None:
        """End it at once."""
        self._process.terminate()

    @property
    def progress(self) -> Progress:
        """Return how far it is by now."""
        now = self._progress
        try:
            while not now.ended and self._ours.poll():
                _take(now, self._ours.recv())
        except EOFError:
            now.ended, now.error = True, now.error or "the process that tunes has ended"
        return now


def _take(progress: Progress, told: tuple[str, Any]) -> None:
    what, value = told
    if what == "best":
        progress.done, progress.best = value
        progress.first = progress.best if progress.first is None else progress.first
    elif what == "found":
        progress.ended, progress.found = True, value
    else:
        progress.ended, progress.error = True, value


def _tune(text: str, generations: int, seed: int, told: Connection, cancelled: Event) -> None:
    """Tune the machine of a complete description, and tell how far it is."""
    from layflat.tune import begin  # noqa: PLC0415  # in the process that tunes only
    from layflat.tune.search import Found  # noqa: PLC0415

    def tell(best: Found, done: int, _name: str) -> None:
        told.send(("best", (done, best.cost)))
        if cancelled.is_set():
            raise KeyboardInterrupt  # as somebody at a terminal would stop it: the best so far is kept

    try:
        with tempfile.TemporaryDirectory() as folder:
            path = write_text(Path(folder) / "design.toml", text)
            tuning = begin(str(path), Path(folder), start="current", generations=generations, seed=seed)
            tuning.seek(tell)
            tuning.keep()
    except LayflatError as error:
        told.send(("error", str(error)))
        return
    note = Provenance("calibrated", f"layflat studio, {len(tuning.history) - 1} generations, seed {seed}")
    values = tuning.history[-1].values
    found: dict[str, Change] = {}
    if not tuning.kept:
        found |= {k.paths[0]: Change(k.text(value), note) for k, value in zip(tuning.knobs, values, strict=True)}
        besides = tuning.law.complete(tuning.base).items()
        found |= {path: Change(value, Provenance("assumed", reason)) for path, (value, reason) in besides}
    told.send(("found", found))
