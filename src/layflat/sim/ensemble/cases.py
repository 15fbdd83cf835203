"""Inputs that vary from run to run of an ensemble, as arrays of the compiled loop, block by block."""

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
from layflat.motion.scenario import SIGNALS, Scenario, signals_varied_by
from layflat.motion.signal_values import check_integer
from layflat.sim.ensemble.results import MoveArrays, Runs, ScenarioArrays
from layflat.sim.ensemble.seeds import NO_SEED, NoiseSource, Seeds, make_noise
from layflat.sim.ensemble.varied import check_values, read_values
from layflat.sim.loop import Case, JointSignals, SharedSignals, Signals
from layflat.sim.metrics import move_windows
from layflat.sim.run import controlling_machine, start_angles
from layflat.sim.signals import expand_scenario, start_pressures

INJECTION_KEYS = ("lead", "pressure_lead", "spring", "damper")
"""Keys `scenario.KEY` of `vary` that set gains of the output injection, in the order of `loop.InjectionGains`."""

START_KEYS = ("angle", "pressure_a", "pressure_b")
"""Keys `start.KEY.JOINT` of `vary` that replace the scenario's state at the start."""

MAX_RUNS = 10**9
MAX_CACHED_ARRAYS = 8  # arrays of scenarios that are kept, by the scenarios in them


