"""An arm in space for tests of rigs: a turning base, a shoulder and an elbow, pulled down by gravity."""

from copy import deepcopy
from functools import cache

from layflat.machine import Machine
from layflat.machine.loader import tables
from layflat.machine.model import build

LINKS = {
    "base": ([0.0, 0.0, 1.0], 0.0, 0.4),
    "shoulder": ([0.0, -1.0, 0.0], 0.1, 0.3),
    "elbow": ([0.0, -1.0, 0.2], 0.2, 0.2),
}
"""Axis, distance from the joint before (m) and mass (kg)."""


@cache
def lifting_arm(law: str = "tracking") -> Machine:
    """The arm, with a control law that is not told its payload."""
    plain, sources = tables("paper-small-joint-fast")
    plain, links = deepcopy(dict(plain)), {}
    for name, (axis, along, mass) in LINKS.items():
        up = name == "shoulder"
        links[name] = {
            "axis": axis,
            "position": ["0 m" if up else f"{along} m", "0 m", f"{along} m" if up else "0 m"],
            "mass": f"{mass} kg",
            "centre": ["0.08 m", "0 m", "0 m"],
            "inertia": ["0.0005 kg m^2", "0.001 kg m^2", "0.001 kg m^2"],
            "rotor_inertia": "0.001 kg m^2",
        }
    plain |= {
        "name": "lifting-arm",
        "joint": {name: deepcopy(plain["joint"]["small"]) for name in LINKS},
        "arm": {
            "kind": "chain", "joints": list(LINKS), "link": links, "payload": "0.2 kg",
            "tool": ["0.15 m", "0 m", "0 m"],
            "gravity": ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"],
        },
    }  # fmt: skip
    if law == "tracking":
        for joint in plain["joint"].values():
            del joint["gains"]
        plain["controller"] = {"kind": "tracking", "cycle": "5 ms", "payload_std": "0.1 kg"}
    return build(plain, sources, "lifting-arm")
