"""Units as headers write them, read by the parser of descriptions, with words for gauge and absolute around them."""

import re
from functools import lru_cache

from layflat.description import units as u
from layflat.description.expression import QuantityError
from layflat.identify.logs.vocabulary import FORCE

KINDS = (u.PRESSURE, u.ANGLE, u.VOLTAGE, u.TORQUE, FORCE, u.TEMPERATURE, u.LENGTH, u.MASS, u.TIME,
         u.ANGULAR_SPEED, u.SPEED, u.ANGULAR_ACCELERATION, u.ACCELERATION, u.FLOW, u.FREQUENCY)  # fmt: skip
"""Kinds of quantities that a log may hold, the first that a unit measures."""

SPELLINGS = {
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
"""Units as the parser of descriptions knows them, and their spellings in small letters."""

ALIASES = {spelling: unit for unit, spellings in SPELLINGS.items() for spelling in spellings.split(", ")}

AMBIGUOUS = {
    "grad": "deg or gon",
    "cycle": "turn or 1",
    "cycles": "turn or 1",
}  # degrees in German, a hundredth of a right angle in English
DATES = {"hh:mm:ss", "h:m:s", "hh:mm:ss.fff", "hh:mm:ss.000", "utc", "ts", "datetime", "date", "dd.mm.yyyy"}
"""Words that stand in place of a unit above dates and clock times."""

_EXACT = {"mPa": "mPa", "Grad": "deg", "MN": "MN"}  # which in small letters would be another unit
SHORT_NAME = 4  # letters
_SHORT = {"ft", "yd", "mil", "ozf", "dyn", "ksi"}
MAX_UNIT = 20  # characters of a unit
_SQUARED = re.compile(r"(?<![^\W\d_])(mm|cm|m|in|ft)([23])(?!\d)")
_ZEROS = {
    True: "gauge gage g rel relative relativ relativo relativa relatif ü ue überdruck eff",
    False: "abs absolute absolut absolu a",
}
GAUGE_WORDS = {word: gauge for gauge, group in _ZEROS.items() for word in group.split()}
_WORDS = "|".join(sorted(GAUGE_WORDS, key=len, reverse=True))
_AROUND = re.compile(rf"^(?P<unit>.*?)[\s_.,(\[-]*\b(?P<kind>{_WORDS})[)\].]*$", re.IGNORECASE)
_BEFORE = re.compile(rf"^(?P<kind>{_WORDS})[\s_.,(\[-]+(?P<unit>.*?)[)\]]*$", re.IGNORECASE)
_STUCK = re.compile(
    r"^(?P<unit>bar|mbar|kpa|mpa|hpa|pa|psi|kgf/cm2|kgf/cm\^2|kg/cm2|at)(?P<kind>g|a|ü|abs|rel)$", re.IGNORECASE
)


def unit_written(text: str, *, listed: bool = False) -> tuple[str, bool | None] | None:
    """Return a unit such as "bar_abs", "kPa (g)", "kgf/cm2" or "deg" as descriptions write it, and its zero.

    Args:
        text: what stands in brackets, in a row of units, or behind a name.
        listed: take units of the list of spellings alone, as behind a name; else all that descriptions know.

    Returns:
        The unit, and True of a gauge pressure, False of an absolute one, None where it doesn't say. None for a text
        that is no unit of what a log holds.
    """
    plain = " ".join(text.replace("µ", "u").replace("μ", "u").replace("²", "2").replace("³", "3").split())
    unit = _plain_unit(plain, listed)
    if unit is not None:
        return unit, None
    for pattern in (_STUCK, _AROUND, _BEFORE):
        match = pattern.match(plain)
        unit = _plain_unit(match["unit"].strip(" _-.,()[]"), listed) if match else None
        if pattern is _BEFORE and match and len(match["kind"]) == 1:
            continue  # a hose's letter
        if match and unit is not None and kind_of_unit(unit) == u.PRESSURE:
            return unit, GAUGE_WORDS[match["kind"].lower()]
    return None


def _plain_unit(text: str, listed: bool) -> str | None:
    if text in _EXACT:
        return _EXACT[text]
    if text.lower() == "pa" and text != "Pa" and (listed or text == "pA"):
        return None  # the pressure of hose A
    if text.lower() in ALIASES:
        return ALIASES[text.lower()]
    odd = text.isalpha() and len(text) < SHORT_NAME and text not in _SHORT  # three letters can be any prefix and unit
    if listed or odd or len(text) < 2 or len(text) > MAX_UNIT or text.lower() in AMBIGUOUS or text[0].isdigit():
        return None
    written = _SQUARED.sub(r"\1^\2", text)
    return written if kind_of_unit(written) is not None else None


@lru_cache(maxsize=1000)
def kind_of_unit(unit: str) -> u.Quantity | None:
    """Return the kind of quantity that a unit measures; None where it is none of a log's."""
    return next((kind for kind in KINDS if measures(unit, kind)), None)


@lru_cache(maxsize=4000)
def measures(unit: str, kind: u.Quantity) -> bool:
    """Return whether a unit measures a kind of quantity."""
    try:
        kind.convert(f"1 {unit}")
    except (QuantityError, ValueError, OverflowError):
        return False
    return bool(unit)
