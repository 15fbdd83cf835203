"""What happens to a machine during a run: demands and disturbances, as signals over time."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from math import nan
from typing import Any, NamedTuple, TypeGuard, TypeVar

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.hints import did_you_mean
from layflat.errors import InputError
from layflat.machine import Machine, parameters
from layflat.motion.rates import derived_rates, lasting_rate
from layflat.motion.tip_demand import axes_of, demand_of_tip
from layflat.physics.noise import sensor_noise
from layflat.sim.kernel import Signals

Value = str | float
Angles = Value | Mapping[str, Value] | Sequence[Value]
"""Of all joints: one value, a table by joint, or one value a joint from base to tip."""
Steps = Sequence[tuple[Value, Angles]]
Signal = Angles | Steps | Callable[[float], Angles] | Array
"""A constant, steps of (time, values), a function of time, or one row of numbers per control cycle."""

Pair = tuple[Value, Value]  # of the hoses A and B
LARGEST_SEED = 2**32 - 1  # of all random numbers

Times = NDArray[np.floating[Any]]
K = TypeVar("K")


@dataclass(frozen=True)
class Scenario:
    """All that acts on a machine during a run. Text carries units; numbers are SI.

    A disturbance given as steps is as usual before the first of them; a demand is there from the start.

    Args:
        demand: angles asked for (rad); must lie inside the working stroke where the controller drives.
        tip: places asked for of the tip instead (m), as {"x": "0.5 m", "y": "0 m"}, in space with "z", or a list of
            these; each is taken with the posture that is near to the one before.
        demand_velocity: of the demand (rad/s); default: as it moves on; a jump has none.
        demand_acceleration: of the demand (rad/s2), likewise.
        demand_stiffness: of the joints at rest (N m/rad), for controllers and machines that can; default: as it comes.
        duration: s.
        start: angles at which the arm rests at first; default: the first demand.
        opening: valve openings, -1..1, in place of the controller: an open-loop run.
        voltage: control voltages in place of the controller, V: a run that follows a log.
        brake: share of the brake's torque.
        dither: share of the valve's dither.
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
        """Whether the controller drives the valves."""
        return self.opening is None and self.voltage is None

    def __post_init__(self) -> None:
        """Refuse a seed that the generator can't take; raise InputError if it is negative or too large."""
        if not 0 <= self.seed <= LARGEST_SEED:
            raise InputError(f"{self.seed} is out of range", where="seed", right=f"give 0 to {LARGEST_SEED}")

    def cycles(self, cycle: float) -> int:
        """Number of control cycles."""
        duration = u.quantity(self.duration, u.TIME, "duration")
        if not cycle <= duration <= 1e5:
            raise InputError(f"{duration:g} s is out of range", where="duration", right="give 5 ms to 100000 s")
        return round(duration / cycle)


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


class Shapes(NamedTuple):
    """A scenario as arrays over control cycles, before a machine is known; not a number: as usual."""

    demand: Array  # rad, (cycles, joints)
    rates: tuple[Array, Array]  # of the demand, rad/s and rad/s2, (cycles, joints) each
    stiffness: Array  # asked for, N m/rad, (cycles, joints)
    opening: Array  # -1..1, (cycles, joints); not a number where the controller or a voltage drives
    voltage: Array  # V, (cycles, joints); not a number where the controller or an opening drives
    brake: Array  # share of the brake's torque, (cycles, joints)
    dither: Array  # share of the valve's dither, (cycles, joints)
    load: Array  # N m, (cycles, joints)
    drift: Array  # V, (cycles, joints)
    supply: Array  # gauge pressure, Pa, (cycles,)
    payload: Array  # kg, (cycles,)

    @property
    def by_joint(self) -> Array:
        """All that differs from joint to joint, in this order, (cycles, joints, 10)."""
        asked = (self.demand, *self.rates, self.stiffness)
        return np.stack((*asked, self.opening, self.voltage, self.brake, self.dither, self.load, self.drift), axis=-1)


