"""What the words in a column's name mean."""

from __future__ import annotations

import re

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

_MEANINGS: dict[str, set[str]] = {}
for _role, _words in ROLES.items():
    for _word in _words.split():
        _MEANINGS.setdefault(_word, set()).add(_role)

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


def words_of(name: str) -> list[str]:
    """Words of a name in small letters: "/rig.pA_2" has rig, p, a, 2; digits stand alone."""
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+", name)]


def meanings(words: list[str]) -> set[str]:
    """What is meant by some words."""
    return set().union(*(_MEANINGS.get(word, set()) for word in words))


def signal_of(meant: set[str]) -> str | None:
    """The signal that is meant; None where nothing fits."""
    return next((signal for signal, roles in SIGNALS_OF if roles <= meant), None)
