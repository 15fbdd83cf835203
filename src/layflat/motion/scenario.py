"""Scenario of a simulation run: demands and disturbances over time, with the ranges of their plausible values.

The fields of `Scenario` are the one table of signals. Arrays of the time loop, checks, options, keys of studies, names
and units of records and logs, and the table in docs/conventions.md follow from it: a further signal is a field here
and its use in the physics. `layflat simulate --help` reads the table, so this module imports nothing heavy. A value
that is not plausible is a mistake in a unit, a sign or a meaning.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from math import inf, nan
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from layflat.errors import InputError

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.description import units as u
    from layflat.machine import Machine
    from layflat.motion.signal_rows import Signal
    from layflat.motion.signal_values import Angles, Pair, SignalKind, Value


MAX_PRESSURE = 100e5  # gauge or absolute: no layflat hose bears more, Pa
MIN_PRESSURE = 1e3  # absolute, of a hose, Pa: less is nearly a vacuum, or was meant in bar
MIN_SUPPLY = 1e3  # gauge, Pa: a supply that is always less, and not zero, was meant in another unit
VOLTAGE_ROUNDING = 0.05  # excess of a logged voltage over its range, as a fraction of the span


class SignalRange(NamedTuple):
    """Range of a signal's plausible values, in SI units."""

    lower: float
    upper: float
    unit: str  # "" for a fraction
    right: str  # such values in words, for messages
    lower_included: bool = True
    min_magnitude: float = 0.0  # of the greatest value, unless all are zero

    def check(self, values: Any, where: str) -> Array:
        """Return values (any shape; NaN: default) as an array; raise InputError naming `where` if one is out of range.

        They are also refused if all magnitudes are below `min_magnitude`, and not all zero.
        """
        import numpy as np  # noqa: PLC0415  # the table of signals is read for help alone, too

        array = np.asarray(values, dtype=float)
        low = array >= self.lower if self.lower_included else array > self.lower
        good = np.isnan(array) | (low & (array <= self.upper))
        if not good.all():
            unit = f" {self.unit}" if self.unit else ""
            raise InputError(f"{array[~good][0]:g}{unit} is out of range", where=where, right=f"give {self.right}")
        if 0.0 < np.nanmax(np.abs(array), initial=0.0) < self.min_magnitude:
            what = f"{array[array != 0.0][0]:g} {self.unit} is hardly any pressure"
            raise InputError(what, where=where, right='give a gauge pressure such as "4 bar"; numbers are in Pa')
        return array


def symmetric_range(limit: float, unit: str, right: str) -> SignalRange:
    """Return the range of a signal of either sign.

    Args:
        limit: greatest magnitude, in `unit`.
        unit: SI unit.
        right: such values in words, for messages.
    """
    return SignalRange(-limit, limit, unit, right)


FRACTION_RANGE = SignalRange(0.0, 1.0, "", "a share from 0 to 1")
HOSE_PRESSURE = SignalRange(
    MIN_PRESSURE, 2.0 * MAX_PRESSURE, "Pa", 'absolute pressures such as "3.5 bar"; numbers are in Pa'
)  # fmt: skip


def supply_range(machine: Machine) -> SignalRange:
    """Return the range of a supply's gauge pressure."""
    right = f'a gauge pressure above vacuum, up to {MAX_PRESSURE / 1e5:g} bar, such as "4 bar"'
    return SignalRange(
        -machine.supply.ambient_pressure, MAX_PRESSURE, "Pa", right, lower_included=False, min_magnitude=MIN_SUPPLY
    )


def drift_range(machine: Machine) -> SignalRange:
    """Return the range of the shift of a valve's centre voltage, up to full opening; infinite without a valve."""
    if machine.valve is None:
        return SignalRange(-inf, inf, "V", "a voltage")
    span = machine.valve.volts_to_full
    return symmetric_range(span, "V", f'a shift of up to {span:g} V, which opens the valve fully, such as "0.2 V"')


