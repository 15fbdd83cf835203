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
