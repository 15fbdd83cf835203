"""One machine through one scenario."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from layflat.arrays import Array
from layflat.control import CONTROL_LAWS
from layflat.description import units as u
from layflat.description.wrong import shown
from layflat.errors import DivergedError, InputError
from layflat.jit.outside import blame_outside
from layflat.lanes import Like, leaves
from layflat.machine import Machine, load, parameters
from layflat.memory import check_memory
from layflat.motion.scenario import Scenario, check_scenario
from layflat.motion.signal_rows import Signal
from layflat.motion.signal_values import Value, check_whole, checked_options, read_number
from layflat.physics.noise import sensor_noise
from layflat.physics.step import STEP
from layflat.sim.cause import find_cause
from layflat.sim.cycle import Signals
from layflat.sim.kernel import Case, Sample, Timing, all_cycles, run_cycles
from layflat.sim.signals import signals, start_pressures, start_row

if TYPE_CHECKING:
    import xarray

TELLS_EVERY = 0.25  # s
COPIES = 2.5  # of a run's records that are in memory once it is written as NetCDF
SIGNALS_HELD = 30  # numbers of each joint and control cycle that act on it, with intermediate results
MIN_STEP = 1e-8  # s
MAX_RECORDS = 10_000  # per control cycle
PERIOD_PARTS = 0.1  # step that is advised, over the period of the dither


def rollout(
    machine: str | Path | Machine,
    demand: Signal | None = None,
    *,
    step: Value = STEP,
    records: int = 1,
    scenario: Scenario | None = None,
    controller: str | Path | Machine | None = None,
    progress: Callable[[float], None] | None = None,
    **changes: Any,
) -> "xarray.Dataset":
    """Simulate a machine with its controller.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        demand: angles asked for: "40 deg", {"large": "40 deg"}, steps [("0 s", ...), ("2 s", ...)], or a table of
            pandas or xarray; default: the scenario's.
        step: of the plant; rounded so that a control cycle is a whole number of steps.
        records: instants recorded per control cycle.
        controller: the machine that the controller believes to drive, and whose controller it is, likewise; default:
            the machine.
        progress: is called every quarter of a second, from another thread, with the fraction of the run that is done.
        scenario: what happens; `demand` and `changes` (fields of `Scenario`) are laid over it.
        **changes: fields of `Scenario`, for instance `duration="4 s"`, `payload="2 kg"`, `seed=1`.

    Returns:
        A run: dims `time` and `joint`, units in the attributes (see dataset.py for the names).

    Raises:
        InputError: a machine, scenario or option is wrong.
        DivergedError: the run diverged; it carries the data up to there.
    """
    from layflat.sim.dataset import dataset  # noqa: PLC0415  # xarray takes long to import

    described = load(machine)
    if progress is not None and not callable(progress):
        raise InputError(f"{shown(progress)} can't be called", where="progress", right="give a function")
    if demand is not None:
        changes["demand"] = demand
    case = checked_options(Scenario, changes, "rollout", None if scenario is None else check_scenario(scenario))
    driver = None if controller is None else load(controller)
    prepared = prepare(described, case, step=step, records=records, controller=driver)
    with _telling(prepared, progress):
        rows, report, diverged = prepared.run()
    law = CONTROL_LAWS.of(prepared.case.settings)
    run = dataset(described, case, law, prepared.signals, prepared.timing, rows, report)
    if diverged >= 0:
        names = list(described.joints)
        cause = find_cause(described, prepared.case, prepared.signals, prepared.timing, run)
        raise DivergedError(float(run.time[-1]), names[diverged], run, cause)
    return run


@contextmanager
def _telling(prepared: "Prepared", progress: Callable[[float], None] | None) -> Iterator[None]:
    """Tell how far a run is while the block simulates it."""
    if progress is None:
        yield
        return
    over = Event()

    def tell() -> None:
        while not over.wait(TELLS_EVERY):
            progress(prepared.fraction_done)

    thread = Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def rollout_as_far(machine: str | Path | Machine, demand: Signal | None = None, **options: Any) -> "xarray.Dataset":
    """Simulate as `rollout` does, and return a run that diverged up to where it did."""
    try:
        return rollout(machine, demand, **options)
    except DivergedError as error:
        return cast("xarray.Dataset", error.run)


@dataclass(frozen=True)
class Prepared:
    """A run ready for the time loop: its arguments, in order."""

    case: Case
    angles: Array
    pressures: Array
    signals: Signals
    samples: Array  # standard normal, of the sensors, (cycles + 1, joints, 2)
    timing: Timing
    done: Array = field(default_factory=lambda: np.zeros(1))  # control cycles that a run in progress has done

    @property
    def fraction_done(self) -> float:
        """Fraction of the control cycles that a run in progress has done."""
        return float(self.done[0]) / len(self.signals.by_joint)

    @cached_property
    def _numbers(self) -> tuple[Like, Array]:
        return Like.of(self.case), np.fromiter(leaves(self.case), float)

    def run(self) -> tuple[Array, Array, int]:
        """Records up to where it diverged, and in which joint that was (-1: none).

        Returns:
            (instants, joints, columns of `Sample`), (instants, joints, signals of the control law), and the joint.
        """
        law = CONTROL_LAWS.of(self.case.settings)
        rest = self.angles, self.pressures, self.signals, self.samples, self.timing, len(law.signals), self.done
        if law.compiled:
            rows, report, valid, diverged = run_cycles(*self._numbers, *rest)
        else:
            with blame_outside():
                rows, report, valid, diverged = all_cycles(self.case, *rest)
        return rows[:valid], report[:valid], int(diverged)


def driver_of(machine: Machine, controller: Machine | None) -> Machine:
    """Return the machine whose controller drives another; raise InputError if it has other joints.

    It is the machine itself where no controller is given.
    """
    if controller is not None and list(controller.joints) != list(machine.joints):
        raise InputError(
            f"has joints {', '.join(controller.joints)}",
            where=f"controller: {controller.origin}",
            right=f"give a machine with joints {', '.join(machine.joints)}, as {machine.origin} has",
        )
    return machine if controller is None else controller


def prepare(
    machine: Machine, scenario: Scenario, *, step: Value = STEP, records: int = 1, controller: Machine | None = None
) -> Prepared:
    """Turn a machine, its scenario and who controls it (see `rollout`) into arguments of the compiled loop.

    Raises:
        InputError: a machine, scenario or option is wrong.
    """
    driver = driver_of(machine, controller)
    cycle = driver.cycle
    timing = timing_of(cycle, step, records, machine)
    _check_size(scenario.cycles(cycle), machine, timing, len(driver.control_law.signals))
    acting = signals(scenario, machine, cycle)
    return Prepared(
        Case(
            parameters.arm(machine),
            parameters.joints(machine),
            parameters.control(driver, closed_loop=scenario.closed_loop),
            parameters.surroundings(machine),
        ),
        start_angles(scenario, machine, acting.named("demand")),
        start_pressures(scenario, machine),
        acting,
        sensor_noise(scenario.seed if scenario.noise else None, len(acting.by_joint) + 1, len(machine.joints)),
        timing,
    )


def _check_size(cycles: int, machine: Machine, timing: Timing, reported: int) -> None:
    """Refuse a run that memory can't hold."""
    lasting, records = cycles * timing.cycle, timing.records
    by_cycle = 8.0 * len(machine.joints) * SIGNALS_HELD
    by_record = 8.0 * len(machine.joints) * COPIES * (len(Sample._fields) + reported + 3)
    where, work = ("records", f" with {records} records a cycle") if records > 1 else ("duration", "")

    def right(part: float) -> str:
        shorter = f"a duration of {0.9 * part * lasting:.2g} s"
        return f"give fewer, or {shorter}" if records > 1 else f"give {shorter} or less"

    check_memory(cycles * (by_cycle + records * by_record), f"a run of {lasting:g} s{work}", where, right)


