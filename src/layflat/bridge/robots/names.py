"""Names that descriptions can have, in place of those of a robot's file."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

from layflat.bridge.robots.robot import Robot
from layflat.bridge.robots.serial import Serial
from layflat.description.names import problem, unused_name
from layflat.errors import InputError

Value = TypeVar("Value")


def with_key_names(chain: Serial) -> tuple[Serial, dict[str, str]]:
    """Return a chain whose joints have names that can be keys of a description, and these by the robot's names."""
    stages, renamed, taken = [], dict[str, str](), set[str]()
    for stage in chain.stages:
        name = stage.joint.name
        if problem(name, key=True):
            name = "".join(one if one.isalnum() else "-" for one in name).strip("-") or "joint"
        name = unused_name(name, taken.__contains__)
        taken.add(name)
        if name != stage.joint.name:
            renamed[stage.joint.name] = name
        stages.append(replace(stage, joint=replace(stage.joint, name=name)))
    changes = ", ".join(f"{old!r} is {new!r}" for old, new in renamed.items())
    notes = (*chain.notes, f"joints are called otherwise here: {changes}") if renamed else chain.notes
    return replace(chain, stages=tuple(stages), notes=notes), renamed


def translated(values: Mapping[str, Value], renamed: Mapping[str, str]) -> dict[str, Value]:
    """Return values by the names of joints here, of values that may be by their names in the robot.

    Raises:
        InputError: there are values by both names of a joint.
    """
    for old, new in renamed.items():
        if old in values and new in values:
            raise InputError(f"{old!r} and {new!r} are one joint", where="--stroke", right="give one of both")
    return {renamed.get(name, name): value for name, value in values.items()}


def machine_name(robot: Robot) -> tuple[str, tuple[str, ...]]:
    """Return the robot's name, or its file's, as a machine may be called, and a note if it is another."""
    for name in (robot.name, robot.file.stem):
        tidy = "".join(one if one.isalnum() or one in "-_+" else "-" for one in name).strip("-_+")
        if tidy and not problem(tidy):
            kept = tidy == (robot.name or robot.file.stem)
            return tidy, () if kept else (f"the machine is called {tidy!r}, the robot {robot.name or name!r}",)
    return "arm", (f"the machine is called 'arm', the robot {robot.name!r}",)
