"""One machine through one scenario."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, TypedDict, Unpack, cast

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.control import CONTROL_LAWS
from layflat.description import units as u
from layflat.description.wrong import shown
from layflat.errors import DivergedError, InputError
from layflat.jit.outside import blame_outside
from layflat.keywords import with_keywords_of
from layflat.lanes import Like, leaves
from layflat.machine import Machine, load, parameters
from layflat.memory import check_memory
from layflat.motion.scenario import Scenario, check_scenario
from layflat.motion.signal_rows import Signal
from layflat.motion.signal_values import Angles, Pair, Value, build_options, check_integer, read_number
from layflat.physics.sensor import sensor_noise
from layflat.physics.step import STEP
from layflat.sim.cause import find_cause
from layflat.sim.kernel import COLUMNS, JointRecord, run_cycles
from layflat.sim.loop import Case, Signals, Timing
from layflat.sim.signals import acting_signals, read_start_angles, start_pressures

if TYPE_CHECKING:
    import xarray

    from layflat.sim.results import Run

PROGRESS_PERIOD = 0.25  # between two reports of progress, s
RECORD_COPIES = 2.5  # copies of a run's records that memory holds while it is written as NetCDF
HELD_NUMBERS = 30  # numbers that the signals take per joint and control cycle, with intermediate results
MIN_STEP = 1e-8  # s
MAX_RECORDS = 10_000  # per control cycle
ADVISED_PERIOD_FRACTION = 0.1  # step that an error advises, over the period of the dither


class ScenarioFields(TypedDict, total=False):
    """Fields of a `Scenario` as keyword arguments of other functions."""

    tip: Signal | None
    demand_velocity: Signal | None
    demand_acceleration: Signal | None
    demand_stiffness: Signal
    duration: Value
    start: Angles | None
    opening: Signal | None
    voltage: Signal | None
    brake: Signal
    dither: Signal
    load: Signal
    drift: Signal
    supply: Signal | None
    payload: Signal | None
    ambient: Signal | None
    pressures: Pair | Mapping[str, Pair] | None
    noise: bool
    seed: int


@with_keywords_of(Scenario)
def rollout(
    machine: str | Path | Machine,
    demand: Signal | None = None,
    *,
    step: Value = STEP,
    records: int = 1,
    scenario: Scenario | None = None,
    controller: str | Path | Machine | None = None,
    progress: Callable[[float], None] | None = None,
    **changes: Unpack[ScenarioFields],
) -> "Run":
    """Simulate a machine with its controller.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        demand: demanded angles: "40 deg", {"large": "40 deg"}, steps [("0 s", ...), ("2 s", ...)], or a table of
            pandas or xarray; a number is in rad; default: the scenario's.
        step: time step of the plant; rounded so that a control cycle is a whole number of steps; a number is in s.
        records: instants recorded per control cycle.
        scenario: signals and disturbances; `demand` and `changes` override it.
        controller: the machine whose controller drives, with that machine's parameters as its model; a description,
            file or name as `machine`; default: the machine itself.
        progress: called every quarter of a second, from another thread, with the fraction of the run that is done.
        **changes: fields of `Scenario`, for instance `duration="4 s"`, `payload="2 kg"`, `seed=1`.

    Returns:
        The run: dims `time` and `joint`, units in the attributes (see dataset.py for the names).

    Raises:
        InputError: a machine, scenario or argument is wrong.
        DivergedError: the run diverged; its `run` holds the data up to there.

    Example:
        >>> import layflat as lf
        >>> run = lf.rollout("paper-arm", {"large": "20 deg"}, start="0 deg", duration="1.5 s")
        >>> float(run["angle"].sel(joint="large")[-1])  # rad
        0.349
        >>> figure = run.plot()
    """
    from layflat.sim.dataset import run_dataset  # noqa: PLC0415  # xarray takes long to import

    described = load(machine)
    if progress is not None and not callable(progress):
        raise InputError(f"{shown(progress)} can't be called", where="progress", right="give a function")
    case = change_scenario(scenario, demand, changes)
    driver = None if controller is None else load(controller)
    prepared = prepare_run(described, case, step=step, records=records, controller=driver)
    with _report_progress(prepared, progress):
        rows, report, diverged = prepared.run()
    law = CONTROL_LAWS.kind_of(prepared.case.settings)
    run = run_dataset(described, case, law, prepared.signals, prepared.timing, rows, report)
    if diverged >= 0:
        names = list(described.joints)
        cause = find_cause(described, prepared.case, prepared.signals, prepared.timing, run)
        raise DivergedError(float(run.time[-1]), names[diverged], run, cause)
    return run


def change_scenario(scenario: Scenario | None, demand: Signal | None, changes: Mapping[str, Any]) -> Scenario:
    """Return a scenario with another demand and other fields.

    Args:
        scenario: None for the default one.
        demand: None for the scenario's.
        changes: values by field.

    Raises:
        InputError: a field is unknown or wrong, or the demand would not act, beside a tip or an opening.
    """
    changed = dict(changes) if demand is None else {**changes, "demand": demand}
    case = build_options(Scenario, changed, "rollout", None if scenario is None else check_scenario(scenario))
    other = next((name for name in ("tip", "opening") if demand is not None and getattr(case, name) is not None), None)
    if other is not None:
        raise InputError(
            f"stands beside {'an' if other == 'opening' else 'a'} {other}",
            where="demand",
            right="give one or the other",
        )
    return case


@contextmanager
def _report_progress(prepared: "PreparedRun", progress: Callable[[float], None] | None) -> Iterator[None]:
    """Call `progress` every `PROGRESS_PERIOD`, from a thread, while the block simulates a run; nothing for None."""
    if progress is None:
        yield
        return
    over = Event()

    def report() -> None:
        while not over.wait(PROGRESS_PERIOD):
            progress(prepared.fraction_done)

    thread = Thread(target=report, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def rollout_as_far(machine: str | Path | Machine, demand: Signal | None = None, **options: Any) -> "xarray.Dataset":
    """Simulate as `rollout` does; return a run that diverges up to its divergence, without an error."""
    try:
        return rollout(machine, demand, **options)
    except DivergedError as error:
        return cast("xarray.Dataset", error.run)


@dataclass(frozen=True)
class PreparedRun:
    """A run ready for the time loop: the arguments of `kernel.run_cycles`, in order."""

    case: Case
    angles: Array  # at the start, rad, (joints,)
    pressures: Array  # at the start, absolute, Pa, (joints, 2); NaN for those that hold the arm
    signals: Signals
    samples: Array  # standard normal, of the sensors, (cycles + 1, joints, 2)
    timing: Timing
    counters: NDArray[np.int64] = field(default_factory=lambda: np.zeros(3, np.int64))  # see `kernel.RunBuffers`

    @property
    def fraction_done(self) -> float:
        """Fraction of the control cycles that have begun, 0..1; may be read while the run is in progress."""
        return float(self.counters[0]) / len(self.signals.by_joint)

    @cached_property
    def _numbers(self) -> tuple[Like, Array]:
        return Like.from_tuple(self.case), np.fromiter(leaves(self.case), float)

    def run(self) -> tuple[Array, Array, int]:
        """Simulate; return the records and the number of the joint that diverged.

        Returns:
            Records, (instants, joints, columns of `JointRecord`), and the control law's report, (instants, joints,
            signals), both up to a divergence; number of the joint that diverged, -1 for none.
        """
        law = CONTROL_LAWS.kind_of(self.case.settings)
        instants, joints = len(self.signals.by_joint) * self.timing.records + 1, len(self.angles)
        rows, report = np.empty((instants, joints, COLUMNS)), np.empty((instants, joints, len(law.signals)))
        inputs = self.angles, self.pressures, self.signals, self.samples, self.timing
        if law.compiled:
            run_cycles(*self._numbers, *inputs, self.counters, rows, report)
        else:
            with blame_outside():
                run_cycles.py_func(self.case, list(leaves(self.case)), *inputs, self.counters, rows, report)
        _, valid, diverged = self.counters.tolist()
        return rows[:valid], report[:valid], diverged


def controlling_machine(machine: Machine, controller: Machine | None) -> Machine:
    """Return the machine whose controller drives `machine`: `controller`, or `machine` itself if that is None.

    Raises:
        InputError: its joints differ from the machine's, in name or order.
    """
    if controller is not None and list(controller.joints) != list(machine.joints):
        raise InputError(
            f"has joints {', '.join(controller.joints)}",
            where=f"controller: {controller.origin}",
            right=f"give a machine with joints {', '.join(machine.joints)}, as {machine.origin} has",
        )
    return machine if controller is None else controller


def prepare_run(
    machine: Machine, scenario: Scenario, *, step: Value = STEP, records: int = 1, controller: Machine | None = None
) -> PreparedRun:
    """Return a run ready for the compiled loop.

    Args:
        machine: the plant.
        scenario: signals and disturbances.
        step: time step of the plant; rounded so that a control cycle is a whole number of steps; a number is in s.
        records: instants recorded per control cycle.
        controller: the machine whose controller drives; default: the plant.

    Raises:
        InputError: a machine, scenario or option is wrong.
    """
    driver = controlling_machine(machine, controller)
    cycle = driver.cycle
    timing = make_timing(cycle, step, records, machine)
    _check_size(scenario.cycles(cycle), machine, timing, len(driver.control_law.signals))
    acting = acting_signals(scenario, machine, cycle)
    return PreparedRun(
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
    """Raise InputError if memory can't hold the run; `reported` is the number of the control law's signals."""
    duration, records = cycles * timing.cycle, timing.records
    by_cycle = 8.0 * len(machine.joints) * HELD_NUMBERS
    by_record = 8.0 * len(machine.joints) * RECORD_COPIES * (len(JointRecord._fields) + reported + 3)
    where, work = ("records", f" with {records} records a cycle") if records > 1 else ("duration", "")

    def right(part: float) -> str:
        shorter = f"a duration of {0.9 * part * duration:.2g} s"
        return f"give fewer, or {shorter}" if records > 1 else f"give {shorter} or less"

    check_memory(cycles * (by_cycle + records * by_record), f"a run of {duration:g} s{work}", where, right)


def make_timing(cycle: float, step: Value, records: int, machine: Machine) -> Timing:
    """Return the time grid of a run with steps of about `step`.

    Args:
        cycle: control cycle, s.
        step: time step of the plant, before it is rounded to a whole number per record; a number is in s.
        records: instants recorded per control cycle.
        machine: the plant; numbers in it may be arrays.

    Raises:
        InputError: the step is below `MIN_STEP`, or exceeds a cycle or half a period of the valves' wave; or the number
            of records is out of range.
    """
    requested = read_number(step, u.TIME, "step")
    if not MIN_STEP <= requested <= cycle:
        raise InputError(f"{requested:g} s is out of range", where="step", right=f"give 10 ns to {cycle:g} s")
    check_integer(records, "records", 1, MAX_RECORDS)
    per_record = max(1, round(cycle / requested / records))
    timing = Timing(cycle, per_record * records, records)
    _check_wave(machine, timing)
    return timing


def _check_wave(machine: Machine, timing: Timing) -> None:
    """Raise InputError if a step is longer than half a period of the wave that the valves' drivers make."""
    frequency = None if machine.valve is None else machine.valve.wave_frequency
    if frequency is None:
        return
    fastest, step = float(np.max(frequency)), timing.cycle / timing.steps
    if fastest * step > 0.5 * (1.0 + 1e-9):
        what = f"{1e3 * step:g} ms is too long for the {fastest:g} Hz of the valves' drivers, which would be lost"
        right = f"give {1e3 * ADVISED_PERIOD_FRACTION / fastest:.2g} ms or less"
        raise InputError(what, where="step", right=right)


def start_angles(scenario: Scenario, machine: Machine, demand: Array) -> Array:
    """Return the angles at which the arm rests at the start.

    Args:
        scenario: scenario whose `start` sets them.
        machine: the plant.
        demand: (cycles, joints), rad; its first row is the start where the scenario sets none.

    Returns:
        Angles, (joints,), rad.

    Raises:
        InputError: the start is no single row of angles, or outside the working stroke.
    """
    start = read_start_angles(scenario, machine)
    return np.array(demand[0]) if start is None else start
