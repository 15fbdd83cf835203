"""One machine through one scenario."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from layflat.arrays import Array
from layflat.control import CONTROL_LAWS
from layflat.description import units as u
from layflat.errors import DivergedError, InputError
from layflat.jit.outside import blame_outside
from layflat.lanes import Like, leaves
from layflat.machine import Machine, load, parameters
from layflat.physics.step import STEP
from layflat.sim.kernel import Case, Signals, Timing, all_cycles, run_cycles
from layflat.sim.scenario import Scenario, Signal, Value, checked_options, signals, spread

if TYPE_CHECKING:
    import xarray


def rollout(
    machine: str | Path | Machine,
    demand: Signal = 0.0,
    *,
    step: Value = STEP,
    records: int = 1,
    scenario: Scenario | None = None,
    controller: Machine | None = None,
    **changes: Any,
) -> "xarray.Dataset":
    """Simulate a machine with its controller.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        demand: angles asked for: "40 deg", {"large": "40 deg"}, or steps [("0 s", ...), ("2 s", ...)].
        step: of the plant; rounded so that a control cycle is a whole number of steps.
        records: instants recorded per control cycle.
        controller: the machine that the controller believes to drive, and whose controller it is; default: the machine.
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
    case = checked_options(Scenario, changes, "rollout", scenario or Scenario(demand=demand))
    prepared = prepare(described, case, step=step, records=records, controller=controller)
    rows, shown, diverged = prepared.run()
    run = dataset(described, case, prepared, rows, shown)
    if diverged >= 0:
        names = list(described.joints)
        raise DivergedError(float(run.time[-1]), names[diverged], run)
    return run


def rollout_as_far(machine: str | Path | Machine, demand: Any = 0.0, **options: Any) -> "xarray.Dataset":
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
    timing: Timing

    @cached_property
    def _numbers(self) -> tuple[Like, Array]:
        return Like.of(self.case), np.fromiter(leaves(self.case), float)

    def run(self) -> tuple[Array, Array, int]:
        """Records up to where it diverged, and in which joint that was (-1: none).

        Returns:
            (instants, joints, columns of `Sample`), (instants, joints, signals of the control law), and the joint.
        """
        law = CONTROL_LAWS.of(self.case.settings)
        rest = self.angles, self.pressures, self.signals, self.timing, len(law.signals)
        if law.compiled:
            rows, shown, valid, diverged = run_cycles(*self._numbers, *rest)
        else:
            with blame_outside():
                rows, shown, valid, diverged = all_cycles(self.case, *rest)
        return rows[:valid], shown[:valid], int(diverged)


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
    timing = timing_of(cycle, u.quantity(step, u.TIME, "step"), records)
    acting = signals(scenario, machine, cycle)
    return Prepared(
        Case(
            parameters.arm(machine),
            parameters.joints(machine),
            parameters.control(driver, closed_loop=scenario.closed_loop),
            parameters.surroundings(machine),
        ),
        start_angles(scenario, machine, acting.demand),
        start_pressures(scenario, list(machine.joints)),
        acting,
        timing,
    )


def timing_of(cycle: float, step: float, records: int) -> Timing:
    """How a run is cut into steps of about `step` seconds.

    Raises:
        InputError: the step is no part of a cycle, or nothing is recorded.
    """
    if not 1e-8 <= step <= cycle:
        raise InputError(f"{step:g} s is out of range", where="step", right=f"give 10 ns to {cycle:g} s")
    if records < 1:
        raise InputError(f"{records} is out of range", where="records", right="give 1 or more per cycle")
    per_record = max(1, round(cycle / step / records))
    return Timing(cycle, per_record * records, records)


def start_angles(scenario: Scenario, machine: Machine, demand: Array) -> Array:
    """Angles at which the arm rests at first, (joints,)."""
    if scenario.start is None:
        return np.array(demand[0])
    angles: Array = spread(scenario.start, np.zeros(1), list(machine.joints), u.ANGLE, "start")[0]
    for name, angle in zip(machine.joints, angles, strict=True):
        parameters.check_inside_stroke(machine, name, float(angle), "start")
    return angles


def start_pressures(scenario: Scenario, names: list[str]) -> Array:
    """Absolute pressures of hoses A and B of these joints at the start, Pa, (joints, 2); nan where none is given.

    Raises:
        InputError: they are not above vacuum, or of a joint that is not there.
    """
    given = scenario.pressures
    each = dict(given) if isinstance(given, Mapping) else dict.fromkeys(names, given)
    unknown = sorted(set(each) - set(names))
    if unknown:
        raise InputError(f"unknown joint {unknown[0]!r}", where="pressures", right=f"joints are {', '.join(names)}")
    pressures = np.full((len(names), 2), np.nan)
    for j, name in enumerate(names):
        if (pair := each.get(name)) is not None:
            pressures[j] = [u.quantity(value, u.PRESSURE, "pressures") for value in pair]
    if np.any(pressures <= 0.0):
        least = np.nanmin(pressures)
        raise InputError(f"{least:g} Pa is not above vacuum", where="pressures", right='give absolute "3.5 bar"')
    return pressures