def shapes(scenario: Scenario, machine: Machine, cycle: float) -> Shapes:
    """The scenario as arrays over control cycles of `cycle` seconds.

    Raises:
        InputError: a value without unit, of a wrong kind, not finite, or a demand outside the stroke.
    """
    n, names = scenario.cycles(cycle), list(machine.joints)
    times = cycle * np.arange(n)

    def expand(signal: Signal | None, kind: u.Quantity | None, where: str, usual: float = 0.0) -> Array:
        if signal is None:
            return np.full((n, len(names)), nan)
        return spread(signal, times, names, kind, where, usual)

    def shared(signal: Signal | None, kind: u.Quantity, where: str) -> Array:
        if signal is None:
            return np.full(n, nan)
        return np.ascontiguousarray(spread(signal, times, [where], kind, where, nan)[:, 0])

    demand = _demand(scenario, machine, times)
    for j, name in enumerate(names if scenario.closed_loop else ()):
        worst = float(demand[np.argmax(np.abs(demand[:, j])), j])
        parameters.check_inside_stroke(machine, name, worst, "demand")
    rates = _rates(scenario, demand, expand, cycle)
    stiffness = expand(scenario.demand_stiffness, u.STIFFNESS, "demand_stiffness", 0.0)
    _check(stiffness >= 0.0, stiffness, "demand_stiffness", 'a stiffness of zero or more, such as "20 N m/rad"')
    supply = shared(scenario.supply, u.PRESSURE, "supply")
    _check(
        supply > -machine.supply.ambient_pressure, supply, "supply", 'a gauge pressure above vacuum, such as "4 bar"'
    )
    payload = shared(scenario.payload, u.MASS, "payload")
    _check(payload >= 0.0, payload, "payload", 'a mass of zero or more, such as "1.5 kg"')
    brake = expand(scenario.brake, None, "brake", 1.0)
    _check(brake >= 0.0, brake, "brake", "a share of zero or more, such as 1.0")
    dither = expand(scenario.dither, None, "dither", 1.0)
    _check((dither >= 0.0) & (dither <= 1.0), dither, "dither", "a share from 0 to 1")
    if scenario.opening is not None and scenario.voltage is not None:
        raise InputError("stands beside a voltage", where="opening", right="give one or the other")
    opening, voltage = expand(scenario.opening, None, "opening"), expand(scenario.voltage, u.VOLTAGE, "voltage")
    _check(np.abs(opening) <= 1.0, opening, "opening", "a share from -1 to 1")
    load, drift = expand(scenario.load, u.TORQUE, "load"), expand(scenario.drift, u.VOLTAGE, "drift")
    return Shapes(demand, rates, stiffness, opening, voltage, brake, dither, load, drift, supply, payload)


def _demand(scenario: Scenario, machine: Machine, times: Times) -> Array:
    """Angles asked for, (times, joints), rad: as given, or those that bring the tip to where it is asked for."""
    names = list(machine.joints)
    if scenario.tip is None:
        return spread(scenario.demand, times, names, u.ANGLE, "demand")
    axes = axes_of(machine)
    if not (isinstance(scenario.demand, float) and scenario.demand == 0.0):
        raise InputError("stands beside a demand", where="tip", right="give one or the other")
    places = spread(_whole(scenario.tip, axes), times, axes, u.LENGTH, "tip")
    start = 0.0 if scenario.start is None else scenario.start
    near = spread(start, times[:1], names, u.ANGLE, "start")[0]
    return demand_of_tip(machine, places, near, "tip")


def _whole(tip: Any, axes: Sequence[str]) -> Any:
    """The same places of the tip; raise InputError where one lacks a coordinate."""
    if isinstance(tip, np.ndarray):
        return tip
    if callable(tip):
        return lambda time: _whole(tip(time), axes)
    if _is_steps(tip):
        return [(time, _whole(place, axes)) for time, place in tip]
    given = set(tip) if isinstance(tip, Mapping) else tip
    if isinstance(given, (str, int, float)) or (isinstance(given, set) and given != set(axes)):
        raise InputError(f"{tip!r} is not a place", where="tip", right=f"give {', '.join(axes)}")
    return tip


def _rates(scenario: Scenario, demand: Array, expand: Callable[..., Array], cycle: float) -> tuple[Array, Array]:
    """Velocity and acceleration of the demand: as given, else as it moves on."""
    velocity, acceleration = scenario.demand_velocity, scenario.demand_acceleration
    found = derived_rates(demand, cycle)
    if velocity is not None:
        v = expand(velocity, u.ANGULAR_SPEED, "demand_velocity")
        found = v, lasting_rate(v, cycle)
    if acceleration is not None:
        found = found[0], expand(acceleration, u.ANGULAR_ACCELERATION, "demand_acceleration")
    return found


