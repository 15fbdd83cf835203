"""Vessels in the YAML input files of HydDown, which calculates their discharge and filling (andreasen2021).

Its fields are those of its manual.
"""

from collections.abc import Callable
from functools import partial
from math import pi
from pathlib import Path
from typing import Any

from layflat import extras
from layflat.description.text import read_text
from layflat.errors import InputError
from layflat.physics.flow import sonic_conductance

FLUID_NAMES = {
    "air": "air", "n2": "nitrogen", "o2": "oxygen", "h2": "hydrogen", "he": "helium", "ar": "argon", "ch4": "methane",
    "co2": "carbon dioxide", "carbondioxide": "carbon dioxide",
}  # fmt: skip
"""Names of gases by those of the files."""

HEAD_SHAPES = {
    "flat-end": (0.0, pi / 4),
    "asme f&d": (0.0809, 0.929),
    "din": (0.1, 0.99),
    "semi-elliptical": (pi / 24, 1.084),
    "hemispherical": (pi / 12, pi / 2),
}
"""Volume and area of a head of the vessel, over the third and second power of the diameter."""

CONDUCTANCE_PER_CV = 3.9e-8  # C of a control valve with Cv = 1, m3/(s Pa): IEC 60534-2-1, choked air with x_T = 0.7

NOZZLE_CRITICAL_RATIO, VALVE_CRITICAL_RATIO = (
    0.45,
    0.3,
)  # guesses: of a hole, nozzle or sharp edge; of a control valve
REQUIRED_TABLES = ("vessel", "initial", "valve")

Number = Callable[..., float]  # returns the number at a path of the file, such as "vessel.length", or a default


def hyddown_tables(path: str | Path) -> dict[str, Any]:
    """Return plain tables of a vessel's description from HydDown's file; raise InputError if a field can't be used."""
    where, tables = str(path), _read_tables(Path(path))
    vessel, start, valve = (tables[key] for key in REQUIRED_TABLES)
    number = partial(_number, tables, where)
    fluid = str(start.get("fluid", "")).lower().replace(" ", "")
    name = FLUID_NAMES.get(fluid, fluid)
    if name not in FLUID_NAMES.values():
        right = f"use {', '.join(sorted(set(FLUID_NAMES.values())))}"
        raise InputError(f"{start.get('fluid')!r} is an unknown gas", where=f"{where}: initial.fluid", right=right)
    T = number("initial.temperature")
    ambient = number("heat_transfer.temp_ambient", T)
    space, capacity, outer = _vessel_sizes(vessel, number, where)
    wall = {"outer_conductance": f"{number('heat_transfer.h_outer', 0.0) * outer!r} W/K"} | capacity
    return {
        "kind": "vessel",
        "name": Path(path).name.removesuffix(".rig.yml"),
        "title": f"{name}, {valve.get('flow', 'discharge')}",
        "gas": {"name": name, "law": "real"},
        "space": space,
        "wall": wall,
        "path": _read_valve(valve, number, where),
        "outside": _conditions(number("valve.back_pressure"), ambient),
        "ambient": _conditions(101325.0, ambient),
        "start": _conditions(number("initial.pressure"), T),
    }


def _read_tables(path: Path) -> dict[str, Any]:
    """Return the tables of a HydDown input file; raise InputError if it is none, or YAML's package is missing."""
    extras.require("hyddown", "yaml", where=str(path))
    import yaml  # noqa: PLC0415

    right = "give HydDown's input file"
    try:
        tables = yaml.safe_load(read_text(path, str(path), right))
    except (RecursionError, yaml.YAMLError) as error:
        raise InputError(f"can't be read ({str(error).splitlines()[0]})", where=str(path), right=right) from None
    if not isinstance(tables, dict):
        raise InputError("holds no table", where=str(path), right=right)
    for part in REQUIRED_TABLES:
        if not isinstance(tables.get(part), dict):
            raise InputError(f"has no {part}", where=str(path), right="vessel, initial and valve are needed")
    return tables


def _number(tables: dict[str, Any], where: str, path: str, default: float | None = None) -> float:
    """Return the number at a path such as "vessel.length", or the default; raise InputError for neither, or a text."""
    table, _, key = path.partition(".")
    entry = (tables.get(table) or {}).get(key)
    value: Any = default if entry is None else entry
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(
            f"{value!r} is not a number", where=f"{where}: {path}", right="give a number in SI units"
        ) from None


def _vessel_sizes(vessel: dict[str, Any], number: Number, where: str) -> tuple[dict[str, str], dict[str, str], float]:
    """Return the table `space`, one with `heat_capacity` (empty without its data), and the outer area (m2).

    Raises:
        InputError: the type of the heads is unknown, or a size is missing.
    """
    D, L, t = number("vessel.diameter"), number("vessel.length"), number("vessel.thickness", 0.0)
    kind = str(vessel.get("type", "flat-end")).lower()
    if kind not in HEAD_SHAPES:
        raise InputError(f"{kind!r} is not known", where=f"{where}: vessel.type", right=f"use {', '.join(HEAD_SHAPES)}")
    by_cube, by_square = HEAD_SHAPES[kind]
    ends = t if kind == "flat-end" else 0.0

    def volume(d: float, length: float) -> float:
        return pi / 4 * d**2 * length + 2.0 * by_cube * d**3

    def area(d: float, length: float) -> float:
        return pi * d * length + 2.0 * by_square * d**2

    V, outer = volume(D, L), (D + 2.0 * t, L + 2.0 * ends)
    capacity = {}
    if t > 0.0 and {"density", "heat_capacity"} <= set(vessel):
        heat = (volume(*outer) - V) * number("vessel.density") * number("vessel.heat_capacity")
        capacity = {"heat_capacity": f"{heat!r} J/K"}
    space = {"volume": f"{V!r} m^3", "area": f"{area(D, L)!r} m^2", "diameter": f"{D!r} m"}
    return space, capacity, area(*outer)


def _read_valve(valve: dict[str, Any], number: Number, where: str) -> dict[str, Any]:
    """Return the table `path` of a HydDown valve: conductance, critical_ratio and, of a nozzle, hole.

    Raises:
        InputError: its kind has no conductance.
    """
    kind = valve.get("type", "orifice")
    if kind in {"orifice", "psv"}:
        d = number("valve.diameter")
        C = float(sonic_conductance(pi / 4 * d**2, number("valve.discharge_coef", 0.8)))
        return {"conductance": f"{C!r} m^3/s/Pa", "critical_ratio": NOZZLE_CRITICAL_RATIO, "hole": f"{d!r} m"}
    if kind == "controlvalve":
        C = CONDUCTANCE_PER_CV * number("valve.Cv")
        return {"conductance": f"{C!r} m^3/s/Pa", "critical_ratio": VALVE_CRITICAL_RATIO}
    right = "use orifice, psv or controlvalve"
    raise InputError(f"{kind!r} has no conductance", where=f"{where}: valve.type", right=right)


def _conditions(pressure: float, temperature: float) -> dict[str, str]:
    return {"pressure": f"{pressure!r} Pa", "temperature": f"{temperature!r} K"}
