"""The description of a sized arm: each value with its provenance, laid over the machine that its joints come from."""

from collections.abc import Iterator, Sequence
from functools import cache
from math import acos, atan2, ceil, cos, degrees, hypot, sin
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.description.library import Layer
from layflat.description.provenance import Provenance, Sources, split
from layflat.description.tables import Plain, parsed
from layflat.design.arm.links import WALL, Tube
from layflat.design.arm.task import FALL, ArmTask, JointTask
from layflat.design.arm.valves import Valve
from layflat.design.sized import ASKED, OVERSHOOT_ROOM
from layflat.design.sizing import MODEL, Sized
from layflat.machine import Machine
from layflat.machine.listing import to_toml
from layflat.machine.loader import MACHINES
from layflat.machine.model import build

OMITS = ("arm", "joint", "controller")
SENSOR_ROOM = 10.0  # of the angle sensor's range beyond the mechanical stroke, deg
CYCLE = "5 ms"
BITS = 16  # of the angle sensor
NO_LENGTH = 1e-6  # m
SPREAD = 0.3  # of the payload, over the greatest: standard deviation of what may be there
Rows = Iterator[tuple[str, Any, str]]  # dotted path, value as it is written, and note


class Said(NamedTuple):
    """Statements of a description about a part of a machine."""

    plain: Plain
    sources: Sources  # by dotted paths in it


class Part(NamedTuple):
    """A joint with its link, as sized."""

    task: JointTask
    joint: Sized
    tube: Tube
    said: Said  # of the joint
    valve: Valve | None = None  # the model's until moves are known

    @property
    def torque(self) -> float:
        """That it gives at supply pressure, N m."""
        return self.joint.design.mean_torque

    @property
    def mass(self) -> float:
        """Mass of the joint, kg."""
        return self.joint.design.mass.body


def machine_of(task: ArmTask, parts: Sequence[Part]) -> Machine:
    """Return the machine with a sized arm."""
    plain, sources = _said(task, parts)
    laid = MACHINES.laid(_model(), Layer(task.name, plain, sources, OMITS))
    return build(*laid, task.name)


def text_of(task: ArmTask, parts: Sequence[Part]) -> str:
    """Return the TOML text of a machine with a sized arm, each value with its provenance."""
    plain, sources = _said(task, parts)
    return to_toml({"extends": MODEL, "omits": list(OMITS)} | plain, sources)


@cache
def _model() -> tuple[Plain, Sources]:
    return MACHINES.tables(MODEL)


def _said(task: ArmTask, parts: Sequence[Part]) -> Said:
    plain: Plain = {"name": task.name, "title": task.title or _title(task)}
    sources: Sources = {}
    for part in parts:
        plain.setdefault("joint", {})[part.task.name] = dict(part.said.plain)
        sources |= {f"joint.{part.task.name}.{path}": source for path, source in part.said.sources.items()}
    for path, value, note in _rows(task, parts):
        _put(plain, path.split("."), value)
        sources[path] = Provenance("given" if note == ASKED else "derived", note)
    return Said(plain, sources)


def _title(task: ArmTask) -> str:
    return f"An arm of {len(task.chain)} joints, sized for {task.payload:.3g} kg at {task.supply / 1e5:.3g} bar"


def _put(table: dict[str, Any], keys: list[str], value: Any) -> None:
    for key in keys[:-1]:
        table = table.setdefault(key, {})
    table[keys[-1]] = value


def said_of(sized: Sized) -> Said:
    """Return what the description of a sized joint says of it, as far as it holds in any arm."""
    own = parsed(sized.toml, sized.request.name, "")
    own.pop("extends")
    plain, sources = MACHINES.laid(_model(), Layer(sized.request.name, *split(own, sized.request.name)))
    (name,) = plain["arm"]["joints"]
    left = {key: value for key, value in plain["joint"][name].items() if key not in ("link", "gains")}
    start = f"joint.{name}."
    kept = {path.removeprefix(start): of for path, of in sources.items() if path.startswith(start)}
    return Said(left, {path: of for path, of in kept.items() if path.partition(".")[0] in left})


