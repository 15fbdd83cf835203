"""Machines of a batch, their starts and their inputs, as arrays of the kernel."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from layflat.arrays import Array
from layflat.control import CONTROL_LAWS, Demand, Sensed, step, wake
from layflat.description.change import value_at
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.lanes import Like, in_lanes, leaves
from layflat.machine import Machine
from layflat.motion.scenario import MAX_SEED, SIGNALS, Scenario, signals_varied_by
from layflat.motion.signal_values import Angles, check_integer
from layflat.physics.adjustable import FULL_FRACTIONS
from layflat.physics.driver import ZERO_COMMANDS
from layflat.physics.joint import AirLedger
from layflat.physics.plant import states_at_rest
from layflat.registers import host_width as lanes_of
from layflat.sim.batch.actions import FULL_OPENING_ERROR, ActionKind
from layflat.sim.batch.arrays import ArmCarry, BatchArrays, Shapes, allocate_arrays, array_shapes, rows_of
from layflat.sim.batch.kernel import RestStarts, begin_arms, renew_noise
from layflat.sim.ensemble.cases import Cases, prepare_cases
from layflat.sim.ensemble.parallel import check_vary, lane_bytes
from layflat.sim.ensemble.seeds import NO_SEED, Seeds, seed_streams, ziggurat_tables
from layflat.sim.loop import InjectionGains, JointSignals, SharedSignals

CACHE_LINE_BYTES = 64
ROWS_OF_ARMS = 2  # axes of angles given by arm and joint


@dataclass(frozen=True)
class BatchModel:
    """All that the arms of a batch have in common."""

    machine: Machine
    controller: Machine | None  # whose control law drives; None: each arm's own
    action: ActionKind
    number: type[np.floating[Any]]  # type of the numbers
    noise: bool

    def cases(self, vary: Mapping[str, Any], count: int, scenario: Scenario) -> Cases:
        """Return the machines of some arms with their starts, checked.

        Args:
            vary: values, one per arm, by the key that they change; see `ensemble`.
            count: number of arms.
            scenario: start, pressures and noise.

        Raises:
            InputError: a key, a value or a start is wrong.
        """
        prepared = prepare_cases(self.machine, [scenario], vary, count, controller=self.controller, number=self.number)
        return replace(prepared, idle=not self.action.demands)

    @cached_property
    def nominal(self) -> Any:
        """Parameters of the machine as described, a `Case`."""
        return self.cases({}, 1, Scenario(start=0.0)).template

    @cached_property
    def case_like(self) -> Like:
        """Structure of a `Case`."""
        return Like.from_tuple(self.nominal, lane_bytes(len(self.nominal.joints)))

    @property
    def lanes(self) -> int:
        """Number of arms that the kernel moves side by side."""
        return lanes_of(np.dtype(self.number).itemsize, self.case_like.max_bytes)

    @cached_property
    def _carry(self) -> ArmCarry:
        """State of the machine as described, for its structure."""
        case, n = self.nominal, len(self.nominal.joints)
        CONTROL_LAWS.kind_of(case.settings).check_compiled("in a batch")
        zeros, unset = (0.0,) * n, (float("nan"),) * n
        sensed, demand = Sensed(zeros, zeros), Demand(zeros, zeros, zeros, zeros)
        states = states_at_rest(case.arm, case.joints, zeros, unset, unset, case.air)
        memory = in_lanes(wake(case.settings, sensed), 0.0)
        _, _, report = step(case.settings, memory, sensed, demand, self.cycle)
        return ArmCarry(
            tuple(state._replace(ledger=AirLedger(0.0)) for state in states),
            (ZERO_COMMANDS,) * n, (FULL_FRACTIONS,) * n, memory, zeros, in_lanes(report, 0.0),
        )  # fmt: skip

    @cached_property
    def carry_like(self) -> Like:
        """Structure of an `ArmCarry`."""
        return Like.from_tuple(self._carry, self.case_like.max_bytes)

    @cached_property
    def carry_rows(self) -> ArmCarry:
        """Number of the row of every number of an `ArmCarry`."""
        rows: ArmCarry = rows_of(self.carry_like.value)
        return rows

    @cached_property
    def shapes(self) -> Shapes:
        """Shapes of the arrays without their last axis."""
        numbers, carried = (sum(1 for _ in leaves(like.value)) for like in (self.case_like, self.carry_like))
        return array_shapes(numbers, carried, len(self.nominal.joints))

    @property
    def cycle(self) -> float:
        """Control cycle, s."""
        return (self.controller or self.machine).cycle

    @cached_property
    def structure(self) -> str:
        """Machine and structure of all numbers, as a text: equal texts mean that a state of one batch fits another."""
        machines = self.machine.fingerprint, (self.controller or self.machine).fingerprint
        return f"{machines} {self.case_like.text} {self.carry_like.text} {self.number.__name__}"

    def read_starts(self, start: Angles | Array, count: int) -> tuple[Angles, dict[str, Array]]:
        """Return the row of angles of all arms, and those by arm as keys of `vary`.

        Args:
            start: angles as in a scenario, or an array (arms, joints), rad.
            count: number of arms.

        Raises:
            InputError: the array has another shape.
        """
        if not isinstance(start, np.ndarray) or start.ndim < ROWS_OF_ARMS:
            return start.tolist() if isinstance(start, np.ndarray) else start, {}
        if start.shape != (count, len(self.machine.joints)):
            right = f"give one row of angles for all, or {count} rows of {len(self.machine.joints)}"
            raise InputError(f"has shape {start.shape}", where="start", right=right)
        return 0.0, {f"start.angle.{name}": start[:, j] for j, name in enumerate(self.machine.joints)}

    def neutral(self, key: str) -> float:
        """Return the value of a key of `vary` that changes nothing."""
        scope, _, rest = key.partition(".")
        name = rest.partition(".")[0]
        if scope != "scenario":
            owner = self.controller if scope == "controller" and self.controller else self.machine
            return float(value_at(owner, key))
        if name in SharedSignals._fields:
            return float(value_at(self.machine, SIGNALS[name].path))
        return 1.0 if name in signals_varied_by("factor") else 0.0

    def arrays_at_rest(self, prepared: Cases, seeds: Seeds) -> BatchArrays:
        """Return the arrays of arms at rest, padded with copies of the last one.

        Args:
            prepared: machines and starts.
            seeds: of the noise, (arms,).
        """
        rows = self._padded(prepared.count)
        arrays = allocate_arrays(self.shapes, len(rows), self.number)
        runs = prepared.runs(rows, _no_noise)
        arrays.parameters[:], arrays.injections[:], arrays.shared[:] = runs.parameters, runs.injections, runs.shared
        arrays.acting[:] = _resting_signals(self.machine, runs.angles) * runs.factors + runs.added
        if self.action.regulates:
            span = self.valve_rows("volts_to_full", arrays)
            arrays.injections[:, InjectionGains._fields.index("pressure")] = span / FULL_OPENING_ERROR
        begin_arms(self.case_like, arrays, RestStarts(runs.angles, runs.pressures))
        self._renew_noise(arrays, seeds[rows])
        return arrays

    def with_noise_of(self, arrays: BatchArrays, seeds: Seeds) -> BatchArrays:
        """Return copies of the arrays of some arms, padded, with the noise of new seeds, (arms,)."""
        rows = self._padded(len(seeds))
        copies = BatchArrays(*(np.ascontiguousarray(array[..., rows]) for array in arrays))
        self._renew_noise(copies, seeds[rows])
        return copies

    def _padded(self, count: int) -> NDArray[np.intp]:
        """Return the numbers of arms with that of the last one repeated until all groups of lanes are full.

        Rows take an odd number of cache lines: those of a power of two would share a few places of the cache.
        """
        groups = -(-count // self.lanes)
        group_bytes = self.lanes * np.dtype(self.number).itemsize
        while groups * group_bytes % (2 * CACHE_LINE_BYTES) != CACHE_LINE_BYTES and count > self.lanes:
            groups += 1
        return np.minimum(np.arange(self.lanes * groups), count - 1)

    def _renew_noise(self, arrays: BatchArrays, seeds: Seeds) -> None:
        """Start the noise of padded arrays from seeds, (arms,)."""
        arrays.streams[:] = seed_streams(seeds if self.noise else np.full_like(seeds, NO_SEED))
        renew_noise(self.case_like, self.carry_like, arrays, ziggurat_tables())

    def valve_rows(self, name: str, arrays: BatchArrays) -> Array:
        """Return a number of the valves, (joints, arms), by its name, in the unit of the valve's parameters."""
        rows = [getattr(joint.valve, name) for joint in rows_of(self.case_like.value).joints]
        return arrays.parameters[rows]


