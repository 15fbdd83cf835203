"""What differs from run to run of an ensemble, turned into the arrays that the compiled loop wants, block by block."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.control import CONTROL_LAWS
from layflat.description.change import changed_all, paths, value_at
from layflat.errors import InputError
from layflat.lanes import leaves, mapped
from layflat.machine import Machine, parameters
from layflat.motion.scenario import SIGNALS, Scenario, varying
from layflat.motion.signal_values import check_whole
from layflat.sim.cycle import Acting, Around, Signals
from layflat.sim.ensemble.results import Moves, Plan, Runs
from layflat.sim.ensemble.seeds import CALM, Make, Seeds, noise_of
from layflat.sim.ensemble.varied import check_values, read_values
from layflat.sim.kernel import Case
from layflat.sim.metrics import move_windows
from layflat.sim.run import driver_of, start_angles
from layflat.sim.signals import expand, start_pressures

LEADS = ("lead", "pressure_lead", "spring", "damper")  # what may draw joints to a log, in the order of `cycle.Lead`

MAX_RUNS = 10**9

STARTS = ("angle", "pressure_a", "pressure_b")  # what every joint of a run may begin with in place of the scenario's


@dataclass(frozen=True)
class Cases:
    """An ensemble before it runs."""

    base: Machine  # the machine as described
    machine: Machine  # the same; numbers that differ from run to run are arrays
    controller: Machine  # whose controllers drive, likewise
    scenarios: list[Scenario]  # what may happen
    vary: Mapping[str, Array]  # arrays of `count` items by what they change
    count: int  # of runs
    number: type[np.floating[Any]] = np.float64  # in which the runs are computed
    plausible: bool = True  # whether scenarios that the machine can't have are refused
    _plans: dict[tuple[int, ...], tuple[Plan, Array, Array]] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def cycle(self) -> float:
        """Control cycle, s."""
        return self.controller.cycle

    @cached_property
    def which(self) -> NDArray[np.int64]:
        """Number of the scenario of each run."""
        return self.vary.get("scenario", np.zeros(self.count)).astype(np.int64)

    @cached_property
    def cycles(self) -> int:
        """Control cycles of every run."""
        return self.scenarios[0].cycles(self.cycle)

    @cached_property
    def case(self) -> Case:
        """The machine's parameters; numbers that differ from run to run are arrays."""
        closed_loop = all(scenario.closed_loop for scenario in self.scenarios)
        settings = parameters.control(self.controller, closed_loop=closed_loop)
        CONTROL_LAWS.of(settings).check_compiled("in ensembles and studies")
        return Case(
            parameters.arm(self.machine),
            parameters.joints(self.machine),
            settings,
            parameters.surroundings(self.machine),
        )

    @cached_property
    def numbers(self) -> list[Any]:
        """Every number of `case`, in order."""
        return list(leaves(self.case))

    @cached_property
    def template(self) -> tuple[Any, ...]:
        """The first run's `case`."""
        return first_of(self.case)

    @cached_property
    def _expanded(self) -> list[Signals]:
        """Return what happens in each scenario."""
        return [expand(one, self.base, self.cycle, plausible=self.plausible) for one in self.scenarios]

    @cached_property
    def _demands(self) -> list[Array]:
        return [each.named("demand") for each in self._expanded]

    @cached_property
    def moves(self) -> list[list[tuple[int, int]]]:
        """First and last record of every move of every scenario."""
        return [
            move_windows(np.concatenate([each.named("demand"), each.named("demand")[-1:]])) for each in self._expanded
        ]

    @cached_property
    def most_moves(self) -> int:
        """Greatest number of moves of any scenario."""
        return max(len(moves) for moves in self.moves)

    def at(self, rows: NDArray[np.int64], key: str, usual: Any) -> Array:
        """Values of some runs, from `vary` or as usual (a number or an array over all runs)."""
        return np.broadcast_to(np.asarray(self.vary.get(key, usual), dtype=float), self.count)[rows]

    def runs(self, rows: NDArray[np.int64], make: Make = noise_of) -> Runs:
        """Return inputs of these runs, with noise that is made so; their scenarios are numbered within `plan`."""
        own = self.which[rows]
        around = {name: value_at(self.machine, SIGNALS[name].path) for name in Around._fields}
        number = partial(np.asarray, dtype=self.number)
        return Runs(
            number(columns(self.numbers, rows)),
            np.searchsorted(np.unique(own), own),
            number(self._angles(rows, own)),
            number(self._pressures(rows, own)),
            number(self._each(rows, Acting._fields, varying("factor"), 1.0)),
            number(self._each(rows, Acting._fields, varying("adds"), 0.0)),
            number(self._each(rows, LEADS, LEADS, 0.0)),
            number(np.stack([self.at(rows, f"scenario.{name}", value) for name, value in around.items()])),
            make(self.seeds(rows), (self.cycles, len(self.base.joints)), self.number),
        )

    def _each(self, rows: NDArray[np.int64], names: Sequence[str], vary: Sequence[str], nothing: float) -> Array:
        """Return values of `names` in some runs, (joints, names, runs): `nothing` changes nothing, some `vary`."""
        found = np.full((len(self.base.joints), len(names), len(rows)), nothing)
        for (j, joint), name in product(enumerate(self.base.joints), vary):
            usual = self.vary.get(f"scenario.{name}", nothing)
            found[j, names.index(name)] = self.at(rows, f"scenario.{name}.{joint}", usual)
        return found

    def plan(self, rows: NDArray[np.int64], band: float, tip_band: float) -> tuple[Plan, Moves]:
        """Scenarios of some runs, and their moves."""
        distinct = tuple(int(s) for s in np.unique(self.which[rows]))
        if distinct not in self._plans:
            if len(self._plans) > 8:
                self._plans.clear()
            self._plans[distinct] = self._planned(distinct)
        plan, ends, goals = self._plans[distinct]
        return plan, Moves(ends, goals, band, tip_band)

    def _planned(self, distinct: Sequence[int]) -> tuple[Plan, Array, Array]:
        each = [self._expanded[s] for s in distinct]
        by_joint, shared = (np.array(of) for of in zip(*each, strict=True))
        plan = Plan(by_joint, shared, _changes(by_joint) | _changes(shared))
        ends = np.full((len(each), self.most_moves, 2), -1)
        goals = np.zeros((len(each), self.most_moves, len(self.base.joints)))
        for i, s in enumerate(distinct):
            for m, (first, last) in enumerate(self.moves[s]):
                ends[i, m] = first, last
                goals[i, m] = self._demands[s][min(last, self.cycles - 1)]
        return plan, ends, goals

    @cached_property
    def _starts(self) -> list[Array]:
        return [
            start_angles(s, self.base, e.named("demand")) for s, e in zip(self.scenarios, self._expanded, strict=True)
        ]

    def _angles(self, rows: NDArray[np.int64], own: NDArray[np.int64]) -> Array:
        """Angles at the start, (joints, runs)."""
        usual = np.array([self._starts[s] for s in own])
        return np.array([self._begun(rows, f"angle.{name}", usual[:, j]) for j, name in enumerate(self.base.joints)])

    def _pressures(self, rows: NDArray[np.int64], own: NDArray[np.int64]) -> Array:
        """Pressures at the start, (joints, 2, runs); nan for those that hold the arm."""
        pairs = np.array([start_pressures(scenario, self.base) for scenario in self.scenarios])[own]
        return np.array(
            [
                [self._begun(rows, f"pressure_{hose}.{name}", pairs[:, j, i]) for i, hose in enumerate("ab")]
                for j, name in enumerate(self.base.joints)
            ]
        )

    def _begun(self, rows: NDArray[np.int64], key: str, usual: Array) -> Array:
        """Return what some runs begin with, from `vary` or as usual in them."""
        given = self.vary.get(f"start.{key}")
        return usual if given is None else given[rows]

    def seeds(self, rows: NDArray[np.int64]) -> Seeds:
        """Seeds of the noise of some runs."""
        usual = np.array([scenario.seed if scenario.noise else CALM for scenario in self.scenarios])[self.which[rows]]
        given = self.vary.get("seed")
        return usual if given is None else np.where(usual == CALM, CALM, given[rows].astype(np.int64))


