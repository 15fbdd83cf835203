"""Checks of all runs of a study, before the first of them."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial

import numpy as np

from layflat.arrays import Array
from layflat.description.change import changed_all
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.scenario import SIGNALS, Scenario
from layflat.sim.ensemble.cases import prepare_cases
from layflat.sim.run import make_timing
from layflat.study.description import ScenarioTable, varied_quantity

Samples = Mapping[str, Array]

REPLACED_PATHS = {f"scenario.{name}": row.path for name, row in SIGNALS.items() if row.path}
"""Paths of the machine's numbers that signals of a scenario replace, by signal."""


def check_runs(
    machine: Machine,
    scenarios: Sequence[Scenario],
    drawn: Samples,
    step: float,
    where: str,
    along: Collection[str] = (),
) -> None:
    """Refuse scenarios that do not fit the machine, and samples that are invalid or have no effect.

    Args:
        machine: machine of the study.
        scenarios: scenarios of the study.
        drawn: one value per sample, by path.
        step: step of the plant, s.
        where: the file, for messages.
        along: paths that vary with a member of a cloud, which may have no effect.

    Raises:
        InputError: naming the key.
    """
    first = np.array([0])
    for i, scenario in enumerate(scenarios):
        with locate_errors(f"{where}: scenario.{i}.", set(ScenarioTable.model_fields)):
            prepare_cases(machine, [scenario], {}, 1).runs(first)
    with locate_errors(f"{where}: ", {"scenario", "step"}):
        prepared = prepare_cases(machine, list(scenarios), {}, 1)
        make_timing(prepared.cycle, step, 1, prepared.machine)
    _check_settings(scenarios, drawn, where)
    _check_bounds(machine, drawn, where)
    # Numbers that are valid alone can contradict each other.
    machine_numbers = {path: values for path, values in drawn.items() if not path.startswith("scenario.")}
    varied = changed_all(machine, machine_numbers, f"{where}: vary")
    with locate_errors(f"{where}: ", {"step"}):
        make_timing(prepared.cycle, step, 1, varied)
    for path in (path for path in drawn if path not in along):
        values = drawn[path]
        ends = [
            prepare_cases(machine, list(scenarios), {path: [end]}, None, together=False).runs(first)
            for end in (values.min(), values.max())
        ]
        if values.min() < values.max() and all(map(partial(np.array_equal, equal_nan=True), *ends)):
            raise InputError("has no effect on a run", where=f"{where}: vary.{path}", right="leave it out")


@contextmanager
def locate_errors(where: str, keys: set[str]) -> Iterator[None]:
    """Put `where` before the place of InputErrors at one of these keys; other errors pass unchanged."""
    try:
        yield
    except InputError as error:
        if error.where not in keys:
            raise
        raise InputError(error.what, where=f"{where}{error.where}", right=error.right) from None


def _check_settings(scenarios: Sequence[Scenario], drawn: Samples, where: str) -> None:
    """Refuse to vary a value that a scenario sets from its start, or a signal with the value that it replaces."""
    for setting, path in REPLACED_PATHS.items():
        key = setting.removeprefix("scenario.")
        for i, scenario in enumerate(scenarios):
            signal = getattr(scenario, key)
            from_start = isinstance(signal, float) or (isinstance(signal, list) and signal[0][0] <= 0.0)
            both = [name for name in (setting, path) if name in drawn]
            if from_start and both:
                place = f"{where}: scenario.{i}.{key}"
                raise InputError(f"hides {both[0]}, which varies", where=place, right="leave out one of them")
        if setting in drawn and path in drawn:
            raise InputError(f"hides {path}, which also varies", where=f"{where}: vary.{setting}", right="vary one")


def _check_bounds(machine: Machine, drawn: Samples, where: str) -> None:
    """Refuse samples outside the bounds of their number, as those of a normal distribution can be."""
    for path, values in drawn.items():
        place = f"{where}: vary.{path}"
        quantity = varied_quantity(machine, path, place)
        for worst in {float(values.min()), float(values.max())}:
            try:
                quantity.parse(int(worst) if quantity.whole else quantity.format(worst), place)
            except InputError as error:
                right = f"{error.right}: give low or high"
                raise InputError(f"sample {error.what}", where=place, right=right) from None
