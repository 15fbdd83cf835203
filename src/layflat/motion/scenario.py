"""All that happens to a machine during a run: demands and disturbances, as signals over time.

The fields of `Scenario` are the one table of signals. Arrays of the time loop, checks, options, keys of studies, names
and units of records and logs, and the table in docs/conventions.md are made of it: a further signal is a field here
and its place in the physics. `layflat simulate --help` reads the table, so nothing heavy is loaded for it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from math import inf, nan
from typing import TYPE_CHECKING, Annotated, Any, Literal

from annotated_types import Ge

from layflat.errors import InputError
from layflat.motion.plausible import SHARE, Range, at_most, centre_voltage, drift_range, supply_range, voltage_range

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.description import units as u
    from layflat.machine import Machine
    from layflat.motion.signal_rows import Signal
    from layflat.motion.signal_values import Angles, Pair, SignalKind, Value

MAX_SEED = 2**32 - 1  # of all random numbers
MAX_DURATION = 1e5  # s

MAX_SPEED = 200.0  # of a demand, rad/s: ten times as fast as the lightest arm
MAX_ACCELERATION = 1e5  # of a demand, rad/s2
MAX_STIFFNESS = 1e5  # of a joint, N m/rad
MAX_LOAD = 2e3  # torque on a joint from outside, N m: hoses of 300 mm give 500 N m
MAX_PAYLOAD = 500.0  # kg


@dataclass(frozen=True, kw_only=True)
class SignalRow:
    """A row of the table of signals: all that is known of a signal besides its name and its default."""

    written: str  # name in description/units.py of the kind of its values; empty: a share
    meaning: str
    usual: float | Callable[[Machine], float] = nan
    """Value before the first step, and of joints that are not named; not a number: as the machine has it."""
    path: str = ""  # of the machine's number that it replaces
    by_joint: bool = True  # False: all joints share it
    range: Range | Callable[[Machine], Range] | None = None  # of plausible values
    varies: Literal["", "factor", "adds", "replaces"] = ""
    """How values that differ from run to run come to those of a scenario; empty: they don't."""
    option: str = ""  # help of the option of `layflat simulate`, with an example; empty: it has none
    logged: Literal["", "held", "measured"] = ""  # how logs have it: as commanded, which holds, or as measured
    gauge: bool = False  # a pressure above the ambient one; in records and logs it is absolute

    @property
    def annotation(self) -> Any:
        """Type of its values in a file: a float, with its quantity and its bounds."""
        if not self.written:
            return Annotated[float, Ge(0)]
        from layflat.description import units  # noqa: PLC0415  # takes long to import

        kind = getattr(units, self.written)
        return Annotated[float, kind] if isinstance(kind, units.Quantity) else kind

    @property
    def quantity(self) -> u.Quantity | None:
        """None of a share."""
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
        """Return its value where nothing is said."""
        return self.usual(machine) if callable(self.usual) else self.usual

    def check(self, machine: Machine, values: Any, where: str) -> Array:
        """Return values (SI, any shape; nan: as usual) if they are plausible; raise InputError naming `where`."""
        limits = self.range(machine) if callable(self.range) else self.range or Range(-inf, inf, "", "")
        return limits.check(values, where)


def row(written: str, meaning: str, **rest: Any) -> dict[str, SignalRow]:
    """Return a row of the table, as a field of `Scenario` carries it."""
    return {"row": SignalRow(written=written, meaning=meaning, **rest)}


