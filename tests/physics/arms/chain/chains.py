"""Chains for tests: a planar arm said as one, and random ones of any number of joints."""

from collections.abc import Mapping
from copy import deepcopy
from typing import Any

import numpy as np

from layflat.machine import Machine, load
from layflat.machine.loader import tables
from layflat.machine.model import build

THIN = 1e-7  # inertia about the length of a link, kg m2: no law of a plane knows it


def metres(*lengths: float) -> list[str]:
    return [f"{length!r} m" for length in lengths]


def inertia(*moments: float) -> list[str]:
    return [f"{moment!r} kg m^2" for moment in moments]


def described(name: str, **changes: Any) -> tuple[dict[str, Any], Any]:
    """What a built-in machine's file says, as it can be changed."""
    plain, sources = tables(name)
    return deepcopy(dict(plain)) | changes, sources


def as_chain(name: str = "paper-arm-fast", shapes: Mapping[str, Any] | None = None, where: str = "chained") -> Machine:
    """A planar arm of two joints, described in space; with shapes of its links, by joint."""
    planar, links, at, turn = load(name), {}, 0.0, 0.0
    for joint, part in planar.joints.items():
        link = part.planar_link
        links[joint] = {
            "axis": [0.0, 0.0, 1.0],
            "position": metres(at, 0.0, 0.0),
            "rotation": ["0 rad", "0 rad", f"{turn!r} rad"],
            "mass": f"{link.mass!r} kg",
            "centre": metres(link.centre, 0.0, 0.0),
            "inertia": inertia(THIN, link.inertia, link.inertia),
            "rotor_inertia": f"{link.rotor_inertia!r} kg m^2",
            "shapes": (shapes or {}).get(joint, ()),
        }
        at, turn = link.length, planar.arm.elbow
    arm = {
        "kind": "chain",
        "joints": list(planar.joints),
        "link": links,
        "tool": metres(at, 0.0, 0.0),
        "gravity": ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"],
        "payload": f"{planar.arm.payload!r} kg",
    }
    return build(*described(name, arm=arm), where)


def random_arm(n: int, seed: int, gravity: float = 9.81, reach: float = 0.1, single: tuple[str, ...] = ()) -> Machine:
    """An arm of n small joints with axes any way, with masses of a few hundred grams; some may have a single hose."""
    draw = np.random.default_rng(seed)
    names, links = [f"j{i}" for i in range(n)], {}
    for name in names:
        a, b = draw.uniform(1e-3, 2e-3, 2).tolist()
        links[name] = {
            "axis": draw.normal(size=3).tolist(),
            "position": metres(*(reach * draw.normal(size=3)).tolist()),
            "rotation": [f"{angle!r} rad" for angle in draw.uniform(-3.0, 3.0, 3).tolist()],
            "mass": f"{draw.uniform(0.1, 0.3)!r} kg",
            "centre": metres(*(0.3 * reach * draw.normal(size=3)).tolist()),
            "inertia": inertia(a, b, max(a, b), 2e-4, 1e-4, -1e-4),
            "rotor_inertia": "0.002 kg m^2",
        }
    down = draw.normal(size=3)
    arm = {
        "kind": "chain",
        "joints": names,
        "link": links,
        "tool": metres(*(reach * draw.normal(size=3)).tolist()),
        "gravity": [f"{g!r} m/s^2" for g in (gravity * down / np.linalg.norm(down)).tolist()],
        "payload": "0.2 kg",
        "bodies": "in links",
    }
    plain, sources = described("paper-small-joint-fast")
    joints = {name: deepcopy(plain["joint"]["small"]) for name in names}
    for name in single:
        joints[name] |= {"acting": "single", "spring": {"torque": "-10 N m", "stiffness": "2 N m/rad"}}
    return build(plain | {"name": f"chain-{n}", "arm": arm, "joint": joints}, sources, f"chain-{n}")
