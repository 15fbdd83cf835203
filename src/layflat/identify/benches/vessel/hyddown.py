"""Vessels in the YAML input files of HydDown, which calculates how they empty and fill (andreasen2021).

Its fields are those of its manual.
"""

from math import pi
from pathlib import Path
from typing import Any

from layflat import extras
from layflat.description.text import read_text
from layflat.errors import InputError
from layflat.physics.flow import sonic_conductance

FLUIDS = {
    "air": "air", "n2": "nitrogen", "o2": "oxygen", "h2": "hydrogen", "he": "helium", "ar": "argon", "ch4": "methane",
    "co2": "carbon dioxide", "carbondioxide": "carbon dioxide",
}  # fmt: skip
"""Names of gases there."""

HEADS = {
    "flat-end": (0.0, pi / 4),
    "asme f&d": (0.0809, 0.929),
    "din": (0.1, 0.99),
    "semi-elliptical": (pi / 24, 1.084),
    "hemispherical": (pi / 12, pi / 2),
}
"""Volume and area of an end of the vessel, over the third and second power of the diameter."""

CONDUCTANCE_PER_CV = 3.9e-8  # C of a control valve with Cv = 1, m3/(s Pa): IEC 60534-2-1, choked air with x_T = 0.7

NOZZLE, VALVE = 0.45, 0.3
"""Critical pressure ratio that a search begins with: of a hole, nozzle or sharp edge, and of a control valve."""


def hyddown_tables(path: str | Path) -> dict[str, Any]:
    """The plain tables of a vessel's description from HydDown's input file.

    Raises:
        InputError: in one line, which field is missing or can't be used; PyYAML is not installed.
    """
    where = str(path)
    tables = _tables(Path(path))
    vessel, start, valve = (_part(tables, key, where) for key in ("vessel", "initial", "valve"))
    heat = tables.get("heat_transfer") or {}
    fluid = str(start.get("fluid", "")).lower().replace(" ", "")
    name = FLUIDS.get(fluid, fluid)
    if name not in FLUIDS.values():
        known = ", ".join(sorted(set(FLUIDS.values())))
        what = f"{start.get('fluid')!r} is an unknown gas"
        raise InputError(what, where=f"{where}: initial.fluid", right=f"use {known}")
    T = _number(start, "temperature", f"{where}: initial")
    around = float(heat.get("temp_ambient", T))
    space, capacity, outer = _sizes(vessel, where)
    wall = {"outer_conductance": f"{float(heat.get('h_outer', 0.0)) * outer!r} W/K"} | capacity
    return {
        "kind": "vessel",
        "name": Path(path).name.removesuffix(".rig.yml"),
        "title": f"{name}, {valve.get('flow', 'discharge')}",
        "gas": {"name": name, "law": "real"},
        "space": space,
        "wall": wall,
        "path": _path(valve, f"{where}: valve"),
        "outside": _place(_number(valve, "back_pressure", f"{where}: valve"), around),
        "ambient": _place(101325.0, around),
        "start": _place(_number(start, "pressure", f"{where}: initial"), T),
    }


def _tables(path: Path) -> dict[str, Any]:
    extras.require("hyddown", "yaml", where=str(path))
    import yaml  # noqa: PLC0415

    right = "give HydDown's input file"
    try:
        tables = yaml.safe_load(read_text(path, str(path), right))
    except (RecursionError, yaml.YAMLError) as error:
        raise InputError(f"can't be read ({str(error).splitlines()[0]})", where=str(path), right=right) from None
    if not isinstance(tables, dict):
        raise InputError("is not a table", where=str(path), right=right)
    return tables


def _part(tables: dict[str, Any], key: str, where: str) -> dict[str, Any]:
    part = tables.get(key)
    if not isinstance(part, dict):
        raise InputError(f"has no {key}", where=where, right="vessel, initial and valve are needed")
    return part


def _number(table: dict[str, Any], key: str, where: str) -> float:
    try:
        return float(table[key])
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{table.get(key)!r} is not a number", where=f"{where}.{key}", right="give it in SI") from None


def _sizes(vessel: dict[str, Any], where: str) -> tuple[dict[str, str], dict[str, str], float]:
    """Space, the wall's heat capacity where its thickness is given, and outer area (m2)."""
    D, L = (_number(vessel, key, f"{where}: vessel") for key in ("diameter", "length"))
    t = float(vessel.get("thickness") or 0.0)
    kind = str(vessel.get("type", "flat-end")).lower()
    if kind not in HEADS:
        raise InputError(f"{kind!r} is not known", where=f"{where}: vessel.type", right=f"use {', '.join(HEADS)}")
    by_cube, by_square = HEADS[kind]
    ends = t if kind == "flat-end" else 0.0

    def volume(d: float, length: float) -> float:
        return pi / 4 * d**2 * length + 2.0 * by_cube * d**3

    def area(d: float, length: float) -> float:
        return pi * d * length + 2.0 * by_square * d**2

    V, outer = volume(D, L), (D + 2.0 * t, L + 2.0 * ends)
    capacity = {}
    if t > 0.0 and {"density", "heat_capacity"} <= set(vessel):
        density, c = (_number(vessel, key, f"{where}: vessel") for key in ("density", "heat_capacity"))
        capacity = {"heat_capacity": f"{(volume(*outer) - V) * density * c!r} J/K"}
    space = {"volume": f"{V!r} m^3", "area": f"{area(D, L)!r} m^2", "diameter": f"{D!r} m"}
    return space, capacity, area(*outer)


def _path(valve: dict[str, Any], where: str) -> dict[str, Any]:
    kind = valve.get("type", "orifice")
    if kind in {"orifice", "psv"}:
        d = _number(valve, "diameter", where)
        C = float(sonic_conductance(pi / 4 * d**2, float(valve.get("discharge_coef", 0.8))))
        return {"conductance": f"{C!r} m^3/s/Pa", "critical_ratio": NOZZLE, "hole": f"{d!r} m"}
    if kind == "controlvalve":
        C = CONDUCTANCE_PER_CV * _number(valve, "Cv", where)
        return {"conductance": f"{C!r} m^3/s/Pa", "critical_ratio": VALVE}
    raise InputError(f"{kind!r} has no conductance", where=f"{where}.type", right="use orifice, psv or controlvalve")


def _place(pressure: float, temperature: float) -> dict[str, str]:
    return {"pressure": f"{pressure!r} Pa", "temperature": f"{temperature!r} K"}