def cases(
    machine: Machine,
    scenarios: list[Scenario],
    vary: Mapping[str, Any],
    runs: int | None,
    *,
    together: bool = True,
    controller: Machine | None = None,
    number: type[np.floating[Any]] = np.float64,
    plausible: bool = True,
) -> Cases:
    """Return an ensemble from what varies in it.

    Args:
        machine: the machine.
        scenarios: all that may happen.
        vary: one value a run by what it changes.
        runs: how many; only needed where nothing varies.
        together: whether values that vary are also checked together; unless that is done elsewhere.
        controller: the machine whose controllers drive; what varies of them is this one's. Default: each run's own.
        number: type of number in which runs are computed.
        plausible: whether values of scenarios that the machine can't have are refused; logs may hold such.

    Raises:
        InputError: something that varies is unknown, or has another number of runs than the rest.
    """
    arrays = {key: read_values(machine, key, values) for key, values in vary.items()}
    if plausible:
        for key, values in arrays.items():
            check_values(machine, key, values)
    counts = {len(values) for values in arrays.values()}
    if runs is not None:
        counts.add(check_whole(runs, "runs", 1, MAX_RUNS))
    if len(counts) > 1:
        each = {key: len(values) for key, values in arrays.items()} | ({} if runs is None else {"runs": runs})
        lengths = ", ".join(f"{key}: {count}" for key, count in each.items())
        raise InputError(f"has different numbers of runs ({lengths})", where="vary", right="give one number a run")
    lasting = {scenario.cycles(driver_of(machine, controller).cycle) for scenario in scenarios}
    if len(lasting) != 1:
        raise InputError("are not equally long", where="scenario", right="give all the same duration")
    own = {key: values for key, values in arrays.items() if key not in _settings(machine)}
    theirs = {key: own.pop(key) for key in list(own) if controller is not None and key.startswith("controller.")}
    varied = _varied(machine, own, together=together)
    driving = varied if controller is None else _varied(controller, theirs, together=together)
    which = arrays.get("scenario", np.zeros(1))
    if not np.isin(which, np.arange(len(scenarios))).all():
        raise InputError(
            f"{which.max():g} is not a scenario", where="vary: scenario", right=f"0 to {len(scenarios) - 1}"
        )
    return Cases(machine, varied, driving, scenarios, arrays, counts.pop() if counts else 1, number, plausible)