def voltage_range(machine: Machine) -> SignalRange:
    """Return the range of a valve's control voltage, 5 % of the half span wider; infinite without a valve."""
    if machine.valve is None:
        return SignalRange(-inf, inf, "V", "a voltage")
    span, centre = machine.valve.volts_to_full, machine.valve.centre_voltage
    spare = VOLTAGE_ROUNDING * span
    right = f"{centre - span:g} to {centre + span:g} V, the range of the valve"
    return SignalRange(centre - span - spare, centre + span + spare, "V", right)


def centre_voltage(machine: Machine) -> float:
    """Return the voltage at which a valve is closed, 0 without a valve."""
    return 0.0 if machine.valve is None else machine.valve.centre_voltage


MAX_SEED = 2**32 - 1  # of all random numbers
MAX_DURATION = 1e5  # s

MAX_SPEED = 200.0  # of a demand, rad/s: ten times as fast as the lightest arm
MAX_ACCELERATION = 1e5  # of a demand, rad/s2
MAX_STIFFNESS = 1e5  # of a joint, N m/rad
MAX_LOAD = 2e3  # torque on a joint from outside, N m: hoses of 300 mm give 500 N m
MAX_PAYLOAD = 500.0  # kg


@dataclass(frozen=True, kw_only=True)
class SignalRow:
    """Row of the table of signals: all properties of a signal besides its name and its default."""

    written: str  # name in description/units.py of the kind of its values; empty: a fraction
    meaning: str
    usual: float | Callable[[Machine], float] = nan
    """Value before the first step, and of joints that are not named; NaN: the machine's."""
    path: str = ""  # of the machine's number that it replaces
    by_joint: bool = True  # False: all joints share it
    range: SignalRange | Callable[[Machine], SignalRange] | None = None  # of plausible values
    varies: Literal["", "factor", "adds", "replaces"] = ""
    """Combination of values that differ from run to run with those of the scenario; empty: they can't differ."""
    option: str = ""  # help of the option of `layflat simulate`, with an example; empty: it has none
    logged: Literal["", "held", "measured"] = ""  # in logs: a command, held until the next, or a measurement
    gauge: bool = False  # whether it is a gauge pressure; in records and logs it is absolute

    @property
    def annotation(self) -> Any:
        """Type of its values in a file: a float with its quantity and its bounds."""
        # Help reads the table without them.
        from annotated_types import Ge  # noqa: PLC0415

        from layflat.description import units  # noqa: PLC0415

        if not self.written:
            return Annotated[float, Ge(0)]

        kind = getattr(units, self.written)
        return Annotated[float, kind] if isinstance(kind, units.Quantity) else kind

    @property
    def quantity(self) -> u.Quantity | None:
        """Quantity of its values; None for a fraction."""
        from layflat.description.change import quantity_of  # noqa: PLC0415  # takes long to import

        return quantity_of(self.annotation)

    @property
    def recorded(self) -> tuple[str, str]:
        """Unit and meaning in records."""
        quantity = self.quantity
        unit = "1" if quantity is None else quantity.unit.replace("*", " ").replace("^", "")
        return unit, f"absolute {self.meaning}" if self.gauge else self.meaning

    def kind(self, name: str, joints: list[str]) -> SignalKind:
        """Return the kind of its values, for a machine's joints."""
        from layflat.motion.signal_values import SignalKind, single_kind  # noqa: PLC0415  # takes long to import

        return SignalKind(name, self.quantity, joints) if self.by_joint else single_kind(name, self.quantity)

    def usual_of(self, machine: Machine) -> float:
        """Return its default value for a machine; NaN: the machine's own."""
        return self.usual(machine) if callable(self.usual) else self.usual

    def check(self, machine: Machine, values: Any, where: str) -> Array:
        """Return values if they are plausible.

        Args:
            machine: machine whose range counts.
            values: SI units, any shape; NaN: default.
            where: source of the values, for messages.

        Raises:
            InputError: naming `where`: a value is out of range.
        """
        limits = self.range(machine) if callable(self.range) else self.range or SignalRange(-inf, inf, "", "")
        return limits.check(values, where)


def signal_row(written: str, meaning: str, **rest: Any) -> dict[str, SignalRow]:
    """Return a row of the table, as a field of `Scenario` carries it."""
    return {"row": SignalRow(written=written, meaning=meaning, **rest)}


