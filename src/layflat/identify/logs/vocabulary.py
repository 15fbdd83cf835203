"""Vocabulary of headers: the meanings of words, the signals that these make, and how signals are treated in time."""

from dataclasses import dataclass
from math import radians

from layflat.description import units as u
from layflat.motion.scenario import SIGNALS as ACTING
from layflat.motion.scenario import SignalRow

ROLES = {
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
"""Words of several languages by what they mean; a word can mean several things."""

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

_ORIGINS = {
    "filtered": "filt filtered filter lp lowpass smooth smoothed est estimated sim simulated model",
    "statistic": "min max minimum maximum std stdev sd var variance count rms",
    "raw": "raw roh brut rq rp rpa rpb",
    "other": "meas measured act actual ist sensor value wert mean avg smp",
}
FILTERED, STATISTICS = frozenset(_ORIGINS["filtered"].split()), frozenset(_ORIGINS["statistic"].split())
RAW = frozenset(_ORIGINS["raw"].split())
QUALIFIERS = FILTERED | RAW | frozenset(_ORIGINS["other"].split())
"""Words that say how a column was come by, not what it measures."""

ROLE_WORDS = frozenset(word for words in ROLES.values() for word in words.split())


def meanings(words: list[str]) -> set[str]:
    """Return the roles that words have."""
    return {role for role, known in ROLES.items() if not set(words).isdisjoint(known.split())}


def signal_of(meant: set[str]) -> str | None:
    """Return the signal that some roles make; None where nothing fits."""
    return next((signal for signal, roles in SIGNALS_OF if roles <= meant), None)


FORCE = u.Quantity("force", "N", "12 N")

SHOWN = {"Pa": ("bar", 1e5), "rad": ("deg", radians(1.0)), "m": ("mm", 1e-3)}  # units that people read, and their sizes
AMBIENT = 101325.0  # pressure of a standard atmosphere, Pa: gauge pressures count from it where nothing else is said


@dataclass(frozen=True)
class Signal:
    """One of the standard signals, as in a log's data set."""

    name: str
    kind: u.Quantity | None  # of quantity; None is a share, without unit
    meaning: str
    by_joint: bool = True  # each joint has its own
    held: bool = False  # what is commanded, and holds until the next sample; all else is measured
    absolute: bool = False  # an absolute pressure inside: a log has to say whether it counts from ambient pressure

    @property
    def unit(self) -> str:
        """SI unit."""
        return "1" if self.kind is None else self.kind.unit.replace("*", " ")

    @property
    def shown(self) -> tuple[str, float]:
        """The unit that people read, and its size in SI."""
        return ("%", 0.01) if self.kind is None else SHOWN.get(self.unit, (self.unit, 1.0))


def _acting(name: str, row: SignalRow) -> Signal:
    """Return a signal that acts on a machine, as a log has it."""
    held = row.logged == "held"
    return Signal(name, row.quantity, row.recorded[1], row.by_joint, held, absolute=row.gauge)


SIGNALS = {
    signal.name: signal
    for signal in (
        Signal("angle", u.ANGLE, "joint angle"),
        Signal("pressure_a", u.PRESSURE, "absolute pressure in hose A", absolute=True),
        Signal("pressure_b", u.PRESSURE, "absolute pressure in hose B", absolute=True),
        Signal("measured_pressure", u.PRESSURE, "differential pressure, hose A less hose B"),
        Signal("torque", u.TORQUE, "torque at the joint"),
        *(_acting(name, row) for name, row in ACTING.items() if row.logged),
        Signal("setpoint_a", u.PRESSURE, "absolute pressure asked for in hose A", held=True, absolute=True),
        Signal("setpoint_b", u.PRESSURE, "absolute pressure asked for in hose B", held=True, absolute=True),
        Signal("position", u.LENGTH, "position of what moves in a line", by_joint=False),
        Signal("force", FORCE, "force on what moves in a line", by_joint=False),
        Signal("pressure", u.PRESSURE, "absolute pressure of a chamber", by_joint=False, absolute=True),
        Signal("temperature", u.TEMPERATURE, "temperature of the gas in a chamber", by_joint=False),
    )
}
"""By name, in the order in which they are listed."""

_SHARES = {"1": 1.0, "share": 1.0, "%": 0.01, "percent": 0.01}


def conversion(unit: str, signal: Signal) -> tuple[float, float]:
    """Factor and shift that turn numbers in a unit, such as "kPa", "1.2 deg" or "degC", into SI: x factor + shift.

    Raise ValueError if it is none, with one clause that says what is wrong and what would be right.
    """
    text = unit.strip()
    if signal.kind is None:
        if text not in _SHARES:
            raise ValueError(f"{unit!r} is not a unit of a share; give one of {', '.join(map(repr, _SHARES))}")
        return _SHARES[text], 0.0
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
    """Return how one signal of one joint is called: "angle.elbow", or "force" where there is no joint."""
    return f"{signal}.{joint}" if joint else signal