def _changes(shaped: Array) -> NDArray[np.bool_]:
    """Cycles with a number that the one before has not, (scenarios, cycles), of (scenarios, cycles, ...)."""
    flat = shaped.reshape(*shaped.shape[:2], -1)
    changes = np.ones(flat.shape[:2], bool)
    before, after = flat[:, :-1], flat[:, 1:]
    changes[:, 1:] = ~((before == after) | np.isnan(before) & np.isnan(after)).all(axis=-1)
    return changes


def _varied(machine: Machine, own: Mapping[str, Array], *, together: bool) -> Machine:
    """A machine with arrays at some of its paths."""
    known = set(paths(machine))
    for key in own:
        if key == "controller.cycle":
            raise InputError("is the same in all runs", where=f"vary: {key}", right="run an ensemble for each cycle")
        if key not in known:
            value_at(machine, key)
            raise InputError("is not a single number", where=f"vary: {key}", right=f"give one of its parts, or {key}.0")
    return changed_all(machine, own, together=together)


def _settings(machine: Machine) -> set[str]:
    """Keys of `vary` that are no paths of the machine."""
    on_top = {f"scenario.{key}" for key in (*varying("factor"), *varying("adds"), *LEADS)}
    on_top |= {f"{key}.{name}" for key in on_top for name in machine.joints}
    begun = {f"start.{key}.{name}" for key in STARTS for name in machine.joints}
    return on_top | begun | {"scenario", "seed", *(f"scenario.{name}" for name in Around._fields)}


def columns(numbers: Sequence[Any], rows: NDArray[np.int64]) -> Array:
    """Numbers of a case in order, a column a run: (numbers, runs); those that differ are arrays over all runs."""
    same = [0.0 if isinstance(number, np.ndarray) else number for number in numbers]
    found = np.repeat(np.array(same, float)[:, None], len(rows), axis=1)
    for place, number in zip(found, numbers, strict=True):
        if isinstance(number, np.ndarray):
            place[:] = number[rows]
    return found


def first_of(case: tuple[Any, ...]) -> tuple[Any, ...]:
    """A nested tuple with the numbers of the first run."""
    first: tuple[Any, ...] = mapped(case, lambda leaf: float(np.ravel(leaf)[0]))
    return first
