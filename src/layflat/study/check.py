"""Whether all runs of a study can be: asked before the first of them."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial

import numpy as np

from layflat.arrays import Array
from layflat.description.change import changed_all
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.scenario import SIGNALS, Scenario
from layflat.sim.ensemble.cases import cases
from layflat.sim.run import timing_of
from layflat.study.description import ScenarioTable, kind

Samples = Mapping[str, Array]

SAME_THING = {f"scenario.{name}": row.path for name, row in SIGNALS.items() if row.path}
"""Settings of a scenario that stand in for a number of the machine."""


def check(
    machine: Machine,
    scenarios: Sequence[Scenario],
    drawn: Samples,
    step: float,
    where: str,
    along: Collection[str] = (),
) -> None:
    """Refuse scenarios that do not fit the machine, and samples that make no sense or do not matter.

    What comes `along` with a member of a cloud need not matter: nobody asked for it by itself.
    """
    first = np.array([0])
    for i, scenario in enumerate(scenarios):
        with inside(f"{where}: scenario.{i}.", set(ScenarioTable.model_fields)):
            cases(machine, [scenario], {}, 1).runs(first)
    with inside(f"{where}: ", {"scenario", "step"}):
        prepared = cases(machine, list(scenarios), {}, 1)
        timing_of(prepared.cycle, step, 1, prepared.machine)
    _check_settings(scenarios, drawn, where)
    _check_bounds(machine, drawn, where)
    # Numbers that are right alone can contradict each other.
    own_numbers = {key: own for key, own in drawn.items() if not key.startswith("scenario.")}
    varied = changed_all(machine, own_numbers, f"{where}: vary")
    with inside(f"{where}: ", {"step"}):
        timing_of(prepared.cycle, step, 1, varied)
    for path in (path for path in drawn if path not in along):
        values = drawn[path]
        ends = [
            cases(machine, list(scenarios), {path: [end]}, None, together=False).runs(first)
            for end in (values.min(), values.max())
        ]
        if values.min() < values.max() and all(map(partial(np.array_equal, equal_nan=True), *ends)):
            raise InputError("has no effect on a run", where=f"{where}: vary.{path}", right="leave it out")


@contextmanager
def inside(where: str, keys: set[str]) -> Iterator[None]:
    """Name the table of a mistake in one of these keys, `where`."""
    try:
        yield
    except InputError as error:
        if error.where not in keys:
            raise
        raise InputError(error.what, where=f"{where}{error.where}", right=error.right) from None


def _check_settings(scenarios: Sequence[Scenario], drawn: Samples, where: str) -> None:
    """Refuse to vary what a scenario says itself from the start on."""
    for setting, path in SAME_THING.items():
        key = setting.removeprefix("scenario.")
        for i, scenario in enumerate(scenarios):
            given = getattr(scenario, key)
            from_start = isinstance(given, float) or (isinstance(given, list) and given[0][0] <= 0.0)
            both = [name for name in (setting, path) if name in drawn]
            if from_start and both:
                place = f"{where}: scenario.{i}.{key}"
                raise InputError(f"hides {both[0]}, which varies", where=place, right="leave out one of them")
        if setting in drawn and path in drawn:
            raise InputError(f"hides {path}, which also varies", where=f"{where}: vary.{setting}", right="vary one")


def _check_bounds(machine: Machine, drawn: Samples, where: str) -> None:
    """Samples of a normal distribution can lie outside what a machine may have."""
    for path, values in drawn.items():
        place = f"{where}: vary.{path}"
        own = kind(machine, path, place)
        for worst in {float(values.min()), float(values.max())}:
            try:
                own.parse(int(worst) if own.whole else own.written(worst), place)
            except InputError as error:
                right = f"{error.right}: give low or high"
                raise InputError(f"sample {error.what}", where=place, right=right) from None
