"""Reference of the interface in Python, from docstrings."""

from importlib import import_module
from types import ModuleType

import layflat

ROOMS = {
    "Machines": "layflat.machine",
    "Simulation": "layflat.sim",
    "Metrics of runs": "layflat.sim.run_metrics",
    "Many runs side by side": "layflat.sim.ensemble",
    "Design": "layflat.design",
    "Design of arms": "layflat.design.arm",
    "Motions": "layflat.motion",
    "Tuning": "layflat.tune",
    "Identification": "layflat.identify",
    "Logs": "layflat.identify.logs",
    "Studies": "layflat.study",
    "Bridges to other tools": "layflat.bridge",
    "Robots of other tools": "layflat.bridge.robots",
    "Packing cells": "layflat.cell",
    "Experiments of the paper": "layflat.experiments",
    "Figures": "layflat.plot",
    "Errors": "layflat.errors",
}


def interface_reference() -> str:
    """Return the page of public names: those at the top of the package, then those of its rooms."""
    parts = ["# Interface", "", "## layflat", "", (layflat.__doc__ or "").strip(), ""]
    parts += [f"- {{py:obj}}`layflat.{name} <{_home(name)}>`" for name in layflat.__all__]
    for title, room in ROOMS.items():
        module = import_module(room)
        parts += ["", f"## {title}", "", f"`{room}`: {(module.__doc__ or '').strip().splitlines()[0]}", ""]
        names = sorted(getattr(module, "__all__", ()))
        parts += [_entry(room, name) for name in names]
    return "\n".join(parts) + "\n"


def _home(name: str) -> str:
    """Return the full name under which a name of the top stands among those of its room; a room's own name is full."""
    found = getattr(layflat, name)
    if isinstance(found, ModuleType):
        return found.__name__
    rooms = (room for room in ROOMS.values() if name in getattr(import_module(room), "__all__", ()))
    return f"{next(rooms, found.__module__)}.{name}"


def _entry(room: str, name: str) -> str:
    found = getattr(import_module(room), name)
    kind = "autoclass" if isinstance(found, type) else "autofunction" if callable(found) else "autodata"
    members = "\n   :members:\n   :exclude-members: model_config" if kind == "autoclass" else ""
    return f"```{{eval-rst}}\n.. {kind}:: {room}.{name}{members}\n```\n"