@dataclass(frozen=True)
class Scenario:
    """Signals that act on a machine during a run. Text carries units; numbers are SI.

    A signal is a constant, steps [("0 s", ...), ("1 s", ...)], a function of time, an array with a row for each control
    cycle, or a table of pandas or xarray with times and the names of joints. A joint that is not named keeps its value
    of the step before; before the first step, disturbances have their default and demands the start.
    An opening or a voltage replaces the controller: a run in open loop, or one that replays a log.

    The table in docs/conventions.md lists the signals; the other fields are:

    Args:
        tip: demanded positions of the tip instead of a demand (m), as {"x": "0.5 m", "y": "0 m"}, in space with "z", or
            a list of these; each configuration is near to the one before.
        duration: s.
        start: angles at which the arm rests at first; default: the first demand.
        pressures: absolute pressures of the hoses A and B at the start, Pa, of all joints or by joint; default: those
            that hold the arm.
        noise: whether the sensors are noisy.
        seed: seed of the noise.

    Example:
        >>> import layflat as lf
        >>> lift = lf.Scenario(demand=[("0.2 s", {"large": "20 deg"})], payload="2 kg", duration="1.5 s")
        >>> lf.rollout("paper-arm", scenario=lift).sizes["time"]
        301
    """

    demand: Signal = field(default=0.0, metadata=signal_row("Angle", "demanded angle", usual=0.0, logged="held"))
    tip: Signal | None = None
    demand_velocity: Signal | None = field(default=None, metadata=signal_row(
        "ANGULAR_SPEED", "velocity of the demand; by default as it moves on", usual=0.0,
        range=symmetric_range(
            MAX_SPEED, "rad/s", f'at most {MAX_SPEED:g} rad/s, such as "60 deg/s"; numbers are in rad/s'
        ),
    ))  # fmt: skip
    demand_acceleration: Signal | None = field(default=None, metadata=signal_row(
        "ANGULAR_ACCELERATION", "acceleration of the demand; by default as it moves on", usual=0.0,
        range=symmetric_range(
            MAX_ACCELERATION, "rad/s2",
            f'at most {MAX_ACCELERATION:g} rad/s2, such as "30 rad/s^2"; numbers are in rad/s2',
        ),
    ))  # fmt: skip
    demand_stiffness: Signal = field(default=0.0, metadata=signal_row(
        "Stiffness", "stiffness of stationary joints, for laws and machines with it; 0: any", usual=0.0,
        range=SignalRange(
            0.0, MAX_STIFFNESS, "N m/rad", f'a stiffness of zero or more, up to {MAX_STIFFNESS:g}, such as "20 N m/rad"'
        ),
    ))  # fmt: skip
    duration: Value = 2.0
    start: Angles | None = None
    opening: Signal | None = field(default=None, metadata=signal_row(
        "", "opening of the valve, -1 to 1", usual=0.0,
        range=SignalRange(-1.0, 1.0, "", "a share from -1 to 1"),
    ))  # fmt: skip
    voltage: Signal | None = field(default=None, metadata=signal_row(
        "Voltage", "control voltage",
        usual=centre_voltage, range=voltage_range, logged="held",
    ))  # fmt: skip
    brake: Signal = field(default=1.0, metadata=signal_row(
        "", "fraction of the brake's torque", usual=1.0, range=FRACTION_RANGE, varies="factor", logged="held",
        option='fraction of the brake\'s torque, such as "0.5 @ 1 s"',
    ))  # fmt: skip
    dither: Signal = field(default=1.0, metadata=signal_row(
        "", "fraction of the valve's dither", usual=1.0, range=FRACTION_RANGE, logged="held",
        option='fraction of the valve\'s dither, such as "0 @ 1 s"',
    ))  # fmt: skip
    load: Signal = field(default=0.0, metadata=signal_row(
        "TORQUE", "external torque on a joint", usual=0.0, varies="adds",
        range=symmetric_range(MAX_LOAD, "N m", f'at most {MAX_LOAD:g} N m, such as "2 N m"'),
        option='on the joints, such as "2 N m @ 1 s"',
    ))  # fmt: skip
    drift: Signal = field(default=0.0, metadata=signal_row(
        "Voltage", "shift of the valve's centre", usual=0.0, range=drift_range, varies="adds",
        option='of the valve\'s neutral, such as "0.2 V @ 1 s"',
    ))  # fmt: skip
    supply: Signal | None = field(default=None, metadata=signal_row(
        "Gauge", "supply pressure", path="supply.pressure_gauge", by_joint=False, range=supply_range,
        varies="replaces", option='gauge, such as "0 bar @ 1 s"; repeatable', logged="measured", gauge=True,
    ))  # fmt: skip
    payload: Signal | None = field(default=None, metadata=signal_row(
        "Mass", "payload", path="arm.payload", by_joint=False, varies="replaces", logged="held",
        range=SignalRange(
            0.0, MAX_PAYLOAD, "kg", f'a mass of zero or more, up to {MAX_PAYLOAD:g} kg, such as "1.5 kg"'
        ),
        option='such as "2 kg @ 1 s"; repeatable',
    ))  # fmt: skip
    ambient: Signal | None = field(default=None, metadata=signal_row(
        "AmbientPressure", "absolute ambient pressure", path="supply.ambient_pressure", by_joint=False,
        varies="replaces", option='such as "0.9 bar @ 1 s"; repeatable', logged="measured",
        range=SignalRange(2e4, 1e6, "Pa", 'an absolute pressure from 0.2 to 10 bar, such as "0.9 bar"'),
    ))  # fmt: skip
    pressures: Pair | Mapping[str, Pair] | None = None
    noise: bool = True
    seed: int = 0

    @property
    def closed_loop(self) -> bool:
        """True if the controller drives the valves."""
        return self.opening is None and self.voltage is None

    @property
    def has_demand(self) -> bool:
        """True unless the demand is 0, the default, or a table that names no joint."""
        none = isinstance(self.demand, (int, float)) and self.demand == 0
        return not (none or (isinstance(self.demand, Mapping) and not self.demand))

    def __post_init__(self) -> None:
        """Refuse fields that are wrong for any machine; raise InputError naming the field."""
        from layflat.motion.signal_values import check_bool, check_integer  # noqa: PLC0415  # takes long to import

        check_bool(self.noise, "noise")
        check_integer(self.seed, "seed", 0, MAX_SEED)
        if self.tip is not None and self.has_demand:
            raise InputError("stands beside a demand", where="tip", right="give one or the other")
        if self.opening is not None and self.voltage is not None:
            raise InputError("stands beside a voltage", where="opening", right="give one or the other")
        beside = [name for name in ("tip", "demand_velocity", "demand_acceleration") if getattr(self, name) is not None]
        beside += ["demand"] * self.has_demand
        if self.opening is not None and beside:
            what = f"stands beside {beside[-1]}: a run in open loop follows none"
            raise InputError(what, where="opening", right="give one or the other")

    def cycles(self, cycle: float) -> int:
        """Return the number of control cycles of `cycle` s; raise InputError if the duration is out of range."""
        from layflat.motion.signal_values import read_duration  # noqa: PLC0415  # takes long to import

        duration = read_duration(self.duration)
        if not cycle <= duration <= MAX_DURATION:
            right = f"give {cycle:g} s to {MAX_DURATION:g} s"
            raise InputError(f"{duration:g} s is out of range", where="duration", right=right)
        return round(duration / cycle)


SIGNALS: dict[str, SignalRow] = {item.name: item.metadata["row"] for item in fields(Scenario) if item.metadata}


def signals_varied_by(combination: str) -> list[str]:
    """Return the names of the signals with this value of `SignalRow.varies`."""
    return [name for name, properties in SIGNALS.items() if properties.varies == combination]


def check_scenario(scenario: object) -> Scenario:
    """Return a scenario; raise InputError for any other object."""
    from layflat.description.wrong import shown  # noqa: PLC0415  # takes long to import

    if not isinstance(scenario, Scenario):
        right = f"give Scenario(demand={shown(scenario)})" if isinstance(scenario, (str, float)) else "give a Scenario"
        raise InputError(f"{shown(scenario)} is not a Scenario", where="scenario", right=right)
    return scenario
