"""Page that simulates machines without a server: one file with its scripts, styles and modules."""

import json
import re
from base64 import b64encode
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from layflat.errors import InputError
from layflat.export.web.module import WebMachine, shared_modules
from layflat.files import write_text
from layflat.machine import Machine, load
from layflat.physics.arms.planar import PlanarArmPart

PAGE_SCRIPTS = (
    "package/structs.js", "package/runtime.js", "simulator/options.js", "simulator/geometry.js",
    "simulator/simulation.js", "simulator/drawing.js", "simulator/plot.js", "simulator/controls.js",
    "simulator/page.js",
)  # fmt: skip
"""Scripts of the page, each after those that it imports."""

IMPORT_LINE = re.compile(r"^import .*\n", re.MULTILINE)
EXPORT_WORD = re.compile(r"^export (?=async|class|const|function)", re.MULTILINE)


def has_page(machine: Machine) -> bool:
    """Return whether the page can draw a machine: one or two joints in a plane."""
    return isinstance(machine.arm, PlanarArmPart)


def write_simulator(path: Path, machines: Sequence[str | Path | Machine], title: str = "layflat simulator") -> Path:
    """Write the page that simulates machines, and return its path.

    Args:
        path: path of the page.
        machines: descriptions, their files, or names of built-in machines, the one that is shown first in front.
        title: title of the page.

    Raises:
        InputError: a machine's arm does not move in a plane.
        KindError: a control law is plain Python.
    """
    webs = [WebMachine(load(machine)) for machine in machines]
    for web in webs:
        if not has_page(web.machine):
            raise InputError(
                "has an arm that does not move in a plane", where=web.machine.name, right="give others for the page"
            )
    modules = shared_modules(webs, "wasm")
    return write_text(path, simulator_page(webs, [modules[web.structure] for web in webs], title))


def simulator_page(machines: Sequence[WebMachine], modules: Sequence[bytes], title: str) -> str:
    """Return the page that simulates machines.

    Args:
        machines: the machines, the one that is shown first in front.
        modules: WebAssembly module of each.
        title: title of the page.
    """
    unique = list(dict.fromkeys(modules))
    entries = [_entry(web, unique.index(module)) for web, module in zip(machines, modules, strict=True)]
    code = "\n".join(EXPORT_WORD.sub("", IMPORT_LINE.sub("", _text(script))) for script in PAGE_SCRIPTS)
    parts = {
        "@TITLE@": escape(title),
        "@STYLE@": _text("simulator/page.css"),
        "@MACHINES@": json.dumps(entries).replace("<", "\\u003c"),
        "@MODULES@": json.dumps([b64encode(module).decode() for module in unique]),
        "@CODE@": code,
    }
    return re.sub("|".join(parts), lambda match: parts[match[0]], _text("simulator/page.html"))


def _text(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _entry(web: WebMachine, module: int) -> dict[str, Any]:
    """Return a machine for the page: its description, the number of its module, and what is drawn and changed."""
    machine = web.machine
    gravity = machine.arm.gravity, machine.arm.gravity_direction
    strokes = [joint.stops.working_stroke / 2 for joint in machine.joints.values()]
    return {"description": web.description(), "module": module, "gravity": gravity, "strokes": strokes}
