"""Vessels in the YAML input files of HydDown, which calculates how they empty and fill (andreasen2021).

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

NOZZLE, VALVE = 0.45, 0.3  # critical pressure ratio to begin with: of a hole, nozzle or sharp edge; of a control valve
PARTS = ("vessel", "initial", "valve")

Number = Callable[..., float]  # gives the number at a place of the file


def hyddown_tables(path: str | Path) -> dict[str, Any]:
    """Plain tables of a vessel's description from HydDown's input file; raise InputError if a field can't be used."""
    where, tables = str(path), _tables(Path(path))
    vessel, start, valve = (tables[key] for key in PARTS)
    number = partial(_number, tables, where)
    fluid = str(start.get("fluid", "")).lower().replace(" ", "")
    name = FLUIDS.get(fluid, fluid)
    if name not in FLUIDS.values():
        right = f"use {', '.join(sorted(set(FLUIDS.values())))}"
        raise InputError(f"{start.get('fluid')!r} is an unknown gas", where=f"{where}: initial.fluid", right=right)
    T = number("initial.temperature")
    around = number("heat_transfer.temp_ambient", T)
    space, capacity, outer = _sizes(vessel, number, where)
    wall = {"outer_conductance": f"{number('heat_transfer.h_outer', 0.0) * outer!r} W/K"} | capacity
    return {
        "kind": "vessel",
        "name": Path(path).name.removesuffix(".rig.yml"),
        "title": f"{name}, {valve.get('flow', 'discharge')}",
        "gas": {"name": name, "law": "real"},
        "space": space,
        "wall": wall,
        "path": _path(valve, number, where),
        "outside": _place(number("valve.back_pressure"), around),
        "ambient": _place(101325.0, around),
        "start": _place(number("initial.pressure"), T),
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
    for part in PARTS:
        if not isinstance(tables.get(part), dict):
            raise InputError(f"has no {part}", where=str(path), right="vessel, initial and valve are needed")
    return tables


def _number(tables: dict[str, Any], where: str, place: str, usual: float | None = None) -> float:
    """A number at a place such as "vessel.length", or what is usual where there is none."""
    part, _, key = place.partition(".")
    found = (tables.get(part) or {}).get(key)
    value: Any = usual if found is None else found
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(f"{value!r} is not a number", where=f"{where}: {place}", right="give it in SI") from None


def _sizes(vessel: dict[str, Any], number: Number, where: str) -> tuple[dict[str, str], dict[str, str], float]:
    """Space, the wall's heat capacity where its thickness is given, and outer area (m2)."""
    D, L, t = number("vessel.diameter"), number("vessel.length"), number("vessel.thickness", 0.0)
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
        heat = (volume(*outer) - V) * number("vessel.density") * number("vessel.heat_capacity")
        capacity = {"heat_capacity": f"{heat!r} J/K"}
    space = {"volume": f"{V!r} m^3", "area": f"{area(D, L)!r} m^2", "diameter": f"{D!r} m"}
    return space, capacity, area(*outer)


def _path(valve: dict[str, Any], number: Number, where: str) -> dict[str, Any]:
    kind = valve.get("type", "orifice")
    if kind in {"orifice", "psv"}:
        d = number("valve.diameter")
        C = float(sonic_conductance(pi / 4 * d**2, number("valve.discharge_coef", 0.8)))
        return {"conductance": f"{C!r} m^3/s/Pa", "critical_ratio": NOZZLE, "hole": f"{d!r} m"}
    if kind == "controlvalve":
        C = CONDUCTANCE_PER_CV * number("valve.Cv")
        return {"conductance": f"{C!r} m^3/s/Pa", "critical_ratio": VALVE}
    right = "use orifice, psv or controlvalve"
    raise InputError(f"{kind!r} has no conductance", where=f"{where}: valve.type", right=right)


def _place(pressure: float, temperature: float) -> dict[str, str]:
    return {"pressure": f"{pressure!r} Pa", "temperature": f"{temperature!r} K"}