def signals(scenario: Scenario, machine: Machine, cycle: float) -> Signals:
    """What acts on a machine in a scenario.

    Raises:
        InputError: as `shapes`.
    """
    own = shapes(scenario, machine, cycle)
    brakes = np.array([joint.brake.torque for joint in machine.joints.values()])
    gauge = np.where(np.isnan(own.supply), machine.supply.pressure_gauge, own.supply)
    return Signals(
        own.demand,
        np.stack(own.rates, axis=-1),
        own.stiffness,
        _opening(own, machine),
        own.brake * brakes,
        own.dither,
        own.load,
        own.drift,
        gauge + machine.supply.ambient_pressure,
        np.where(np.isnan(own.payload), machine.arm.payload, own.payload),
        sensor_noise(scenario.seed if scenario.noise else None, len(own.demand) + 1, own.demand.shape[1]),
    )


def _opening(own: Shapes, machine: Machine) -> Array:
    """Openings asked for; not a number where the controller drives."""
    if machine.valve is None or np.isnan(own.voltage).all():
        return own.opening
    return (own.voltage - machine.valve.centre_voltage) / machine.valve.volts_to_full


def _check(good: NDArray[np.bool_], values: Array, where: str, right: str) -> None:
    good |= np.isnan(values)
    if not good.all():
        raise InputError(f"{values[~good][0]:g} is out of range", where=where, right=f"give {right}")


def spread(
    signal: Signal, times: Times, names: Sequence[str], kind: u.Quantity | None, where: str, usual: float | None = None
) -> Array:
    """Values of a signal at the given times, shape (times, names).

    `usual` is the value before the first of its steps and of a name that a table leaves out; without it the first step
    holds from the start, and what is left out is zero.

    Raises:
        InputError: naming `where` it was given.
    """
    if isinstance(signal, np.ndarray):
        return _rows(signal, times, names, where)
    if callable(signal):
        return np.array([_row(signal(float(t)), names, kind, where, usual) for t in times])
    if _is_steps(signal):
        return _steps(signal, times, names, kind, where, usual)
    return np.tile(_row(signal, names, kind, where, usual), (len(times), 1))


def _is_steps(signal: object) -> TypeGuard[Steps]:
    return isinstance(signal, Sequence) and not isinstance(signal, str) and len(signal) > 0 and all(
        isinstance(item, tuple) and len(item) == 2 for item in signal
    )  # fmt: skip


def _steps(
    steps: Steps, times: Times, names: Sequence[str], kind: u.Quantity | None, where: str, usual: float | None
) -> Array:
    since = [u.quantity(time, u.TIME, where) for time, _ in steps]
    if any(b <= a for a, b in pairwise(since)):
        raise InputError("the times of its steps do not grow", where=where, right='give ("0 s", ...), ("1 s", ...)')
    rows = [_row(values, names, kind, where, usual) for _, values in steps]
    before = rows[0] if usual is None else np.full(len(names), usual)
    # A step holds from its time on.
    which = np.searchsorted(np.array(since) - 1e-9, times, side="right")
    return np.array([before, *rows])[which]


def _rows(rows: Array, times: Times, names: Sequence[str], where: str) -> Array:
    wide = rows if rows.ndim == 2 else np.repeat(rows.reshape(-1, 1), len(names), axis=1)
    if wide.shape != (len(times), len(names)):
        raise InputError(
            f"an array of shape {rows.shape} does not fit", where=where, right=f"give shape {(len(times), len(names))}"
        )
    if not np.isfinite(wide).all():
        raise InputError("holds a value that is not finite", where=where, right="give numbers only")
    return np.ascontiguousarray(wide, dtype=np.float64)


def _row(values: object, names: Sequence[str], kind: u.Quantity | None, where: str, usual: float | None) -> Array:
    """One value a joint, in SI."""
    if isinstance(values, Mapping):
        unknown = sorted(set(values) - set(names))
        if unknown:
            raise InputError(f"unknown joint {unknown[0]!r}", where=where, right=f"joints are {', '.join(names)}")
        each = [values.get(name, usual or 0.0) for name in names]
    elif isinstance(values, Sequence) and not isinstance(values, str):
        each = list(values)
    elif isinstance(values, np.ndarray):
        each = [float(value) for value in values.ravel()]
    else:
        each = [values] * len(names)
    if len(each) != len(names):
        raise InputError(f"has {len(each)} values", where=where, right=f"give {len(names)}: {', '.join(names)}")
    return np.array([_number(value, kind, where) for value in each])


def _number(value: object, kind: u.Quantity | None, where: str) -> float:
    if kind is not None and isinstance(value, (str, int, float)):
        return u.quantity(value, kind, where)
    if isinstance(value, (int, float, np.number)) and np.isfinite(value):
        return float(value)
    raise InputError(f"{value!r} is not a number", where=where, right="give a number such as 0.5")
