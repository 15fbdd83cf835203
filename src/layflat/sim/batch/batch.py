"""Many arms that their caller steps: `Batch`. Read in this order: batch.py, prepare.py, arrays.py, kernel.py."""

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from math import ceil
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from layflat.arrays import Array
from layflat.control import CONTROL_LAWS
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.memory import check_memory
from layflat.motion.scenario import MAX_SEED, Scenario
from layflat.motion.signal_values import Angles, Pair, Value, check_bool, check_integer
from layflat.physics.step import STEP
from layflat.sim.batch.actions import find_action
from layflat.sim.batch.arrays import (
    INPUT_SIGNALS,
    STATE_SIGNALS,
    BatchArrays,
    bytes_per_arm,
    copy_arms,
    input_views,
    report_views,
    state_views,
)
from layflat.sim.batch.kernel import step_arms
from layflat.sim.batch.prepare import ROWS_OF_ARMS, BatchModel, read_seeds, read_vary
from layflat.sim.batch.state import BatchState, check_arms
from layflat.sim.ensemble.parallel import MAX_THREADS, number_type
from layflat.sim.ensemble.seeds import Seeds, ziggurat_tables
from layflat.sim.ensemble.varied import read_values
from layflat.sim.run import controlling_machine, make_timing

MAX_ARMS = 10**8
MAX_CYCLES = 10**9  # in a call of `step`
MIN_ARMS_PER_THREAD = 128  # fewer take less time than to wake a thread
BEGINNING_COPIES = 2.0  # copies of the arrays in memory while arms begin


