"""Calibrated values in the files of the built-in machines, and the loss shares that follow from two rigs."""

import json
import re
from collections.abc import Mapping
from importlib.resources import as_file
from typing import Any

from scipy.optimize import brentq

from layflat.files import write_text
from layflat.machine import changed, load
from layflat.machine.loader import BUILT_IN
from layflat.sim.sweep import sweep
from research.calibration.unknowns import JOINT_NAMES


def loss_shares() -> dict[str, float]:
    """Return the loss shares of strap and shell that give two rigs the hysteresis that the paper quotes at 3 bar."""

    def share(rig: str, path: str, hysteresis: float, most: float) -> float:
        def off(tried: float) -> float:
            return sweep(changed(load(rig), path, tried), "small", 3e5).hysteresis - hysteresis

        return float(f"{brentq(off, 0.0, most, xtol=1e-4):.3g}")

    return {
        "strap": share("rig-polyester", "joint.small.strap.loss_fraction", 0.21, 0.5),
        "shell": share("rig-shell-steel", "joint.small.cover.loss_factor", 0.08, 1.0),
    }


def write_loss_shares(shares: Mapping[str, float]) -> None:
    """Write the loss shares into the descriptions of all machines that have such a strap or shell."""
    write_values("earlier-actuator", {"joint.small.strap.loss_fraction": shares["strap"]})
    write_values("rig-shell-steel", {"joint.small.cover.loss_factor": shares["shell"]})
    write_values("paper-arm", {f"joint.{joint}.cover.loss_factor": shares["shell"] for joint in JOINT_NAMES})


def write_values(name: str, values: Mapping[str, Any]) -> None:
    """Replace values by dotted path in the file of a built-in description, and leave all else unchanged."""
    with as_file(BUILT_IN / f"{name}.toml") as path:
        text = path.read_text(encoding="utf-8")
        for key, value in values.items():
            text = replace_value(text, key, value)
        write_text(path, text)


def replace_value(text: str, path: str, value: object) -> str:
    """Return a description with one value replaced, an item of a list by its index (KeyError: it is not calibrated)."""
    keys = path.split(".")
    index = int(keys.pop()) if keys[-1].isdigit() else None
    key = keys.pop()
    start = text.find(f"[{'.'.join(keys)}]\n")
    if start < 0:
        raise KeyError(path)
    end = text.find("\n[", start + 1)
    section = text[start : end if end >= 0 else len(text)]
    line = re.search(rf'^{re.escape(key)} = \{{ value = (.+?), source = "calibrated"', section, flags=re.MULTILINE)
    if line is None:
        raise KeyError(path)
    if index is not None:
        items = json.loads(line.group(1))
        items[index] = value
        value = items
    return text[: start + line.start(1)] + json.dumps(value) + text[start + line.end(1) :]
