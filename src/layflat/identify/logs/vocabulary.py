"""Vocabulary of headers: roles of words, signals by roles, and units.

Units are as headers write them, with words for gauge and absolute beside them, and are parsed as in descriptions.
"""

import re
from dataclasses import dataclass
from functools import lru_cache
from math import radians

from layflat.description import units as u
from layflat.description.expression import QuantityError
from layflat.motion.scenario import SIGNALS as ACTING
from layflat.motion.scenario import SignalRow

WORDS_BY_ROLE = {
    "angle": (
        "angle ang theta q rq phi alpha encoder enc pot potentiometer winkel measured_angle qdes joint_angle "
        "vinkel hoek kulma kąt úhel szög ângulo açı угол 角度 "
        "drehwinkel gelenkwinkel angolo angulo sollwinkel istwinkel ángulo θ φ ϕ α"
    ),
    "pressure": (
        "p rp pressure press prs druck pa pb rpa rpb ca cb pset pdes pref dp ps psup pdiff psupply pression "
        "pressione pressão pressao tryck trykk tryk paine ciśnienie tlak nyomás basınç давление 压力 圧力 "
        "presion presión schlauchdruck kammerdruck versorgungsdruck vordruck solldruck "
        "differenzdruck druckdifferenz pneu pres"
    ),
    "a": "a pa rpa ca",
    "b": "b pb rpb cb",
    "asked": (
        "des dem set demand desired ref reference target setpoint sp cmd command goal soll qdes ca cb pset pdes "
        "pref sollwert sollwinkel solldruck consigne wanted"
    ),
    "difference": "dp pdiff diff difference differential delta differenz differenzdruck druckdifferenz",
    "supply": "supply ps psup psupply sup line mains versorgung versorgungsdruck vordruck alimentation",
    "voltage": (
        "spänning ventilspänning spænding jännite napięcie napětí feszültség gerilim напряжение klepspanning tensão "
        "voltage volt volts u v vc uc valve spannung ventil ventilspannung stellspannung tension tensione vanne voltaje"
    ),
    "torque": "torque tau moment effort tq drehmoment couple coppia momento",
    "force": "force f loadcell kraft",
    "brake": "brake bremse frein freno",
    "payload": "payload mass last nutzlast charge carico",
    "ambient": "ambient amb atm atmospheric baro barometer barometric umgebung umgebungsdruck luftdruck ambiante",
    "temperature": "temperature temp tgas temperatur température temperatura",
    "position": "position pos x displacement travel weg laser hub",
    "rate": (
        "dq rdq dqdes velocity vel speed omega acc acceleration rate geschwindigkeit vitesse drehzahl beschleunigung"
    ),
    "clock": (
        "t time stamp timestamp timestamps zeit seconds sec secs elapsed clock millis micros nanos ms us "
        "tid tijd aika czas čas idő zaman время 时间 時間 datetime date temps heure uhrzeit datum tempo tiempo uhr"
    ),
}
"""Words of several languages by role; a word can have several roles."""

SIGNAL_ROLES: tuple[tuple[str, set[str]], ...] = (
    ("setpoint_a", {"asked", "pressure", "a"}),
    ("setpoint_b", {"asked", "pressure", "b"}),
    ("measured_pressure", {"difference", "pressure"}),
    ("supply", {"supply"}),
    ("pressure_a", {"pressure", "a"}),
    ("pressure_b", {"pressure", "b"}),
    ("brake", {"brake"}),
    ("payload", {"payload"}),
    ("voltage", {"voltage"}),
    ("demand", {"asked", "angle"}),
    ("demand", {"asked"}),
    ("torque", {"torque"}),
    ("force", {"force"}),
    ("temperature", {"temperature"}),
    ("pressure", {"pressure"}),
    ("angle", {"angle"}),
    ("position", {"position"}),
)
"""Roles that a name must have for a signal, all of them; the first match counts."""

_ORIGIN_WORDS = {
    "filtered": "filt filtered filter lp lowpass smooth smoothed est estimated sim simulated model",
    "statistic": "min max minimum maximum std stdev sd var variance count rms",
    "raw": "raw roh brut rq rp rpa rpb",
    "other": "meas measured act actual ist sensor value wert mean avg smp",
}
FILTER_WORDS, STATISTIC_WORDS = (
    frozenset(_ORIGIN_WORDS["filtered"].split()),
    frozenset(_ORIGIN_WORDS["statistic"].split()),
)
RAW_WORDS = frozenset(_ORIGIN_WORDS["raw"].split())
QUALIFIER_WORDS = FILTER_WORDS | RAW_WORDS | frozenset(_ORIGIN_WORDS["other"].split())
"""Words on the origin of a column, not on the measured quantity."""