def read_vary(vary: Mapping[str, Any] | None) -> Mapping[str, Any]:
    """Return the table of what varies.

    Raises:
        InputError: it is no table, or has a key for which a batch has an argument.
    """
    table = {} if vary is None else check_vary(vary)
    for key, right in (("seed", "give the argument seed"), ("scenario", "give actions and `inputs`")):
        if key in table:
            raise InputError("does not vary in a batch", where=f"vary: {key}", right=right)
    return table


def read_seeds(seed: ArrayLike, count: int) -> Seeds:
    """Return the seed of each arm's noise, (arms,).

    Args:
        seed: that of the first arm, of which each further arm has the next; or one per arm.
        count: number of arms.

    Raises:
        InputError: it is no such number, or out of range.
    """
    given = np.asarray(seed)
    if given.dtype.kind not in "iu" or given.shape not in {(), (count,)}:
        what = f"{shown(seed)} is neither a whole number nor {count} of them"
        raise InputError(what, where="seed", right="give the seed of the first arm, or one per arm")
    for bound in (int(given.min()), int(given.max())):
        check_integer(bound, "seed", 0, MAX_SEED)
    return given.astype(np.int64) if given.ndim else int(given) + np.arange(count)


def _no_noise(seeds: Seeds, shape: tuple[int, int], number: type[np.floating[Any]]) -> Array:
    """Return no noise in place of that of whole runs: the arms of a batch draw theirs cycle by cycle."""
    return np.zeros((1, shape[1], 2, len(seeds)), number)


def _resting_signals(machine: Machine, angles: Array) -> Array:
    """Return the signals of joints that rest at the angles (joints, arms), rad, as (joints, signals, arms)."""
    usual = {name: SIGNALS[name].usual_of(machine) for name in JointSignals._fields}
    unset = JointSignals(**usual)._replace(opening=np.nan, voltage=np.nan)
    signals = np.repeat(np.array(unset)[None, :, None], len(angles), axis=0).repeat(angles.shape[1], axis=2)
    signals[:, JointSignals._fields.index("demand")] = angles
    return signals.astype(angles.dtype)
