"""Description of a sized arm: values with their provenance, overlaid on the machine that its joints are scaled from."""

from collections.abc import Iterator, Sequence
from functools import cache
from math import acos, atan2, ceil, cos, degrees, hypot, sin
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.description.library import Layer
from layflat.description.tables import Plain, Provenance, Sources, parse_toml, split_provenance
from layflat.design.arm.components import WALL_THICKNESS, Tube, Valve
from layflat.design.arm.task import FALL_ACCELERATION, ArmTask, JointTask
from layflat.design.sized import GIVEN_NOTE, OVERSHOOT_ROOM
from layflat.design.sizing import MODEL_MACHINE, Sized
from layflat.machine import Machine
from layflat.machine.listing import to_toml
from layflat.machine.loader import MACHINE_LIBRARY
from layflat.machine.model import build

OMITTED_PARTS = ("arm", "joint", "controller")
SENSOR_ROOM = 10.0  # of the angle sensor's range beyond the mechanical stroke, deg
CONTROL_CYCLE = "5 ms"
ANGLE_BITS = 16  # of the angle sensor
NO_LENGTH = 1e-6  # m
PAYLOAD_DEVIATION = 0.3  # standard deviation of the payload over the greatest payload
Rows = Iterator[tuple[str, Any, str]]  # dotted path, value as it is written, and note


class DescriptionTables(NamedTuple):
    """Tables of a part of a description, with the sources of their values."""

    plain: Plain
    sources: Sources  # by dotted paths in it


class SizedPart(NamedTuple):
    """Sized joint with its link."""

    task: JointTask
    joint: Sized
    tube: Tube
    tables: DescriptionTables  # of the joint
    valve: Valve | None = None  # None for the model machine's, until the moves are known

    @property
    def torque(self) -> float:
        """Mean torque of the joint at supply pressure, N m."""
        return self.joint.design.mean_torque

    @property
    def mass(self) -> float:
        """Mass of the joint, kg."""
        return self.joint.design.mass.body


def make_machine(task: ArmTask, parts: Sequence[SizedPart]) -> Machine:
    """Return the machine with a sized arm."""
    plain, sources = _task_tables(task, parts)
    layered = MACHINE_LIBRARY.apply_layer(_model(), Layer(task.name, plain, sources, OMITTED_PARTS))
    return build(*layered, task.name)


def description_text(task: ArmTask, parts: Sequence[SizedPart]) -> str:
    """Return the TOML text of a machine with a sized arm, each value with its provenance."""
    plain, sources = _task_tables(task, parts)
    return to_toml({"extends": MODEL_MACHINE, "omits": list(OMITTED_PARTS)} | plain, sources)


@cache
def _model() -> tuple[Plain, Sources]:
    """Return values and sources of the machine that sized joints extend."""
    return MACHINE_LIBRARY.tables(MODEL_MACHINE)


def _task_tables(task: ArmTask, parts: Sequence[SizedPart]) -> DescriptionTables:
    """Return the tables of a sized arm: of its joints, supply, sensors, controller and links, with their sources."""
    plain: Plain = {"name": task.name, "title": task.title or _title(task)}
    sources: Sources = {}
    for part in parts:
        plain.setdefault("joint", {})[part.task.name] = dict(part.tables.plain)
        sources |= {f"joint.{part.task.name}.{path}": source for path, source in part.tables.sources.items()}
    for path, value, note in _description_rows(task, parts):
        _set_value(plain, path.split("."), value)
        sources[path] = Provenance("given" if note == GIVEN_NOTE else "derived", note)
    return DescriptionTables(plain, sources)


def _title(task: ArmTask) -> str:
    return f"An arm of {len(task.chain)} joints, sized for {task.payload:.3g} kg at {task.supply / 1e5:.3g} bar"


def _set_value(table: dict[str, Any], keys: list[str], value: Any) -> None:
    """Set a value in nested tables, in place; missing tables are added."""
    for key in keys[:-1]:
        table = table.setdefault(key, {})
    table[keys[-1]] = value


def joint_tables(sized: Sized) -> DescriptionTables:
    """Return the tables of a sized joint that hold in any arm: without its link and gains."""
    table = parse_toml(sized.toml, sized.request.name, "")
    table.pop("extends")
    layer = Layer(sized.request.name, *split_provenance(table, sized.request.name))
    plain, sources = MACHINE_LIBRARY.apply_layer(_model(), layer)
    (name,) = plain["arm"]["joints"]
    left = {key: value for key, value in plain["joint"][name].items() if key not in ("link", "gains")}
    start = f"joint.{name}."
    of_joint = {path.removeprefix(start): source for path, source in sources.items() if path.startswith(start)}
    remaining = {path: source for path, source in of_joint.items() if path.partition(".")[0] in left}
    return DescriptionTables(left, remaining)