ROLE_WORDS = frozenset(word for words in WORDS_BY_ROLE.values() for word in words.split())


def word_roles(words: list[str]) -> set[str]:
    """Return the roles of words, such as "pressure" and "a" of "pa"."""
    return {role for role, vocabulary in WORDS_BY_ROLE.items() if not set(words).isdisjoint(vocabulary.split())}


def signal_for_roles(name_roles: set[str]) -> str | None:
    """Return the signal by the roles of a name; None where there is none."""
    return next((signal for signal, roles in SIGNAL_ROLES if roles <= name_roles), None)


FORCE = u.Quantity("force", "N", "12 N")

DISPLAY_UNITS = {"Pa": ("bar", 1e5), "rad": ("deg", radians(1.0)), "m": ("mm", 1e-3)}  # unit and its size, by SI unit
AMBIENT = 101325.0  # standard atmosphere, Pa: default zero of gauge pressures


@dataclass(frozen=True)
class LogSignal:
    """Standard signal of a log's data set."""

    name: str
    kind: u.Quantity | None  # of quantity; None for a fraction without unit
    meaning: str
    by_joint: bool = True  # has a column for each joint
    held: bool = False  # a command, which holds until the next sample; others are measured
    absolute: bool = False  # absolute pressure in the data set: a log has to say whether it is a gauge pressure

    @property
    def unit(self) -> str:
        """SI unit, "1" of a fraction."""
        return "1" if self.kind is None else self.kind.unit.replace("*", " ")

    @property
    def display_unit(self) -> tuple[str, float]:
        """Unit for people, such as "bar", and its size in SI."""
        return ("%", 0.01) if self.kind is None else DISPLAY_UNITS.get(self.unit, (self.unit, 1.0))


def _acting_signal(name: str, row: SignalRow) -> LogSignal:
    """Return the signal of a log for one that acts on a machine."""
    held = row.logged == "held"
    return LogSignal(name, row.quantity, row.recorded[1], row.by_joint, held, absolute=row.gauge)


SIGNALS = {
    signal.name: signal
    for signal in (
        LogSignal("angle", u.ANGLE, "joint angle"),
        LogSignal("pressure_a", u.PRESSURE, "absolute pressure in hose A", absolute=True),
        LogSignal("pressure_b", u.PRESSURE, "absolute pressure in hose B", absolute=True),
        LogSignal("measured_pressure", u.PRESSURE, "differential pressure, hose A less hose B"),
        LogSignal("torque", u.TORQUE, "torque at the joint"),
        *(_acting_signal(name, row) for name, row in ACTING.items() if row.logged),
        LogSignal("setpoint_a", u.PRESSURE, "absolute pressure asked for in hose A", held=True, absolute=True),
        LogSignal("setpoint_b", u.PRESSURE, "absolute pressure asked for in hose B", held=True, absolute=True),
        LogSignal("position", u.LENGTH, "position of what moves in a line", by_joint=False),
        LogSignal("force", FORCE, "force on what moves in a line", by_joint=False),
        LogSignal("pressure", u.PRESSURE, "absolute pressure of a chamber", by_joint=False, absolute=True),
        LogSignal("temperature", u.TEMPERATURE, "temperature of the gas in a chamber", by_joint=False),
    )
}
"""Signals by name, in the order of lists."""

_FRACTION_UNITS = {"1": 1.0, "share": 1.0, "%": 0.01, "percent": 0.01}


def unit_conversion(unit: str, signal: LogSignal) -> tuple[float, float]:
    """Return factor and shift from a unit, such as "kPa", "1.2 deg" or "degC", to SI: x factor + shift.

    Raise ValueError with problem and advice if it is no unit of the signal.
    """
    text = unit.strip()
    if signal.kind is None:
        if text not in _FRACTION_UNITS:
            raise ValueError(
                f"{unit!r} is not a unit of a fraction; give one of {', '.join(map(repr, _FRACTION_UNITS))}"
            )
        return _FRACTION_UNITS[text], 0.0
    numbered = text[:1].isdigit() or text[:1] == "."
    try:
        shift = 0.0 if numbered else signal.kind.convert(f"0 {text}")
        factor = signal.kind.convert(text if numbered else f"1 {text}") - shift
    except ValueError:
        article, unit_of_it = signal.kind.article, signal.kind.example.partition(" ")[2]
        raise ValueError(f'{unit!r} is not a unit of {article}; give one such as "{unit_of_it}"') from None
    if factor <= 0.0:
        raise ValueError(f"{unit!r} is not positive; turn a signal round with sign = -1")
    return factor, shift