@dataclass(frozen=True)
class Cases:
    """An ensemble before it runs."""

    base: Machine  # the machine as described
    machine: Machine  # the same; numbers that vary are arrays over the runs
    controller: Machine  # the machine whose controllers drive; numbers that vary are arrays
    scenarios: list[Scenario]  # of which each run has one
    vary: Mapping[str, Array]  # values, (count,), by the key that they change
    count: int  # of runs
    number: type[np.floating[Any]] = np.float64  # type in which the runs are computed
    plausible: bool = True  # whether scenarios that are not plausible for the machine are refused
    idle: bool = False  # whether the control law only observes, whatever the scenarios
    _arrays: dict[tuple[int, ...], tuple[ScenarioArrays, Array, Array]] = field(
        default_factory=dict, init=False, repr=False
    )

    @cached_property
    def cycle(self) -> float:
        """Control cycle, s."""
        return self.controller.cycle

    @cached_property
    def scenario_index(self) -> NDArray[np.int64]:
        """Number of each run's scenario, (runs,)."""
        return self.vary.get("scenario", np.zeros(self.count)).astype(np.int64)

    @cached_property
    def cycles(self) -> int:
        """Number of control cycles, the same in all runs."""
        return self.scenarios[0].cycles(self.cycle)

    @cached_property
    def case(self) -> Case:
        """Parameters of the machine; numbers that vary are arrays over the runs.

        Raises:
            KindError: the control law can't be compiled.
        """
        closed_loop = all(scenario.closed_loop for scenario in self.scenarios)
        settings = (
            parameters.idle_control(self.controller)
            if self.idle
            else parameters.control(self.controller, closed_loop=closed_loop)
        )
        CONTROL_LAWS.kind_of(settings).check_compiled("in ensembles and studies")
        return Case(
            parameters.arm(self.machine),
            parameters.joints(self.machine),
            settings,
            parameters.surroundings(self.machine),
        )

    @cached_property
    def numbers(self) -> list[Any]:
        """All numbers of `case`, in order."""
        return list(leaves(self.case))

    @cached_property
    def template(self) -> tuple[Any, ...]:
        """Parameters of the first run."""
        return first_run(self.case)

    @cached_property
    def _expanded(self) -> list[Signals]:
        """Signals of each scenario over control cycles."""
        return [
            expand_scenario(scenario, self.base, self.cycle, plausible=self.plausible) for scenario in self.scenarios
        ]

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
    def max_moves(self) -> int:
        """Maximum number of moves of any scenario."""
        return max(len(moves) for moves in self.moves)

    def values(self, rows: NDArray[np.int64], key: str, usual: Any) -> Array:
        """Return the values of a key in some runs.

        Args:
            rows: numbers of the runs.
            key: key of `vary`.
            usual: value where the key does not vary: a number, or an array over all runs.
        """
        return np.broadcast_to(np.asarray(self.vary.get(key, usual), dtype=float), self.count)[rows]

    def runs(self, rows: NDArray[np.int64], make: NoiseSource = make_noise) -> Runs:
        """Return the inputs of some runs; their scenarios are numbered as in `scenario_arrays` of the same runs.

        Args:
            rows: numbers of the runs.
            make: source of the sensors' noise.
        """
        scenarios = self.scenario_index[rows]
        around = {name: value_at(self.machine, SIGNALS[name].path) for name in SharedSignals._fields}
        number = partial(np.asarray, dtype=self.number)
        return Runs(
            number(parameter_columns(self.numbers, rows)),
            np.searchsorted(np.unique(scenarios), scenarios),
            number(self._angles(rows, scenarios)),
            number(self._pressures(rows, scenarios)),
            number(self._joint_values(rows, JointSignals._fields, signals_varied_by("factor"), 1.0)),
            number(self._joint_values(rows, JointSignals._fields, signals_varied_by("adds"), 0.0)),
            number(self._joint_values(rows, INJECTION_KEYS, INJECTION_KEYS, 0.0)),
            number(np.stack([self.values(rows, f"scenario.{name}", value) for name, value in around.items()])),
            make(self.seeds(rows), (self.cycles, len(self.base.joints)), self.number),
        )

    def _joint_values(
        self, rows: NDArray[np.int64], names: Sequence[str], vary: Sequence[str], neutral: float
    ) -> Array:
        """Return factors, terms or gains of `names` in some runs, (joints, names, runs).

        Those of the names in `vary` come from the ensemble's keys; the rest are `neutral`, which has no effect.
        """
        values = np.full((len(self.base.joints), len(names), len(rows)), neutral)
        for (j, joint), name in product(enumerate(self.base.joints), vary):
            usual = self.vary.get(f"scenario.{name}", neutral)
            values[j, names.index(name)] = self.values(rows, f"scenario.{name}.{joint}", usual)
        return values

    def scenario_arrays(
        self, rows: NDArray[np.int64], band: float, tip_band: float
    ) -> tuple[ScenarioArrays, MoveArrays]:
        """Return the scenarios of some runs, each once and by number, and their moves; signals are cached.

        Args:
            rows: numbers of the runs.
            band: settling band of a joint, rad.
            tip_band: settling band of the tip, m.
        """
        distinct = tuple(int(s) for s in np.unique(self.scenario_index[rows]))
        if distinct not in self._arrays:
            if len(self._arrays) >= MAX_CACHED_ARRAYS:
                self._arrays.clear()
            self._arrays[distinct] = self._stack_scenarios(distinct)
        signals, ends, goals = self._arrays[distinct]
        return signals, MoveArrays(ends, goals, band, tip_band)

    def _stack_scenarios(self, distinct: Sequence[int]) -> tuple[ScenarioArrays, Array, Array]:
        """Return the signals of distinct scenarios, stacked, first and last cycle of each move, and its goals (rad).

        Moves that a scenario lacks have ends of -1.
        """
        each = [self._expanded[s] for s in distinct]
        by_joint, shared = (np.array(arrays) for arrays in zip(*each, strict=True))
        signals = ScenarioArrays(by_joint, shared, _changed_cycles(by_joint) | _changed_cycles(shared))
        ends = np.full((len(each), self.max_moves, 2), -1)
        goals = np.zeros((len(each), self.max_moves, len(self.base.joints)))
        for i, s in enumerate(distinct):
            for m, (first, last) in enumerate(self.moves[s]):
                ends[i, m] = first, last
                goals[i, m] = self._demands[s][min(last, self.cycles - 1)]
        return signals, ends, goals

    @cached_property
    def _starts(self) -> list[Array]:
        """Angles at which the arm rests at the start of each scenario, (joints,), rad."""
        return [
            start_angles(s, self.base, e.named("demand")) for s, e in zip(self.scenarios, self._expanded, strict=True)
        ]

    def _angles(self, rows: NDArray[np.int64], scenarios: NDArray[np.int64]) -> Array:
        """Return the angles at the start, (joints, runs), rad."""
        usual = np.array([self._starts[s] for s in scenarios])
        return np.array(
            [self._start_values(rows, f"angle.{name}", usual[:, j]) for j, name in enumerate(self.base.joints)]
        )

    def _pressures(self, rows: NDArray[np.int64], scenarios: NDArray[np.int64]) -> Array:
        """Return the pressures at the start, (joints, 2, runs), absolute, Pa; NaN for those that hold the arm."""
        pairs = np.array([start_pressures(scenario, self.base) for scenario in self.scenarios])[scenarios]
        return np.array(
            [
                [self._start_values(rows, f"pressure_{hose}.{name}", pairs[:, j, i]) for i, hose in enumerate("ab")]
                for j, name in enumerate(self.base.joints)
            ]
        )

    def _start_values(self, rows: NDArray[np.int64], key: str, usual: Array) -> Array:
        """Return the values at the start of some runs, (runs,): from `vary`, else `usual`."""
        varied = self.vary.get(f"start.{key}")
        return usual if varied is None else varied[rows]

    def seeds(self, rows: NDArray[np.int64]) -> Seeds:
        """Return the noise seeds of some runs, (runs,); `NO_SEED` for runs without noise."""
        usual = np.array([scenario.seed if scenario.noise else NO_SEED for scenario in self.scenarios])[
            self.scenario_index[rows]
        ]
        varied = self.vary.get("seed")
        return usual if varied is None else np.where(usual == NO_SEED, NO_SEED, varied[rows].astype(np.int64))