def timing_of(cycle: float, step: Value, records: int, machine: Machine) -> Timing:
    """Return the cut of a run into steps of about `step`.

    Args:
        cycle: control cycle, s.
        step: of the plant.
        records: instants recorded per control cycle.
        machine: the plant; numbers in it may be arrays.

    Raises:
        InputError: the step is no part of a cycle or too long for what the valves' drivers make, or nothing is
            recorded.
    """
    wanted = read_number(step, u.TIME, "step")
    if not MIN_STEP <= wanted <= cycle:
        raise InputError(f"{wanted:g} s is out of range", where="step", right=f"give 10 ns to {cycle:g} s")
    check_whole(records, "records", 1, MAX_RECORDS)
    per_record = max(1, round(cycle / wanted / records))
    timing = Timing(cycle, per_record * records, records)
    _check_wave(machine, timing)
    return timing


def _check_wave(machine: Machine, timing: Timing) -> None:
    """Refuse steps that are too long for what the valves' drivers make by themselves."""
    frequency = None if machine.valve is None else machine.valve.wave_frequency
    if frequency is None:
        return
    fastest, step = float(np.max(frequency)), timing.cycle / timing.steps
    if fastest * step > 0.5 * (1.0 + 1e-9):
        what = f"{1e3 * step:g} ms is too long for the {fastest:g} Hz of the valves' drivers, which would be lost"
        right = f"give {1e3 * PERIOD_PARTS / fastest:.2g} ms or less"
        raise InputError(what, where="step", right=right)


def start_angles(scenario: Scenario, machine: Machine, demand: Array) -> Array:
    """Return the angles at which the arm rests at first, (joints,), rad: those of the demand where none are given."""
    start = start_row(scenario, machine)
    return np.array(demand[0]) if start is None else start
