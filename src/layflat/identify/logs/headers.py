"""What a column's header says of it: a name, what its words mean, and often a unit."""

import re
from dataclasses import dataclass

_UNITS = {
    "pa": "Pa", "hpa": "hPa", "kpa": "kPa", "mpa": "MPa", "bar": "bar", "mbar": "mbar", "psi": "psi",
    "rad": "rad", "mrad": "mrad", "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg",
    "v": "V", "mv": "mV", "volt": "V", "volts": "V",
    "s": "s", "sec": "s", "seconds": "s", "ms": "ms", "us": "us", "µs": "us", "ns": "ns", "min": "min",
    "nm": "N m", "n m": "N m", "n*m": "N m", "n·m": "N m", "n": "N", "kn": "kN",
    "m": "m", "mm": "mm", "cm": "cm", "um": "um", "µm": "um",
    "k": "K", "degc": "degC", "°c": "degC", "degf": "degF", "kg": "kg", "g": "g", "%": "%", "1": "1",
}  # fmt: skip
"""How units are written in headers, in small letters, and how they are written here."""

_TOO_SHORT = {"v", "s", "n", "m", "k", "g", "1", "min", "°"}  # no unit at the end of a name: the k of "torque_k"

_BRACKETS = re.compile(r"^(?P<stem>.*?)\s*[\[({](?P<unit>[^\[\](){}]*)[\])}]\s*$")
_GAUGE = re.compile(r"^(?P<unit>[a-zA-Z]+?)[\s_]*\(?(?P<kind>gauge|abs|absolute|g|a)\)?$")
_PRESSURES = {"Pa", "hPa", "kPa", "MPa", "bar", "mbar", "psi"}

ROLES = {
    "angle": "angle theta q rq phi alpha encoder enc pot potentiometer winkel measured_angle qdes joint_angle",
    "pressure": "p rp pressure press prs druck pa pb rpa rpb ca cb pset pdes pref dp ps psup pdiff psupply",
    "a": "a pa rpa ca",
    "b": "b pb rpb cb",
    "asked": "des dem demand desired ref reference target setpoint sp cmd command goal soll qdes ca cb pset pdes pref",
    "difference": "dp pdiff diff difference differential delta",
    "supply": "supply ps psup psupply sup line mains",
    "voltage": "voltage volt volts u v vc uc valve spannung ventil",
    "torque": "torque tau moment effort tq drehmoment",
    "force": "force f loadcell kraft",
    "brake": "brake bremse",
    "payload": "payload mass last",
    "temperature": "temperature temp tgas temperatur",
    "position": "position pos x displacement travel weg laser",
    "rate": "dq rdq dqdes velocity vel speed omega acc acceleration rate",
    "clock": "t time stamp timestamp timestamps zeit seconds sec elapsed clock",
}
"""Words by what they mean; a word can mean several things."""

SIGNALS_OF: tuple[tuple[str, set[str]], ...] = (
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
"""Signals by what all has to be meant, the first that fits."""


@dataclass(frozen=True)
class Header:
    """What is said of a column, by the name that the file and a mapping have for it."""

    name: str
    unit: str = ""  # as pint knows it; empty where the file doesn't say
    gauge: bool | None = None  # whether a pressure counts from ambient; None where the file doesn't say
    stem: str = ""  # the name without its unit


def written_unit(text: str) -> tuple[str, bool | None]:
    """A unit such as "bar_abs", "kPag" or "deg" as pint knows it, or nothing; and whether it is a gauge pressure."""
    plain = text.strip()
    if plain.lower() in _UNITS:
        return _UNITS[plain.lower()], None
    found = _GAUGE.match(plain)
    unit = _UNITS.get(found["unit"].lower(), "") if found else ""
    if found and unit in _PRESSURES:
        return unit, found["kind"] in {"gauge", "g"}
    return "", None


def header_of(name: str, stated: str = "") -> Header:
    """Name and unit of a header such as "p_A [kPa]", "theta_deg" or "time (ms)", or the unit stated elsewhere."""
    name = name.strip()
    bracketed = _BRACKETS.match(name)
    stem, unit, gauge = (bracketed["stem"], *written_unit(bracketed["unit"])) if bracketed else _suffixed(name)
    if stated:
        said, said_gauge = written_unit(stated)
        unit, gauge = said or stated.strip(), gauge if said_gauge is None else said_gauge
    return Header(name, unit, gauge, stem or name)


def _suffixed(name: str) -> tuple[str, str, bool | None]:
    """A unit behind the last underscore, or the last two: "p_a_bar_abs"."""
    for count in (2, 1):
        parts = re.split(r"[_\s]", name)
        if len(parts) <= count:
            continue
        tail = " ".join(parts[-count:])
        unit, gauge = written_unit(tail.replace(" ", "_") if count == 2 else tail)
        short = tail.lower() in _TOO_SHORT and not (tail.lower() == "s" and parts[0].lower() in {"t", "time"})
        if unit and not short:
            return name[: len(name) - len(tail) - 1], unit, gauge
    return name, "", None


def words_of(name: str) -> list[str]:
    """Words of a name in small letters: "/rig.pA_2" has rig, p, a, 2; digits stand alone."""
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+", name)]


def meanings(words: list[str]) -> set[str]:
    """What is meant by some words."""
    return {role for role, known in ROLES.items() if not set(words).isdisjoint(known.split())}


def signal_of(meant: set[str]) -> str | None:
    """The signal that is meant; None where nothing fits."""
    return next((signal for signal, roles in SIGNALS_OF if roles <= meant), None)