def _rows(task: ArmTask, parts: Sequence[Part]) -> Rows:
    mechanical = max(degrees(part.task.stroke) for part in parts) + OVERSHOOT_ROOM
    yield "supply.pressure_gauge", f"{task.supply / 1e5:.6g} bar", ASKED
    yield "angle_sensor.range", f"{mechanical + SENSOR_ROOM:.6g} deg", "mechanical stroke and 10 deg"
    yield "angle_sensor.bits", BITS, "so fine that a sound sensor never repeats itself, and one that freezes is found"
    yield "pressure_sensor.range", f"{ceil(2.5e-5 * task.supply)} bar", "2.5 times supply pressure"
    yield "controller.kind", "tracking", "docs/control.md"
    yield "controller.cycle", CYCLE, "as the paper's arm"
    spread = f"{SPREAD * task.payload:.4g} kg"
    yield "controller.payload_spread", spread, "what is carried is not told, up to the greatest payload"
    yield "arm.kind", "chain", "an arm in space"
    yield "arm.joints", [part.task.name for part in parts], "from base to tip"
    yield "arm.payload", f"{0.5 * task.payload:.6g} kg", "half of the greatest"
    yield "arm.tool", _mm(parts[-1].task.link), "at the end of the last link"
    yield "arm.gravity", ["0 m/s^2", "0 m/s^2", f"{-FALL:g} m/s^2"], "z is up"
    place = (0.0, 0.0, 0.0)
    for part in parts:
        for key, value, note in _link(part, place):
            yield f"arm.link.{part.task.name}.{key}", value, note
        if part.valve is not None:
            flow = f"nominal flow of {part.valve.nominal_flow:.0f} l/min, 6 to 5 bar, which is sold"
            size = float(f"{part.valve.size:.3g}")
            yield f"joint.{part.task.name}.valve_size", size, f"{flow}: feeds the moves with margin"
        place = part.task.link


def _link(part: Part, place: tuple[float, ...]) -> Rows:
    task, tube = part.task, part.tube
    way = _way(task)
    yield "axis", [float(one) for one in task.axis], ASKED
    yield "place", _mm(place), "at the end of the link before"
    yield "turn", [f"{degrees(angle):.6g} deg" for angle in _turn(task)], ASKED
    yield "mass", f"{tube.mass:.4g} kg", f"aluminium tube of {1e3 * tube.diameter:.0f} mm, wall {1e3 * WALL:g} mm"
    yield "centre", _mm(tuple(0.5 * one for one in task.link)), "middle of the tube"
    along, across = tube.moments
    inertia = across * np.eye(3) + (along - across) * np.outer(way, way)
    yield "inertia", _inertia(inertia), "of the tube"
    link = part.joint.machine.joint[next(iter(part.joint.machine.joints))].planar_link
    yield "rotor_inertia", f"{link.rotor_inertia:.4g} kg m^2", "the paper's small joint, scaled by size"
    yield "shapes", [_tube(part, way), _body(part)], "for drawing"


def _inertia(matrix: Array) -> list[str]:
    values = [*matrix.diagonal(), matrix[0, 1], matrix[0, 2], matrix[1, 2]]
    count = 6 if np.abs(values[3:]).max() > 1e-9 else 3
    return [f"{value:.4g} kg m^2" if abs(value) > 1e-9 else "0 kg m^2" for value in values[:count]]


def _turn(task: JointTask) -> tuple[float, float, float]:
    """Angles about x, y and z, one after another, that come to the angle about its axis in mid-stroke."""
    x, y, z = (float(one) for one in np.array(task.axis) / np.linalg.norm(task.axis))
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R = np.eye(3) + sin(task.middle) * across + (1.0 - cos(task.middle)) * across @ across
    level = hypot(R[2, 1], R[2, 2])
    second = atan2(-R[2, 0], level)
    if level < 1e-9:  # x and z turn about one line then: x does it alone
        return atan2(-R[1, 2], R[1, 1]), second, 0.0
    return atan2(R[2, 1], R[2, 2]), second, atan2(R[1, 0], R[0, 0])


def _along(way: Array) -> list[str]:
    """Return the turn that brings z to a way of length 1."""
    x, y, z = (float(one) for one in way)
    return ["0 deg", f"{degrees(acos(min(max(z, -1.0), 1.0))):.6g} deg", f"{degrees(atan2(y, x)):.6g} deg"]


def _way(task: JointTask) -> Array:
    """Return the direction of a link; along the axis where it has no length."""
    for along in (np.array(task.link), np.array(task.axis)):
        if (length := float(np.linalg.norm(along))) > NO_LENGTH:
            break
    way: Array = along / length
    return way


def _tube(part: Part, way: Array) -> Plain:
    middle = _mm(tuple(0.5 * one for one in part.task.link))
    size = _mm((part.tube.diameter, part.tube.length))
    return {"kind": "cylinder", "place": middle, "turn": _along(way), "size": size}


def _body(part: Part) -> Plain:
    joint = part.joint.machine.joint[next(iter(part.joint.machine.joints))]
    axis = np.array(part.task.axis) / np.linalg.norm(part.task.axis)
    return {"kind": "cylinder", "turn": _along(axis), "size": _mm((joint.cylinder.diameter, joint.body.height))}


def _mm(values: Sequence[float]) -> list[str]:
    return [f"{1e3 * value:.6g} mm" if abs(value) > 1e-9 else "0 mm" for value in values]
