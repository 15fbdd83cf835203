"""Tuning of a design's controller in a process of its own, as `layflat tune` does, from its present values."""

import tempfile
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

from layflat.description.tables import Provenance
from layflat.errors import LayflatError
from layflat.extras import require
from layflat.files import write_text
from layflat.machine.listing import to_toml
from layflat.pages.studio.design import Change, Changes, Design, sources_of
from layflat.parallel import start_process

DEFAULT_GENERATIONS = 40


@dataclass
class TuningProgress:
    """Progress of a tuning."""

    done: int = 0  # generations
    total: int = DEFAULT_GENERATIONS
    first: float | None = None  # cost of the initial values, s
    best: float | None = None  # cost of the best so far, s
    has_ended: bool = False
    error: str = ""  # message of the error that ended it
    changes: Changes = field(default_factory=dict)  # best values; empty unless they are better than the initial ones


class TuningRun:
    """Tuning that runs in another process; read `progress` repeatedly."""

    def __init__(self, design: Design, generations: int = DEFAULT_GENERATIONS, seed: int = 1) -> None:
        """Start the process.

        Args:
            design: design whose controller is tuned.
            generations: number of generations of the search.
            seed: seed of the search.

        Raises:
            MissingExtraError: cma is not installed.
        """
        require("tune", "cma", where="tune")
        context = get_context("spawn")
        self._ours, theirs = context.Pipe(duplex=False)
        self._cancelled = context.Event()
        self._progress = TuningProgress(total=generations)
        text = to_toml(design.plain, sources_of(design.opened, design.changes))
        arguments = (text, generations, seed, theirs, self._cancelled)
        self._process = start_process(_tune, arguments, "layflat-studio-tune", daemon=True)
        theirs.close()

    def cancel(self) -> None:
        """Request an end after the present generation; the best values so far are kept."""
        self._cancelled.set()

    def close(self) -> None:
        """End the process at once; nothing more is stored in `progress`."""
        self._process.terminate()

    @property
    def progress(self) -> TuningProgress:
        """Progress by now, always the same object: each access stores the messages received since the last one."""
        now = self._progress
        try:
            while not now.has_ended and self._ours.poll():
                _store_message(now, self._ours.recv())
        except EOFError:
            now.has_ended, now.error = True, now.error or "the process that tunes has ended"
        return now


def _store_message(progress: TuningProgress, message: tuple[str, Any]) -> None:
    """Store a message of the tuning process in `progress`: "best" (generations, cost), "found" (changes) or error."""
    kind, value = message
    if kind == "best":
        progress.done, progress.best = value
        progress.first = progress.best if progress.first is None else progress.first
    elif kind == "found":
        progress.has_ended, progress.changes = True, value
    else:
        progress.has_ended, progress.error = True, value


def _tune(text: str, generations: int, seed: int, progress: Connection, cancelled: Event) -> None:
    """Tune the machine of a complete description, and send the progress: main function of the process."""
    from layflat.tune import begin_tuning  # noqa: PLC0415  # in the process that tunes only
    from layflat.tune.search import SearchResult  # noqa: PLC0415

    def report(best: SearchResult, done: int, _name: str) -> None:
        progress.send(("best", (done, best.cost)))
        if cancelled.is_set():
            raise KeyboardInterrupt  # as Ctrl-C at a terminal: the best so far is kept

    try:
        with tempfile.TemporaryDirectory() as folder:
            path = write_text(Path(folder) / "design.toml", text)
            tuning = begin_tuning(str(path), Path(folder), start="current", generations=generations, seed=seed)
            tuning.search(report)
            tuning.save_best()
    except LayflatError as error:
        progress.send(("error", str(error)))
        return
    note = Provenance("calibrated", f"layflat studio, {len(tuning.history) - 1} generations, seed {seed}")
    values = tuning.history[-1].values
    changes: dict[str, Change] = {}
    if not tuning.unchanged:
        changes |= {k.paths[0]: Change(k.text(value), note) for k, value in zip(tuning.knobs, values, strict=True)}
        besides = tuning.law.complete(tuning.base).items()
        changes |= {path: Change(value, Provenance("assumed", reason)) for path, (value, reason) in besides}
    progress.send(("found", changes))