class Batch:
    """Many arms that their caller moves by one control cycle, or several, at a time.

    They begin at rest. Each passes through the states of a rollout with the same machine, start, inputs and seed, bit
    for bit, wherever it stands in the batch, and on any number of threads; in single precision through those of an
    ensemble. Arrays are views of the kernel's own memory: they change with every step, and cost nothing to read.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        count: number of arms.
        vary: a number (SI) or text with a unit per arm, by the key that it changes, as in `ensemble`: any number of
            the machine, "scenario.payload", "scenario.supply", "scenario.brake", "scenario.load", "scenario.drift".
        action: kind of the actions of `step`: "demand" (rad) for the control law, "opening" of the valves (-1 to 1),
            "voltage" of their drivers, or differential "pressure" (Pa), which a proportional regulator follows that
            opens the valve fully at an error of 1 bar. Without demands the control law only observes.
        controller: the machine whose control law drives, as in `rollout`; default: each arm's own.
        start: angles at which the arms rest at first, as in a scenario, or an array (arms, joints), rad.
        pressures: absolute pressures of hoses A and B at the start; default: those that hold the arm.
        noise: whether the sensors are noisy.
        seed: seed of the first arm's noise, of which each further arm has the next; or a seed per arm.
        step: time step of the plant; rounded so that a control cycle is a whole number of steps; a number is in s.
        precision: "double" or "single", of all numbers. Dither keeps its phase to 0.01 rad for ten minutes in single.
        threads: number of threads; default: one per core. Results do not depend on it.
        clip: whether actions beyond their range are replaced by the nearest in it; default: they are refused.

    Attributes:
        joints: names of the joints.
        action_limits: least and greatest action of every joint, (joints,) each.
        inputs: writable arrays of the signals that act from the next step on, by name: those of `INPUT_SIGNALS`; of
            joints (arms, joints), of the arm (arms,), SI, `nan` for an opening or voltage that is not set.
        report: arrays of the control law's report, (arms, joints), by the names of its signals.
        units: unit and meaning of every array, and of "action", by name.
        arrays: memory of the kernel with the arms last, padding included (see `BatchArrays`), for further kernels.

    Raises:
        InputError: a machine or an argument is wrong, or memory does not hold so many arms.
        KindError: the control law is plain Python.

    Example:
        >>> import layflat as lf
        >>> import numpy as np
        >>> batch = lf.Batch("paper-arm", 64, vary={"arm.payload": np.linspace(0.5, 2.5, 64)})
        >>> for _ in range(300):  # 1.5 s
        ...     batch.step(np.full((64, 2), 0.3))
        >>> bool((abs(batch.angle - 0.3) < 0.02).all())
        True
    """

    angle: Array
    velocity: Array
    pressure_a: Array
    pressure_b: Array
    voltage: Array
    sensed_angle: Array
    sensed_pressure: Array
    valve_opening: Array
    tip: Array
    diverged: NDArray[np.bool_]

    def __init__(
        self,
        machine: str | Path | Machine,
        count: int,
        *,
        vary: Mapping[str, Any] | None = None,
        action: str = "demand",
        controller: str | Path | Machine | None = None,
        start: Angles | Array = 0.0,
        pressures: Pair | Mapping[str, Pair] | None = None,
        noise: bool = True,
        seed: ArrayLike = 0,
        step: Value = STEP,
        precision: str = "double",
        threads: int | None = None,
        clip: bool = False,
    ) -> None:
        self.machine, self.count = load(machine), check_integer(count, "count", 1, MAX_ARMS)
        driver = None if controller is None else load(controller)
        controlling_machine(self.machine, driver)
        for flag, where in ((noise, "noise"), (clip, "clip")):
            check_bool(flag, where)
        self._model = BatchModel(self.machine, driver, find_action(action), number_type(precision), noise)
        self.joints, self.cycle = tuple(self.machine.joints), self._model.cycle
        self._timing = make_timing(self.cycle, step, 1, self.machine)
        self.action_limits, self._action, self._clip = self._model.action.limits(self.machine), action, clip
        self._check_size()
        self._vary: dict[str, Array] = {}
        self._next_seed, self._starts = 0, (start, pressures)
        seeds = self._read_seeds(seed, self.count)
        self.arrays = self._arrays_at_rest(np.arange(self.count), read_vary(vary), *self._starts, seeds)
        self._name_views()
        self._bind(os.cpu_count() or 1 if threads is None else check_integer(threads, "threads", 1, MAX_THREADS))

    def _check_size(self) -> None:
        """Raise InputError unless memory can hold the arms."""
        needed = BEGINNING_COPIES * self.count * bytes_per_arm(self._model.shapes, self._model.number)
        work = f"a batch of {self.count} arms"
        check_memory(needed, work, "count", lambda part: f"give {max(int(part * self.count), 1)} or fewer")

    def _arrays_at_rest(
        self,
        arms: NDArray[np.intp],
        vary: Mapping[str, Any],
        start: Angles | Array,
        pressures: Pair | Mapping[str, Pair] | None,
        seeds: Seeds,
    ) -> BatchArrays:
        """Return the arrays of some arms at rest, and keep what varies among them; raise InputError as `reset` does."""
        n = len(arms)
        of_arms = {key: values[arms] for key, values in self._vary.items()}
        given = {key: read_values(self.machine, key, values) for key, values in vary.items()}
        row, columns = self._model.read_starts(start, n)
        scenario = Scenario(start=row, pressures=pressures, noise=self._model.noise)
        prepared = self._model.cases({**of_arms, **columns, **given}, n, scenario)
        begun = self._model.arrays_at_rest(prepared, seeds)
        for key, values in given.items():
            if not key.startswith("start."):
                self._varied_values(key)[arms] = values
        return begun

    def _read_seeds(self, seed: ArrayLike | None, count: int) -> Seeds:
        """Return the seed of each arm's noise, by default one that no arm has had; raise InputError as `reset`."""
        seeds = read_seeds(self._next_seed if seed is None else seed, count)
        self._next_seed = max(self._next_seed, int(seeds.max()) + 1) % (MAX_SEED + 1)
        return seeds

    def _name_views(self) -> None:
        """Set the live arrays."""
        rows = self._model.carry_rows
        self.__dict__.update(state_views(self.arrays, rows, self.count))
        self.inputs = input_views(self.arrays, self.count)
        self.report = report_views(self.arrays, rows, self.count)
        reported = CONTROL_LAWS.kind_of(self._model.nominal.settings).signals
        of_action = {"action": (self._model.action.unit, self._model.action.meaning)}
        self.units = {**STATE_SIGNALS, **INPUT_SIGNALS, **reported, **of_action}

    def _bind(self, threads: int) -> None:
        """Divide the arms between threads, in whole groups of lanes, and bind the kernel to each part."""
        lanes = self._model.lanes
        size = lanes * ceil(self.count / lanes)
        parts = max(1, min(threads, size // MIN_ARMS_PER_THREAD))
        each = lanes * ceil(size / lanes / parts)
        args = self._model.case_like, self._model.carry_like, self.arrays, self._timing, ziggurat_tables()
        self._steps = [
            step_arms.bind(*args, np.zeros((1, lanes), self._model.number), first, min(first + each, size), 1)
            for first in range(0, size, each)
        ]
        self._pool = ThreadPoolExecutor(len(self._steps) - 1) if len(self._steps) > 1 else None

    @property
    def time(self) -> Array:
        """Time since each arm's start, s, (arms,)."""
        return self.arrays.cycles[: self.count] * self.cycle

    def step(self, action: ArrayLike | None = None, cycles: int = 1) -> None:
        """Move all arms by some control cycles; an arm that diverges is held, and marked in `diverged`.

        Args:
            action: (arms, joints), in the unit of the batch's kind of action; it holds for all these cycles. None: the
                action of before.
            cycles: number of control cycles.

        Raises:
            InputError: the action has another shape, or a value in it is no number or beyond `action_limits` (see
                `clip`); the batch is closed.
        """
        self._check_open()
        if action is not None:
            self._set_action(action)
        number = cycles if cycles == 1 else check_integer(cycles, "cycles", 1, MAX_CYCLES)
        if self._pool is None:
            self._steps[0](number)
            return
        waits = [self._pool.submit(bound, number) for bound in self._steps[1:]]
        self._steps[0](number)
        for wait in waits:
            wait.result()

    def _set_action(self, action: ArrayLike) -> None:
        """Write an action into the inputs; raise InputError as `step` does."""
        values = np.asarray(action)
        expected = (self.count, len(self.joints))
        if values.shape != expected or values.dtype.kind not in "fiu":
            what = f"has shape {values.shape}" if values.dtype.kind in "fiu" else f"{shown(action)} holds no numbers"
            right = f"give numbers of shape {expected}: a row per arm, a column per joint"
            raise InputError(what, where="action", right=right)
        kind = self._model.action
        values = kind.check(values, self.action_limits, self.joints, clip=self._clip)
        if kind.of_valve is not None:
            rows = (self._model.valve_rows(name, self.arrays) for name in ("centre_voltage", "volts_to_full"))
            values = kind.of_valve(values, *(row[:, : self.count].T for row in rows))
        self.inputs[kind.signal][:] = values

    def reset(
        self,
        arms: ArrayLike | None = None,
        *,
        vary: Mapping[str, Any] | None = None,
        start: Angles | Array | None = None,
        pressures: Pair | Mapping[str, Pair] | None = None,
        seed: ArrayLike | None = None,
    ) -> None:
        """Put some arms back to rest, with their inputs as at their start.

        Args:
            arms: mask (arms,), or numbers of arms; default: all.
            vary: new values for these arms, by key; a key that is left out keeps each arm's value.
            start: as in the constructor, for these arms; default: the constructor's.
            pressures: likewise.
            seed: seed of the first of these arms' noise, or one for each; default: seeds that no arm has had.

        Raises:
            InputError: there is no such arm; a key, value or start is wrong; the batch is closed.
        """
        self._check_open()
        chosen = check_arms(arms, self.count, "arms")
        if len(chosen) == 0:
            return
        angles, pair = self._starts
        if start is None and isinstance(angles, np.ndarray) and angles.ndim == ROWS_OF_ARMS:
            angles = angles[chosen]
        begun = self._arrays_at_rest(
            chosen, read_vary(vary), angles if start is None else start, pair if pressures is None else pressures,
            self._read_seeds(seed, len(chosen)),
        )  # fmt: skip
        copy_arms(begun, np.arange(len(chosen)), self.arrays, chosen)

    def state(self) -> BatchState:
        """Return a copy of the whole state of all arms."""
        arrays = BatchArrays(*(array[..., : self.count].copy() for array in self.arrays))
        return BatchState(arrays, {key: values.copy() for key, values in self._vary.items()}, self._structure)

    @property
    def _structure(self) -> str:
        """Text that is equal where states fit."""
        return f"{self._model.structure} {self._action} {self.cycle!r} {self._timing.steps}"

    def set_state(self, state: BatchState, arms: ArrayLike | None = None, *, seed: ArrayLike | None = None) -> None:
        """Set the whole state of some arms, so that they go on from there, bit for bit.

        Where machines vary, a saved state of many arms at rest, set with new seeds, is a fast way to reset some.

        Args:
            state: state of as many arms, of this batch or of one of the same kind (see `BatchState`).
            arms: mask (arms,), or numbers of arms; default: all.
            seed: seed of new noise, of the first of these arms or of each; default: the saved noise goes on.

        Raises:
            InputError: the state is one of another version, machine, action or precision, or of another number of arms;
                a seed is wrong; the batch is closed.
        """
        self._check_open()
        chosen = check_arms(arms, self.count, "arms")
        state.check_fits(self._structure, len(chosen))
        if len(chosen) == 0:
            return
        arrays = state.arrays
        if seed is not None:
            arrays = self._model.with_noise_of(arrays, self._read_seeds(seed, len(chosen)))
        copy_arms(arrays, np.arange(len(chosen)), self.arrays, chosen)
        for key in {*self._vary, *state.vary}:
            values = state.vary.get(key)
            self._varied_values(key)[chosen] = self._model.neutral(key) if values is None else values

    def _varied_values(self, key: str) -> Array:
        """Return the values of a key of `vary`, (arms,), to write; where it has not varied so far, as described."""
        if key not in self._vary:
            self._vary[key] = np.full(self.count, self._model.neutral(key))
        return self._vary[key]

    def _check_open(self) -> None:
        """Raise InputError if the batch is closed."""
        if not self._steps:
            raise InputError("is closed", where="batch", right="make a new one")

    def close(self) -> None:
        """End the threads; arrays can still be read."""
        self._steps = []
        if self._pool is not None:
            self._pool.shutdown()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
