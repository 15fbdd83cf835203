"""Whether all runs of a study can be: asked before the first of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.sim import Scenario
from layflat.sim.ensemble.cases import cases
from layflat.sim.run import timing_of
from layflat.study.description import ScenarioTable
from layflat.study.kinds import kind

Samples = Mapping[str, NDArray[np.float64]]

SAME_THING = {"scenario.payload": "arm.payload", "scenario.supply": "supply.pressure_gauge"}
"""Settings of a scenario that stand in for a number of the machine."""


def check(machine: Machine, scenarios: Sequence[Scenario], drawn: Samples, step: float, where: str) -> None:
    """Make sure that scenarios fit the machine, and that every sample makes sense and matters.

    Raises:
        InputError: naming `where` and the key.
    """
    for i, scenario in enumerate(scenarios):
        with _inside(f"{where}: scenario.{i}.", set(ScenarioTable.model_fields)):
            cases(machine, [scenario], {}, 1).runs(np.array([0]))
    with _inside(f"{where}: ", {"scenario", "step"}):
        timing_of(cases(machine, list(scenarios), {}, 1).cycle, step, 1)
    _check_settings(scenarios, drawn, where)
    _check_bounds(machine, drawn, where)
    _check_together(machine, drawn, where)
    _check_effects(machine, scenarios, drawn, where)


@contextmanager
def _inside(where: str, keys: set[str]) -> Iterator[None]:
    """Say of a mistake in one of these keys in which table it is."""
    try:
        yield
    except InputError as error:
        if error.where not in keys:
            raise
        raise InputError(error.what, where=f"{where}{error.where}", right=error.right) from None


def _check_settings(scenarios: Sequence[Scenario], drawn: Samples, where: str) -> None:
    """What a scenario says itself from the start on can't vary as well."""
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
                raise InputError(
                    f"sample {error.what}", where=place, right=f"{error.right}: give low or high"
                ) from None


def _check_together(machine: Machine, drawn: Samples, where: str) -> None:
    """Numbers that are right alone can contradict each other."""
    paths = [path for path in drawn if not path.startswith("scenario.")]
    for place, part in _parts(machine, paths):
        validators = [one.func for one in type(part).__pydantic_decorators__.model_validators.values()]
        own = {path.removeprefix(f"{place}."): drawn[path] for path in paths if path.startswith(f"{place}.")}
        for i in range(len(next(iter(own.values()))) if validators else 0):
            numbers = {path: float(values[i]) for path, values in own.items()}
            try:
                for validator in validators:
                    validator(_Sample(part, numbers, ""))
            except ValueError as error:
                values = ", ".join(f"{place}.{path} = {number:.4g}" for path, number in numbers.items())
                what = f"{error} (here, in SI: {values})"
                raise InputError(what, where=f"{where}: vary", right="narrow it") from None


class _Sample:
    """A part of a machine as it is in one sample: much faster than a changed copy of it."""

    def __init__(self, part: Any, numbers: Mapping[str, float], prefix: str) -> None:
        self._part, self._numbers, self._prefix = part, numbers, prefix

    def __getattr__(self, name: str) -> Any:
        path, item = f"{self._prefix}{name}", getattr(self._part, name)
        if path in self._numbers:
            return self._numbers[path]
        if isinstance(item, tuple):
            return tuple(self._numbers.get(f"{path}.{i}", one) for i, one in enumerate(item))
        return _Sample(item, self._numbers, f"{path}.") if isinstance(item, BaseModel) else item


def _parts(machine: Machine, paths: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """The parts of a machine that hold something that varies, each once, by their places."""
    places = {path.rsplit(".", i)[0] for path in paths for i in range(1, path.count(".") + 1)}
    for place in sorted(places):
        part = value_at(machine, place)
        if isinstance(part, BaseModel):
            yield place, part


def _check_effects(machine: Machine, scenarios: Sequence[Scenario], drawn: Samples, where: str) -> None:
    """To vary what no run depends on would be a mistake."""
    first = np.array([0])
    for path, values in drawn.items():
        ends = [
            cases(machine, list(scenarios), {path: [end]}, None, together=False).runs(first)
            for end in (values.min(), values.max())
        ]
        if values.min() < values.max() and all(map(np.array_equal, *ends)):
            raise InputError("has no effect on a run", where=f"{where}: vary.{path}", right="leave it out")