def prepare_cases(
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
    """Return an ensemble, checked.

    Args:
        machine: the machine.
        scenarios: scenarios of which each run has one, by the key "scenario" of `vary`.
        vary: values, one per run, by the key that they change.
        runs: number of runs; only needed if nothing varies.
        together: whether the machines that result are also checked as a whole; False if the caller does so.
        controller: the machine whose controllers drive; keys of `vary` that begin with "controller." then change this
            one. Default: each run's own machine.
        number: type of number in which runs are computed.
        plausible: whether to refuse signals that are not plausible for the machine; logs may hold such.

    Raises:
        InputError: a key or value of `vary` is wrong, or keys have different numbers of runs; the scenarios have
            different durations; the controller has other joints.
    """
    arrays = {key: read_values(machine, key, values) for key, values in vary.items()}
    if plausible:
        for key, values in arrays.items():
            check_values(machine, key, values)
    counts = {len(values) for values in arrays.values()}
    if runs is not None:
        counts.add(check_integer(runs, "runs", 1, MAX_RUNS))
    if len(counts) > 1:
        each = {key: len(values) for key, values in arrays.items()} | ({} if runs is None else {"runs": runs})
        lengths = ", ".join(f"{key}: {count}" for key, count in each.items())
        raise InputError(f"has different numbers of runs ({lengths})", where="vary", right="give one number a run")
    durations = {scenario.cycles(controlling_machine(machine, controller).cycle) for scenario in scenarios}
    if len(durations) != 1:
        raise InputError("are not equally long", where="scenario", right="give all the same duration")
    of_plant = {key: values for key, values in arrays.items() if key not in _keys_outside_machine(machine)}
    of_controller = {
        key: of_plant.pop(key) for key in list(of_plant) if controller is not None and key.startswith("controller.")
    }
    varied = _with_arrays(machine, of_plant, together=together)
    driving = varied if controller is None else _with_arrays(controller, of_controller, together=together)
    indices = arrays.get("scenario", np.zeros(1))
    unknown = indices[~np.isin(indices, np.arange(len(scenarios)))]
    if len(unknown):
        raise InputError(
            f"{unknown[0]:g} is not a scenario", where="vary: scenario", right=f"give 0 to {len(scenarios) - 1}"
        )
    return Cases(machine, varied, driving, scenarios, arrays, counts.pop() if counts else 1, number, plausible)


def _changed_cycles(signals: Array) -> NDArray[np.bool_]:
    """Return whether any number of (scenarios, cycles, ...) differs from the cycle before, (scenarios, cycles).

    The first cycle counts as changed; NaN equals NaN.
    """
    flat = signals.reshape(*signals.shape[:2], -1)
    changes = np.ones(flat.shape[:2], bool)
    before, after = flat[:, :-1], flat[:, 1:]
    changes[:, 1:] = ~((before == after) | np.isnan(before) & np.isnan(after)).all(axis=-1)
    return changes


def _with_arrays(machine: Machine, arrays: Mapping[str, Array], *, together: bool) -> Machine:
    """Return a machine with arrays over the runs at some of its paths.

    Raise InputError for a path of no number, for the control cycle, and for a value that is not valid there.
    """
    numbers = set(paths(machine))
    for key in arrays:
        if key == "controller.cycle":
            raise InputError("is the same in all runs", where=f"vary: {key}", right="run an ensemble for each cycle")
        if key not in numbers:
            value_at(machine, key)
            raise InputError("is not a single number", where=f"vary: {key}", right=f"give one of its parts, or {key}.0")
    return changed_all(machine, arrays, together=together)


def _keys_outside_machine(machine: Machine) -> set[str]:
    """Return the keys of `vary` that are no paths of the machine: signals, starts, scenario and seed."""
    on_top = {f"scenario.{key}" for key in (*signals_varied_by("factor"), *signals_varied_by("adds"), *INJECTION_KEYS)}
    on_top |= {f"{key}.{name}" for key in on_top for name in machine.joints}
    begun = {f"start.{key}.{name}" for key in START_KEYS for name in machine.joints}
    return on_top | begun | {"scenario", "seed", *(f"scenario.{name}" for name in SharedSignals._fields)}


def parameter_columns(numbers: Sequence[Any], rows: NDArray[np.int64]) -> Array:
    """Return the numbers of a case in some runs, (numbers, runs); numbers that vary are arrays over all runs."""
    constants = [0.0 if isinstance(number, np.ndarray) else number for number in numbers]
    columns = np.repeat(np.array(constants, float)[:, None], len(rows), axis=1)
    for row, number in zip(columns, numbers, strict=True):
        if isinstance(number, np.ndarray):
            row[:] = number[rows]
    return columns


def first_run(case: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a case with the numbers of the first run."""
    first: tuple[Any, ...] = mapped(case, lambda leaf: float(np.ravel(leaf)[0]))
    return first
