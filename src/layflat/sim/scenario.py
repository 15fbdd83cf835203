"""All that happens to a machine during a run: demands and disturbances, as signals over time."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.hints import did_you_mean
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine, parameters
from layflat.machine.signal_ranges import check_signal
from layflat.motion.labelled import is_labelled, labelled_row
from layflat.motion.signal_rows import Signal, Steps, is_steps
from layflat.motion.signal_values import Angles, SignalKind, Value, check_names, is_real, read_number, read_row

__all__ = ["Angles", "Pair", "Scenario", "Signal", "Steps", "Value", "checked_options"]

Pair = tuple[Value, Value]  # of the hoses A and B

MAX_SEED = 2**32 - 1  # of all random numbers
MAX_DURATION = 1e5  # s

K = TypeVar("K")


@dataclass(frozen=True)
class Scenario:
    """All that acts on a machine during a run. Text carries units; numbers are SI.

    A signal is a constant, steps [("0 s", ...), ("1 s", ...)], a function of time, an array with a row for each control
    cycle, or a table of pandas or xarray with times and the names of joints. Where a joint is not named it keeps what
    it had: the value of the step before, and before the first step a disturbance its usual value, a demand the start.

    Args:
        demand: angles asked for (rad); must lie inside the working stroke where the controller drives.
        tip: places asked for of the tip instead (m), as {"x": "0.5 m", "y": "0 m"}, in space with "z", or a list of
            these; each is taken with the posture that is near to the one before.
        demand_velocity: of the demand (rad/s); default: as it moves on; a jump has none.
        demand_acceleration: of the demand (rad/s2), likewise.
        demand_stiffness: of the joints at rest (N m/rad), for controllers and machines that can; default: as it comes.
        duration: s.
        start: angles at which the arm rests at first; default: the first demand.
        opening: valve openings, -1..1, in place of the controller: an open-loop run without a demand.
        voltage: control voltages in place of the controller, V: a run that follows a log.
        brake: share of the brake's torque, 0..1.
        dither: share of the valve's dither, 0..1.
        load: external torque on each joint, N m.
        drift: shift of each valve's centre, V.
        supply: gauge pressure of the supply, Pa; default: the machine's.
        payload: kg; default: the machine's.
        pressures: absolute pressures of the hoses A and B at the start, Pa, of all joints or by joint; those that hold
            where not given.
        noise: whether the sensors are noisy.
        seed: of the noise.
    """

    demand: Signal = 0.0
    tip: Signal | None = None
    demand_velocity: Signal | None = None
    demand_acceleration: Signal | None = None
    demand_stiffness: Signal = 0.0
    duration: Value = 2.0
    start: Angles | None = None
    opening: Signal | None = None
    voltage: Signal | None = None
    brake: Signal = 1.0
    dither: Signal = 1.0
    load: Signal = 0.0
    drift: Signal = 0.0
    supply: Signal | None = None
    payload: Signal | None = None
    pressures: Pair | Mapping[str, Pair] | None = None
    noise: bool = True
    seed: int = 0

    @property
    def closed_loop(self) -> bool:
        """True where the controller drives the valves."""
        return self.opening is None and self.voltage is None

    @property
    def asks_for_angles(self) -> bool:
        """True where a demand is given, not the default or a table that names no joint."""
        none = isinstance(self.demand, (int, float)) and self.demand == 0
        return not (none or (isinstance(self.demand, Mapping) and not self.demand))

    def __post_init__(self) -> None:
        """Refuse what is wrong whatever the machine; raise InputError naming the field."""
        if not isinstance(self.noise, (bool, np.bool_)):
            raise InputError(f"{shown(self.noise)} is neither True nor False", where="noise", right="give one of them")
        check_whole(self.seed, "seed", 0, MAX_SEED)
        if self.tip is not None and self.asks_for_angles:
            raise InputError("stands beside a demand", where="tip", right="give one or the other")
        if self.opening is not None and self.voltage is not None:
            raise InputError("stands beside a voltage", where="opening", right="give one or the other")
        beside = [name for name in ("tip", "demand_velocity", "demand_acceleration") if getattr(self, name) is not None]
        beside += ["demand"] * self.asks_for_angles
        if self.opening is not None and beside:
            what = f"stands beside {beside[-1]}: a run in open loop follows none"
            raise InputError(what, where="opening", right="give one or the other")

    def cycles(self, cycle: float) -> int:
        """Return the number of control cycles (s); raise InputError if the duration is out of range."""
        duration = read_number(self.duration, u.TIME, "duration")
        if not cycle <= duration <= MAX_DURATION:
            right = f"give {cycle:g} s to {MAX_DURATION:g} s"
            raise InputError(f"{duration:g} s is out of range", where="duration", right=right)
        return round(duration / cycle)


def check_whole(value: object, where: str, lower: int, upper: int | None = None) -> int:
    """Return a whole number within bounds.

    Args:
        value: that is given.
        where: the argument in messages.
        lower: the smallest that is allowed.
        upper: the largest; default: any.

    Raises:
        InputError: naming `where`: it is no whole number, or out of bounds.
    """
    right = f"give a whole number, {lower} or more" if upper is None else f"give {lower} to {upper}"
    if not (is_real(value) and isinstance(value, (int, np.integer))):
        raise InputError(f"{shown(value)} is not a whole number", where=where, right=right)
    if value < lower or (upper is not None and value > upper):
        raise InputError(f"{shown(value)} is out of range", where=where, right=right)
    return int(value)


def checked_options(kind: type[K], given: Mapping[str, Any], where: str, over: K | None = None) -> K:
    """Return a dataclass of options with those that were given, over its defaults or another one.

    Raises:
        InputError: an option is unknown.
    """
    known = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    unknown = sorted(set(given) - set(known))
    if unknown:
        raise InputError(f"unknown option {unknown[0]!r}", where=where, right=did_you_mean(unknown[0], known, "use {}"))
    return replace(over or kind(), **given)  # type: ignore[type-var]


def check_scenario(scenario: object) -> Scenario:
    """Return a scenario; raise InputError if something else was given."""
    if not isinstance(scenario, Scenario):
        right = f"give Scenario(demand={shown(scenario)})" if isinstance(scenario, (str, float)) else "give a Scenario"
        raise InputError(f"{shown(scenario)} is not a Scenario", where="scenario", right=right)
    return scenario


def start_row(scenario: Scenario, machine: Machine) -> Array | None:
    """Return the angles at which the arm rests at first, (joints,), rad; None where the first demand says them.

    Raises:
        InputError: they are no single row of angles, or outside the working stroke.
    """
    if scenario.start is None:
        return None
    kind, given = SignalKind("start", u.ANGLE, list(machine.joints)), scenario.start
    if is_labelled(given):
        given = labelled_row(given, kind)
    if given is None or callable(given) or is_steps(given):
        raise InputError("changes over time", where="start", right='give one row of angles, such as "10 deg"')
    angles = read_row(given, kind, np.zeros(len(kind.names)))
    for name, angle in zip(machine.joints, angles, strict=True):
        parameters.check_inside_stroke(machine, name, float(angle), "start")
    return angles


def start_pressures(scenario: Scenario, machine: Machine) -> Array:
    """Return absolute pressures of hoses A and B at the start, Pa, (joints, 2); nan where none is given.

    Raises:
        InputError: they are no pairs of plausible pressures, or of a joint that is not there.
    """
    kind, given = SignalKind("pressures", u.PRESSURE, list(machine.joints)), scenario.pressures
    pressures = np.full((len(kind.names), 2), np.nan)
    if given is None:
        return pressures
    each = dict(given) if isinstance(given, Mapping) else dict.fromkeys(kind.names, given)
    check_names(each, kind)
    for j, name in enumerate(kind.names):
        if (pair := each.get(name)) is None:
            continue
        if not isinstance(pair, (list, tuple, np.ndarray)) or getattr(pair, "ndim", 1) != 1 or len(pair) != 2:
            right = 'give those of hoses A and B: ("3.5 bar", "3 bar")'
            raise InputError(f"{shown(pair)} is no pair", where="pressures", right=right)
        pressures[j] = [read_number(value, u.PRESSURE, "pressures") for value in pair]
    return check_signal(machine, "pressures", pressures)
