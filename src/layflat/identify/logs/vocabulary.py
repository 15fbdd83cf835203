"""Vocabulary of headers: what words mean, and the signal that their meanings make."""

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