def _description_rows(task: ArmTask, parts: Sequence[SizedPart]) -> Rows:
    """Yield path, value as text and note of each item of the description that belongs to no single joint's tables."""
    mechanical = max(degrees(part.task.stroke) for part in parts) + OVERSHOOT_ROOM
    yield "supply.pressure_gauge", f"{task.supply / 1e5:.6g} bar", GIVEN_NOTE
    yield "angle_sensor.range", f"{mechanical + SENSOR_ROOM:.6g} deg", "mechanical stroke and 10 deg"
    note = "so fine that a sound sensor never repeats itself, and one that freezes is found"
    yield "angle_sensor.bits", ANGLE_BITS, note
    yield "pressure_sensor.range", f"{ceil(2.5e-5 * task.supply)} bar", "2.5 times supply pressure"
    yield "controller.kind", "tracking", "docs/control.md"
    yield "controller.cycle", CONTROL_CYCLE, "as the paper's arm"
    spread = f"{PAYLOAD_DEVIATION * task.payload:.4g} kg"
    yield "controller.payload_std", spread, "what is carried is not told, up to the greatest payload"
    yield "arm.kind", "chain", "an arm in space"
    yield "arm.joints", [part.task.name for part in parts], "from base to tip"
    yield "arm.payload", f"{0.5 * task.payload:.6g} kg", "half of the greatest"
    yield "arm.tool", _mm(parts[-1].task.link), "at the end of the last link"
    yield "arm.gravity", ["0 m/s^2", "0 m/s^2", f"{-FALL_ACCELERATION:g} m/s^2"], "z is up"
    place = (0.0, 0.0, 0.0)
    for part in parts:
        for key, value, note in _link_rows(part, place):
            yield f"arm.link.{part.task.name}.{key}", value, note
        if part.valve is not None:
            flow = f"nominal flow of {part.valve.nominal_flow:.0f} l/min, 6 to 5 bar, which is sold"
            size = float(f"{part.valve.size:.3g}")
            yield f"joint.{part.task.name}.valve_size", size, f"{flow}: feeds the moves with margin"
        place = part.task.link


def _link_rows(part: SizedPart, place: tuple[float, ...]) -> Rows:
    """Yield key, value and note of each item of a part's link, which begins at `place` (m) in the link before."""
    task, tube = part.task, part.tube
    direction = _link_direction(task)
    yield "axis", [float(component) for component in task.axis], GIVEN_NOTE
    yield "position", _mm(place), "at the end of the link before"
    yield "rotation", [f"{degrees(angle):.6g} deg" for angle in _turn(task)], GIVEN_NOTE
    note = f"aluminium tube of {1e3 * tube.diameter:.0f} mm, wall {1e3 * WALL_THICKNESS:g} mm"
    yield "mass", f"{tube.mass:.4g} kg", note
    yield "centre", _mm(tuple(0.5 * component for component in task.link)), "middle of the tube"
    along, across = tube.moments
    inertia = across * np.eye(3) + (along - across) * np.outer(direction, direction)
    yield "inertia", _inertia(inertia), "of the tube"
    link = part.joint.machine.joint[next(iter(part.joint.machine.joints))].planar_link
    yield "rotor_inertia", f"{link.rotor_inertia:.4g} kg m^2", "the paper's small joint, scaled by size"
    yield "shapes", [_tube(part, direction), _body_shape(part)], "for drawing"


def _inertia(matrix: Array) -> list[str]:
    """Return the texts of an inertia: xx, yy, zz, then xy, xz, yz unless these are all zero."""
    values = [*matrix.diagonal(), matrix[0, 1], matrix[0, 2], matrix[1, 2]]
    count = 6 if np.abs(values[3:]).max() > 1e-9 else 3
    return [f"{value:.4g} kg m^2" if abs(value) > 1e-9 else "0 kg m^2" for value in values[:count]]


def _turn(task: JointTask) -> tuple[float, float, float]:
    """Return angles about x, y and z, in sequence, equal to the rotation about the joint's axis in mid-stroke, rad."""
    x, y, z = (float(component) for component in np.array(task.axis) / np.linalg.norm(task.axis))
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R = np.eye(3) + sin(task.middle) * across + (1.0 - cos(task.middle)) * across @ across
    level = hypot(R[2, 1], R[2, 2])
    second = atan2(-R[2, 0], level)
    if level < 1e-9:  # gimbal lock: the rotation about x alone suffices
        return atan2(-R[1, 2], R[1, 1]), second, 0.0
    return atan2(R[2, 1], R[2, 2]), second, atan2(R[1, 0], R[0, 0])


def _direction_text(direction: Array) -> list[str]:
    """Return the texts of the rotation that turns z to a unit vector."""
    x, y, z = (float(component) for component in direction)
    return ["0 deg", f"{degrees(acos(min(max(z, -1.0), 1.0))):.6g} deg", f"{degrees(atan2(y, x)):.6g} deg"]


def _link_direction(task: JointTask) -> Array:
    """Return the unit vector of a link; that of its axis if it has no length."""
    for along in (np.array(task.link), np.array(task.axis)):
        if (length := float(np.linalg.norm(along))) > NO_LENGTH:
            break
    direction: Array = along / length
    return direction


def _tube(part: SizedPart, direction: Array) -> Plain:
    """Return the shape of a link's tube, as a file has it: a cylinder along a unit vector, in the link's frame."""
    middle = _mm(tuple(0.5 * component for component in part.task.link))
    size = _mm((part.tube.diameter, part.tube.length))
    return {"kind": "cylinder", "position": middle, "rotation": _direction_text(direction), "size": size}


def _body_shape(part: SizedPart) -> Plain:
    """Return the shape of a joint's body, as a file has it: a cylinder along its axis, in the link's frame."""
    joint = part.joint.machine.joint[next(iter(part.joint.machine.joints))]
    axis = np.array(part.task.axis) / np.linalg.norm(part.task.axis)
    return {
        "kind": "cylinder",
        "rotation": _direction_text(axis),
        "size": _mm((joint.cylinder.diameter, joint.body.height)),
    }


def _mm(values: Sequence[float]) -> list[str]:
    return [f"{1e3 * value:.6g} mm" if abs(value) > 1e-9 else "0 mm" for value in values]
