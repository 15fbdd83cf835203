"""Variables of an FMU: names of the data sets, units, meanings, start values, and their places among its numbers."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from layflat.export.fmu.units import commented_unit
from layflat.export.layout import field_comments
from layflat.motion.scenario import SIGNALS

ACCESS_CODES = {"none": 0, "tunable": 1, "fixed": 2, "input": 3, "output": 4}
"""Use of a number in model.h: "none" is no variable, "tunable" and "fixed" are parameters."""


@dataclass(frozen=True)
class Variable:
    """Variable of a real number."""

    name: str
    use: str  # a key of `ACCESS_CODES`, but "none"
    start: float
    unit: str = ""
    meaning: str = ""
    held: bool = False  # an output that keeps its start value until the first step


@dataclass(frozen=True)
class Section:
    """Consecutive numbers of an instance: one item a number, of those that are no variable their start value."""

    name: str  # of its first number in model.h
    items: tuple[Variable | float, ...]

    @property
    def start_values(self) -> list[float]:
        """Values of all its numbers at the start."""
        return [item.start if isinstance(item, Variable) else item for item in self.items]


def quoted(name: str) -> str:
    """Return a name as a part of a structured name: in quotes where it is no identifier."""
    return name if re.fullmatch(r"[A-Za-z_]\w*", name) else "'" + re.sub(r"[\\']", r"\\\g<0>", name) + "'"


def parameter_variables(value: Any, prefix: str, joints: Iterable[str]) -> Iterator[Variable]:
    """Yield the numbers of a nested tuple as tunable parameters, named by the fields that lead to them.

    Args:
        value: the tuple.
        prefix: first part of all names.
        joints: names of the joints, in place of the numbers of items where there is one a joint.
    """
    names, comments = [quoted(joint) for joint in joints], field_comments(type(value))
    for label, item in zip(value._fields, value, strict=True):
        yield from _items(item, f"{prefix}.{label}", comments.get(label, ""), names)


def _items(item: Any, path: str, comment: str, joints: list[str]) -> Iterator[Variable]:
    if not isinstance(item, tuple):
        yield Variable(path, "tunable", float(item), commented_unit(comment), comment)
    elif hasattr(item, "_fields"):
        comments = field_comments(type(item))
        for label, inner in zip(item._fields, item, strict=True):
            yield from _items(inner, f"{path}.{label}", comments.get(label, ""), joints)
    else:
        by_joint = path.endswith(".joints") and len(item) == len(joints)
        for i, inner in enumerate(item):
            place = f"{path.removesuffix('joints')}{joints[i]}" if by_joint else f"{path}[{i + 1}]"
            yield from _items(inner, place, comment, joints)


def scenario_input(name: str, start: float, joint: str = "") -> Variable:
    """Return an input that is a signal of a scenario.

    Args:
        name: name of the signal.
        start: value at the start.
        joint: the joint, as a part of names; empty: all joints share it.
    """
    unit, meaning = SIGNALS[name].recorded
    return Variable(f"{joint}.{name}" if joint else name, "input", start, unit, meaning)


def joint_outputs(
    joints: Iterable[str],
    values: Iterable[Any],
    signals: Mapping[str, tuple[str, str]],
    hidden: Iterable[str] = (),
    *,
    held: bool = False,
) -> Iterator[Variable | float]:
    """Yield the fields of a named tuple a joint as outputs.

    Args:
        joints: names of the joints.
        values: the tuples, with the values at the start.
        signals: unit and meaning of each field.
        hidden: fields that are no variables.
        held: see `Variable`.
    """
    for joint, value in zip(joints, values, strict=True):
        for name, start in zip(value._fields, value, strict=True):
            unit, meaning = signals[name]
            output = Variable(f"{quoted(joint)}.{name}", "output", float(start), unit, meaning, held)
            yield 0.0 if name in hidden else output