def channel_name(signal: str, joint: str | None) -> str:
    """Return the name of a channel: "angle.elbow", or "force" for a signal without joint."""
    return f"{signal}.{joint}" if joint else signal


KINDS = (u.PRESSURE, u.ANGLE, u.VOLTAGE, u.TORQUE, FORCE, u.TEMPERATURE, u.LENGTH, u.MASS, u.TIME,
         u.ANGULAR_SPEED, u.SPEED, u.ANGULAR_ACCELERATION, u.ACCELERATION, u.FLOW, u.FREQUENCY)  # fmt: skip
"""Kinds of quantities in logs; of several for one unit the first counts."""

UNIT_SPELLINGS = {
    "Pa": "pa", "hPa": "hpa", "kPa": "kpa, кпа", "MPa": "mpa", "bar": "bar, bars, бар", "mbar": "mbar, millibar",
    "psi": "psi, lb/in2, lb/in^2, lbf/in2, lbf/in^2", "torr": "torr", "mmHg": "mmhg", "inHg": "inhg",
    "inH2O": "inh2o, inwc", "mmH2O": "mmh2o, mmws, mmwc", "cmH2O": "cmh2o", "atm": "atm", "at": "at",
    "kgf/cm^2": "ksc, kgf/cm2, kgf/cm^2, kg/cm2, kg/cm^2, kp/cm2, kp/cm^2, kgfcm2, kgcm2", "ksi": "ksi",
    "N/mm^2": "n/mm2, nmm2", "rad": "rad, rads, radian, radians", "mrad": "mrad",
    "deg": (
        "deg, degs, degree, degrees, deg., grader, graden, gradi, grados, graus, degrés, degres, stopnie, astetta, "
        "град, °, º, ˚"
    ), "turn": "rev, revs, turns", "gon": "gon",
    "V": "v, vdc, v dc, volt, volts", "mV": "mv, millivolt, millivolts", "kV": "kv",
    "s": "s, sec, secs, second, seconds, sekunden, sek, secondes",
    "ms": "ms, msec, msecs, millis, millisec, millisecond, milliseconds",
    "us": "us, usec, usecs, micros, microsec, microsecond, microseconds",
    "ns": "ns, nsec, nsecs, nanos, nanosec, nanosecond, nanoseconds", "min": "min, minute, minutes",
    "h": "h, hr, hrs, hour, hours", "day": "d, day, days, tage", "N m": "nm, n m, n*m, n·m, n.m, n-m, newtonmeter",
    "N mm": "nmm, n mm", "N cm": "ncm, n cm", "kN m": "knm", "mN m": "mnm", "lbf*in": "lbf*in, inlb, in-lb, lbin",
    "lbf*ft": "ftlb, ft-lb", "N": "n, newton, newtons", "kN": "kn", "mN": "mn", "kgf": "kgf, kp", "lbf": "lbf, lbs",
    "m": "m", "mm": "mm", "cm": "cm", "um": "um", "in": "in, inch, inches", "K": "k, kelvin",
    "degC": "degc, deg c, °c, º c, ºc, ˚c, ° c, ℃, c, celsius, grad c", "degF": "degf, deg f, °f, ° f, ℉, f",
    "kg": "kg", "g": "g", "%": "%, percent, pct", "1": "1", "rpm": "rpm", "Hz": "hz", "deg/s": "deg/s, °/s",
    "rad/s": "rad/s", "l/min": "l/min, nl/min", "m/s": "m/s",
}  # fmt: skip
"""Spellings of units in small letters, by the unit in descriptions."""

UNIT_BY_SPELLING = {spelling: unit for unit, spellings in UNIT_SPELLINGS.items() for spelling in spellings.split(", ")}

AMBIGUOUS_UNITS = {
    "grad": "deg or gon",
    "cycle": "turn or 1",
    "cycles": "turn or 1",
}  # "grad" is a degree in German, a hundredth of a right angle in English
DATE_WORDS = {"hh:mm:ss", "h:m:s", "hh:mm:ss.fff", "hh:mm:ss.000", "utc", "ts", "datetime", "date", "dd.mm.yyyy"}
"""Words in place of a unit above dates and clock times."""

