"""Vessel experiments in the files of HydDown: the rig as its YAML input, the log as points read off published curves.

HydDown (andreasen2021) calculates how vessels empty and fill; its input fields are those of its manual. A log is a CSV
file with the columns signal, time_s, value and unit; signals are gas_pressure, T_gas_..., T_wall_....
"""

from __future__ import annotations

import csv
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.description.text import check_regular, read_text
from layflat.errors import InputError
from layflat.identify.model import Array
from layflat.physics.flow import sonic_conductance

if TYPE_CHECKING:
    import xarray

FLUIDS = {
    "air": "air",
    "n2": "nitrogen",
    "o2": "oxygen",
    "h2": "hydrogen",
    "he": "helium",
    "ar": "argon",
    "ch4": "methane",
    "co2": "carbon dioxide",
    "carbondioxide": "carbon dioxide",
}
"""Names of gases there."""

HEADS = {
    "flat-end": (0.0, pi / 4),
    "asme f&d": (0.0809, 0.929),
    "din": (0.1, 0.99),
    "semi-elliptical": (pi / 24, 1.084),
    "hemispherical": (pi / 12, pi / 2),
}
"""Volume and area of an end of the vessel, over the third and second power of the diameter."""

CONDUCTANCE_PER_CV = 3.9e-8
"""C of a control valve with Cv = 1, m3/(s Pa): IEC 60534-2-1, choked air with x_T = 0.7."""

NOZZLE, VALVE = 0.45, 0.3
"""Critical pressure ratio that a search begins with: of a hole, nozzle or sharp edge, and of a control valve."""

UNITS = {
    "bar_abs": (1e5, 0.0),
    "bara": (1e5, 0.0),
    "bar": (1e5, 0.0),
    "mpa": (1e6, 0.0),
    "kpa": (1e3, 0.0),
    "pa": (1.0, 0.0),
    "psia": (6894.757, 0.0),
    "k": (1.0, 0.0),
    "degc": (1.0, 273.15),
    "c": (1.0, 273.15),
}
"""Factor and shift to SI."""


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
        raise InputError(
            f"{start.get('fluid')!r} is an unknown gas", where=f"{where}: initial.fluid", right=f"use {known}"
        )
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


def read_hyddown_log(path: str | Path) -> xarray.Dataset:
    """A log from points read off curves; curves of the same kind, as of the hottest and coldest gas, are averaged.

    Raises:
        InputError: a column is missing, or a unit is not known.
    """
    import xarray  # noqa: PLC0415  # takes long to import

    curves = _curves(Path(path))
    groups = {"pressure": "gas_pressure", "temperature": "T_gas", "wall_temperature": "T_wall"}
    series = {
        signal: _averaged([curve for name, curve in curves.items() if name.startswith(begin)])
        for signal, begin in groups.items()
        if any(name.startswith(begin) for name in curves)
    }
    time = np.unique(np.concatenate([[0.0], *(times for times, _ in series.values())]))
    log = xarray.Dataset(coords={"time": ("time", time, {"units": "s"})})
    for signal, (times, values) in series.items():
        column = np.full(len(time), np.nan)
        column[np.searchsorted(time, times)] = values
        log[signal] = (("time",), column, {"units": "Pa" if signal == "pressure" else "K"})
    log.attrs["log_name"] = Path(path).name
    return log


def _tables(path: Path) -> dict[str, Any]:
    try:
        import yaml  # noqa: PLC0415
    except ImportError:
        raise InputError("needs PyYAML", where=str(path), right="pip install 'layflat[hyddown]'") from None
    try:
        tables = yaml.safe_load(read_text(path, str(path), "give HydDown's input file"))
    except (RecursionError, yaml.YAMLError) as error:
        text = str(error).splitlines()[0]
        raise InputError(f"can't be read ({text})", where=str(path), right="give HydDown's input file") from None
    if not isinstance(tables, dict):
        raise InputError("is not a table", where=str(path), right="give HydDown's input file")
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


def _curves(path: Path) -> dict[str, tuple[Array, Array]]:
    """Times (s) and values (SI) by name."""
    points: dict[str, list[tuple[float, float]]] = {}
    check_regular(path, str(path), "give a CSV file")
    try:
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                unit = row["unit"].strip().lower()
                if unit not in UNITS:
                    known = ", ".join(UNITS)
                    raise InputError(f"unknown unit {row['unit']!r}", where=str(path), right=f"use {known}")
                factor, shift = UNITS[unit]
                point = max(float(row["time_s"]), 0.0), float(row["value"]) * factor + shift
                points.setdefault(row["signal"].strip(), []).append(point)
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=str(path), right="give a CSV file") from None
    except (KeyError, TypeError, ValueError, AttributeError):
        right = "give a table of numbers; its columns are signal, time_s, value, unit"
        raise InputError("can't be used", where=str(path), right=right) from None
    if "gas_pressure" not in points:
        raise InputError("has no gas_pressure", where=str(path), right="signals are gas_pressure, T_gas, T_wall")
    ordered = {name: np.array(sorted(of)) for name, of in points.items()}
    return {name: (of[:, 0], of[:, 1]) for name, of in ordered.items()}


def _averaged(curves: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Mean of curves at the times of the first that all of them cover."""
    times = np.unique(curves[0][0])
    since, until = max(t[0] for t, _ in curves), min(t[-1] for t, _ in curves)
    times = times[(times >= since) & (times <= until)]
    return times, np.mean([np.interp(times, *curve) for curve in curves], axis=0)