@dataclass(frozen=True)
class Scenario:
    """All that acts on a machine during a run. Text carries units; numbers are SI.

    A signal is a constant, steps [("0 s", ...), ("1 s", ...)], a function of time, an array with a row for each control
    cycle, or a table of pandas or xarray with times and the names of joints. Where a joint is not named it keeps what
    it had: the value of the step before, and before the first step a disturbance its usual value, a demand the start.
    An opening or a voltage acts in place of the controller: a run in open loop, or one that follows a log.

    Signals stand below, and in docs/conventions.md; besides them there are:

    Args:
        tip: places asked for of the tip instead of a demand (m), as {"x": "0.5 m", "y": "0 m"}, in space with "z", or a
            list of these; each is taken with the posture that is near to the one before.
        duration: s.
        start: angles at which the arm rests at first; default: the first demand.
        pressures: absolute pressures of the hoses A and B at the start, Pa, of all joints or by joint; those that hold
            where not given.
        noise: whether the sensors are noisy.
        seed: of the noise.
    """

    demand: Signal = field(default=0.0, metadata=row("Angle", "angle asked for", usual=0.0, logged="held"))
    tip: Signal | None = None
    demand_velocity: Signal | None = field(default=None, metadata=row(
        "ANGULAR_SPEED", "velocity of the demand; by default as it moves on", usual=0.0,
        range=at_most(MAX_SPEED, "rad/s", f'at most {MAX_SPEED:g} rad/s, such as "60 deg/s"; numbers are in rad/s'),
    ))  # fmt: skip
    demand_acceleration: Signal | None = field(default=None, metadata=row(
        "ANGULAR_ACCELERATION", "acceleration of the demand; by default as it moves on", usual=0.0,
        range=at_most(
            MAX_ACCELERATION, "rad/s2",
            f'at most {MAX_ACCELERATION:g} rad/s2, such as "30 rad/s^2"; numbers are in rad/s2',
        ),
    ))  # fmt: skip
    demand_stiffness: Signal = field(default=0.0, metadata=row(
        "Stiffness", "stiffness of joints at rest, for laws and machines that can; 0: as it comes", usual=0.0,
        range=Range(
            0.0, MAX_STIFFNESS, "N m/rad", f'a stiffness of zero or more, up to {MAX_STIFFNESS:g}, such as "20 N m/rad"'
        ),
    ))  # fmt: skip
    duration: Value = 2.0
    start: Angles | None = None
    opening: Signal | None = field(default=None, metadata=row(
        "", "opening of the valve, -1 to 1", usual=0.0,
        range=Range(-1.0, 1.0, "", "a share from -1 to 1"),
    ))  # fmt: skip
    voltage: Signal | None = field(default=None, metadata=row(
        "Voltage", "control voltage",
        usual=centre_voltage, range=voltage_range, logged="held",
    ))  # fmt: skip
    brake: Signal = field(default=1.0, metadata=row(
        "", "share of the brake's torque", usual=1.0, range=SHARE, varies="factor", logged="held",
        option='share of the brake\'s torque, such as "0.5 @ 1 s"',
    ))  # fmt: skip
    dither: Signal = field(default=1.0, metadata=row(
        "", "share of the valve's dither", usual=1.0, range=SHARE, logged="held",
        option='share of the valve\'s dither, such as "0 @ 1 s"',
    ))  # fmt: skip
    load: Signal = field(default=0.0, metadata=row(
        "TORQUE", "external torque on a joint", usual=0.0, varies="adds",
        range=at_most(MAX_LOAD, "N m", f'at most {MAX_LOAD:g} N m, such as "2 N m"'),
        option='on the joints, such as "2 N m @ 1 s"',
    ))  # fmt: skip
    drift: Signal = field(default=0.0, metadata=row(
        "Voltage", "shift of the valve's centre", usual=0.0, range=drift_range, varies="adds",
        option='of the valve\'s neutral, such as "0.2 V @ 1 s"',
    ))  # fmt: skip
    supply: Signal | None = field(default=None, metadata=row(
        "Gauge", "supply pressure", path="supply.pressure_gauge", by_joint=False, range=supply_range,
        varies="replaces", option='gauge, such as "0 bar @ 1 s"; repeatable', logged="measured", gauge=True,
    ))  # fmt: skip
    payload: Signal | None = field(default=None, metadata=row(
        "Mass", "payload", path="arm.payload", by_joint=False, varies="replaces", logged="held",
        range=Range(0.0, MAX_PAYLOAD, "kg", f'a mass of zero or more, up to {MAX_PAYLOAD:g} kg, such as "1.5 kg"'),
        option='such as "2 kg @ 1 s"; repeatable',
    ))  # fmt: skip
    ambient: Signal | None = field(default=None, metadata=row(
        "AmbientPressure", "absolute ambient pressure", path="supply.ambient_pressure", by_joint=False,
        varies="replaces", option='such as "0.9 bar @ 1 s"; repeatable', logged="measured",
        range=Range(2e4, 1e6, "Pa", 'an absolute pressure from 0.2 to 10 bar, such as "0.9 bar"'),
    ))  # fmt: skip
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
        from layflat.motion.signal_values import check_truth, check_whole  # noqa: PLC0415  # takes long to import

        check_truth(self.noise, "noise")
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
        from layflat.motion.signal_values import read_duration  # noqa: PLC0415  # takes long to import

        duration = read_duration(self.duration)
        if not cycle <= duration <= MAX_DURATION:
            right = f"give {cycle:g} s to {MAX_DURATION:g} s"
            raise InputError(f"{duration:g} s is out of range", where="duration", right=right)
        return round(duration / cycle)


SIGNALS: dict[str, SignalRow] = {one.name: one.metadata["row"] for one in fields(Scenario) if one.metadata}


def varying(way: str) -> list[str]:
    """Return the signals whose values may differ from run to run in a way."""
    return [name for name, one in SIGNALS.items() if one.varies == way]


def check_scenario(scenario: object) -> Scenario:
    """Return a scenario; raise InputError if something else was given."""
    from layflat.description.wrong import shown  # noqa: PLC0415  # takes long to import

    if not isinstance(scenario, Scenario):
        right = f"give Scenario(demand={shown(scenario)})" if isinstance(scenario, (str, float)) else "give a Scenario"
        raise InputError(f"{shown(scenario)} is not a Scenario", where="scenario", right=right)
    return scenario