_CASE_SENSITIVE_UNITS = {"mPa": "mPa", "Grad": "deg", "MN": "MN"}  # another unit in small letters
MIN_PREFIXED_LETTERS = 4  # letters
_SHORT_UNITS = {"ft", "yd", "mil", "ozf", "dyn", "ksi"}
MAX_UNIT_LENGTH = 20
_POWER_SUFFIX = re.compile(r"(?<![^\W\d_])(mm|cm|m|in|ft)([23])(?!\d)")
_GAUGE_SPELLINGS = {
    True: "gauge gage g rel relative relativ relativo relativa relatif ü ue überdruck eff",
    False: "abs absolute absolut absolu a",
}
GAUGE_WORDS = {word: gauge for gauge, group in _GAUGE_SPELLINGS.items() for word in group.split()}
_GAUGE_PATTERN = "|".join(sorted(GAUGE_WORDS, key=len, reverse=True))
_UNIT_THEN_GAUGE = re.compile(rf"^(?P<unit>.*?)[\s_.,(\[-]*\b(?P<kind>{_GAUGE_PATTERN})[)\].]*$", re.IGNORECASE)
_GAUGE_THEN_UNIT = re.compile(rf"^(?P<kind>{_GAUGE_PATTERN})[\s_.,(\[-]+(?P<unit>.*?)[)\]]*$", re.IGNORECASE)
_UNIT_WITH_GAUGE = re.compile(
    r"^(?P<unit>bar|mbar|kpa|mpa|hpa|pa|psi|kgf/cm2|kgf/cm\^2|kg/cm2|at)(?P<kind>g|a|ü|abs|rel)$", re.IGNORECASE
)


def parse_unit(text: str, *, listed: bool = False) -> tuple[str, bool | None] | None:
    """Return the unit of descriptions for a text such as "bar_abs", "kPa (g)", "kgf/cm2" or "deg", and its zero.

    Args:
        text: text from brackets, a row of units, or behind a name.
        listed: accept only units of `UNIT_SPELLINGS`, as behind a name; else all units of descriptions.

    Returns:
        The unit; and True for a gauge pressure, False for an absolute one, None where neither is stated. None for a
        text that is no unit of a log.
    """
    plain = " ".join(text.replace("µ", "u").replace("μ", "u").replace("²", "2").replace("³", "3").split())
    unit = _parse_plain_unit(plain, listed)
    if unit is not None:
        return unit, None
    for pattern in (_UNIT_WITH_GAUGE, _UNIT_THEN_GAUGE, _GAUGE_THEN_UNIT):
        match = pattern.match(plain)
        unit = _parse_plain_unit(match["unit"].strip(" _-.,()[]"), listed) if match else None
        if pattern is _GAUGE_THEN_UNIT and match and len(match["kind"]) == 1:
            continue  # a hose's letter
        if match and unit is not None and kind_of_unit(unit) == u.PRESSURE:
            return unit, GAUGE_WORDS[match["kind"].lower()]
    return None


def _parse_plain_unit(text: str, listed: bool) -> str | None:
    """Return the unit of descriptions for a text without words for its zero; None where it is none."""
    if text in _CASE_SENSITIVE_UNITS:
        return _CASE_SENSITIVE_UNITS[text]
    if text.lower() == "pa" and text != "Pa" and (listed or text == "pA"):
        return None  # the pressure of hose A
    if text.lower() in UNIT_BY_SPELLING:
        return UNIT_BY_SPELLING[text.lower()]
    odd = (
        text.isalpha() and len(text) < MIN_PREFIXED_LETTERS and text not in _SHORT_UNITS
    )  # three letters can be any prefix and unit
    if (
        listed
        or odd
        or len(text) < 2
        or len(text) > MAX_UNIT_LENGTH
        or text.lower() in AMBIGUOUS_UNITS
        or text[0].isdigit()
    ):
        return None
    written = _POWER_SUFFIX.sub(r"\1^\2", text)
    return written if kind_of_unit(written) is not None else None


@lru_cache(maxsize=1000)
def kind_of_unit(unit: str) -> u.Quantity | None:
    """Return the kind of quantity of a unit; None for units that logs do not have."""
    return next((kind for kind in KINDS if is_unit_of(unit, kind)), None)


@lru_cache(maxsize=4000)
def is_unit_of(unit: str, kind: u.Quantity) -> bool:
    """Return whether a unit is one of a kind of quantity."""
    try:
        kind.convert(f"1 {unit}")
    except (QuantityError, ValueError, OverflowError):
        return False
    return bool(unit)
