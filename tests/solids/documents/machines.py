"""Arms of any number of joints, for documents."""

from __future__ import annotations

from layflat.machine import Machine, build, load


def with_joints(count: int, outputs: int = 0) -> Machine:
    """Return a chain of joints of the picking arm, base to tip and again, with digital outputs."""
    arm = load("picking-arm").model_dump(mode="json")
    joints = arm["arm"]["joints"]
    chosen = {f"j{j}": joints[j % len(joints)] for j in range(count)}
    arm["arm"]["joints"] = list(chosen)
    arm["arm"]["link"] = {name: arm["arm"]["link"][old] for name, old in chosen.items()}
    arm["joint"] = {name: arm["joint"][old] for name, old in chosen.items()}
    arm["interface"]["outputs"] = [f"tool{i}" for i in range(outputs)]
    return build(arm, {}, "arm.toml")


def with_extras(name: str, *, single: bool = False, calliper: bool = False, regulator: bool = False) -> Machine:
    """Return a built-in machine whose joints have a single hose, callipers or regulators, as far as set."""
    arm = load(name).model_dump(mode="json")
    for joint in arm["joint"].values():
        if single:
            joint |= {"acting": "single", "spring": {"torque": "-1 N m"}}
        if calliper:
            joint["brake"]["calliper"] = {"released_fraction": 0.1, "stroke_time": "20 ms"}
        if regulator:
            joint["regulator"] = {"min_fraction": 0.02, "stroke_time": "20 ms"}
    return build(arm, {}, "arm.toml")


def with_long_names() -> Machine:
    """Return an arm whose joint and output have long names."""
    arm, name = load("paper-arm").model_dump(mode="json"), "a joint with a very long name (as some people write them)"
    arm["joint"] = {name: arm["joint"]["large"]}
    arm["arm"]["joints"] = [name]
    arm["interface"]["outputs"] = ["A name of 24 letters abc"]
    return build(arm, {}, "arm.toml")


UNUSUAL_MACHINES = {
    "single hoses": with_extras("paper-arm", single=True, calliper=True),
    "single hoses with two valves": with_extras("paper-arm-switching", single=True, calliper=True),
    "two valves, regulated": with_extras("paper-arm-switching", calliper=True, regulator=True),
    "four, regulated": with_extras("picking-arm", calliper=True, regulator=True),
    "long names": with_long_names(),
}
"""Machines that differ much from the built-in ones."""
