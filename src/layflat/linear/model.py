"""Linear model of a plant near an operating point, as a `StateSpace` of python-control.

A plant with dry friction has no single linear model, so that each joint is in one of two states:

- **held**: friction or a brake holds the shaft. Valve, tubes and air respond; the angle is no state.
- **sliding**: the joint moves steadily in one direction, and small signals change its velocity, but do not reverse it.
  So dry friction is a constant torque (of Stribeck's kind, one with the slope at that velocity), elements of the
  hysteresis slip, their torques follow the pressure, and creep relaxes. A signal that reverses the motion sees another
  plant: a stiffer one.

The parts are differentiated one by one from the plant's own laws (rates.py, losses.py, valve.py) and connected here.
The valve's wave is averaged. Its delay is Pade's approximation of second order for each control cycle, so that the sum
of two neighbouring commands, which is how the plant delays by a fraction of a cycle, is kept.
"""

from collections.abc import Mapping
from functools import partial, reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.extras import import_extra
from layflat.linear.operating_point import SLIDING_STATE, find_operating_point
from layflat.linear.orbit import linearize_air
from layflat.linear.point import OperatingPoint
from layflat.linear.rates import AirInputs, MovingJoint, air_columns
from layflat.linear.valve import LinearValve
from layflat.machine import Machine, load
from layflat.motion.signal_values import Angles, Pair, Value
from layflat.physics.driver import MAX_DELAY_CYCLES, command_weight
from layflat.physics.joint import has_second

if TYPE_CHECKING:
    from control import StateSpace

LAG_FLOOR = 1e-12  # coefficient below which a lag has one order less, s2 (a_2) and s (a_1, its root)
AIR_NAMES = ("pressure", "temperature", "line_pressure", "line_temperature")
UNITS = {
    "angle": "rad", "velocity": "rad/s", "opening": "1", "opening_rate": "1/s", "voltage": "V", "load": "N m",
    "differential_pressure": "Pa", "pressure": "Pa", "temperature": "K", "delay": "1", "loss": "N m",
}  # fmt: skip
"""Units by the end of a signal's name, without the letter of its hose and numbers."""


class ModelPart(NamedTuple):
    """Part of a model with names of its states and signals; signals of equal names are connected."""

    system: Any  # `StateSpace`
    states: list[str]
    inputs: list[str]
    outputs: list[str]


def linearize(
    machine: str | Path | Machine,
    *,
    configuration: Angles = 0.0,
    pressures: Pair | Mapping[str, Pair] | None = None,
    joints: str | Mapping[str, str] = SLIDING_STATE,
    speed: Value | None = None,
) -> "StateSpace":
    """Return the linear model of a machine's plant near an operating point.

    Inputs are, by joint, `NAME_voltage` (V) of the valve's driver and, where the joint slides, `NAME_load` (N m), an
    external torque. Outputs are `NAME_differential_pressure`, `NAME_pressure_a`, `NAME_pressure_b` (Pa) and, where it
    slides, `NAME_angle` (rad) and `NAME_velocity` (rad/s). All are deviations from the operating point.

    The voltage is one that varies in time. A controller holds it for a cycle, which is a further half a cycle of delay:
    `control.sample_system(model, cycle)` is the model for such a controller.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        configuration: angles of the joints; numbers are in rad.
        pressures: absolute pressures of hoses A and B, for all joints or by joint; numbers are in Pa; default: those
            that the valves hold while they carry the load. Others drift; the model is that of the first moment.
        joints: "held" or "sliding" (see the module), for all joints or by joint; joints that a table leaves out are
            held.
        speed: velocity of joints that slide; its sign is the direction; a number is in rad/s; default: 0.3 deg/s, or
            twice the velocity that the ripple of the valves' waves has, where that is more.

    Returns:
        A model in continuous time whose states, inputs and outputs are named. Its attribute `units` has the unit of
        each signal by its name, and `operating_point` the `OperatingPoint`.

    Raises:
        InputError: an argument is wrong, or there is no equilibrium.
        MissingExtraError: python-control is not installed.

    Example:
        >>> import layflat as lf
        >>> model = lf.linearize("paper-small-joint", joints="held")
        >>> model.output_labels
        ['small_differential_pressure', 'small_pressure_a', 'small_pressure_b']
        >>> f"{abs(model['small_differential_pressure', 'small_voltage'](2j * 3.1416)) / 1e5:.2f} bar/V at 1 Hz"
        '0.49 bar/V at 1 Hz'
    """
    import_extra("control", "control", where="linearize")
    return model_at(find_operating_point(load(machine), configuration, pressures, joints, speed))


def model_at(point: OperatingPoint) -> "StateSpace":
    """Return the linear model of the plant near an operating point (see `linearize`)."""
    control = import_extra("control", "control", where="linearize")
    parts = [_air_part(control, point)]
    inputs = [f"{joint}_voltage" for joint in point.machine.joints]
    for j, joint in enumerate(point.machine.joints):
        parameters, losses = point.plant.joints[j], point.losses[j]
        parts.append(_delay_part(control, joint, parameters.valve, point.machine.cycle))
        parts.append(_lag_part(control, joint, point.valves[j]))
        parts += [_losses_part(control, joint, hose, loss) for hose, loss in zip("ab", losses, strict=False)]
        inputs += [] if point.plant.held[j] else [f"{joint}_load"]
    model = connect(control, parts, inputs, parts[0].outputs, point.machine.name)
    model.units = {name: unit_of(name) for name in (*model.state_labels, *inputs, *model.output_labels)}
    model.operating_point = point
    return model


def unit_of(name: str) -> str:
    """Return the unit of a state, input or output by its name."""
    words = [word for word in name.split("_") if word not in ("a", "b") and not word.isdigit()]
    ends = ("_".join(words[-count:]) for count in (2, 1))
    return next(UNITS[end] for end in ends if end in UNITS)


def connect(control: Any, parts: list[ModelPart], inputs: list[str], outputs: list[str], name: str) -> "StateSpace":
    """Return the system of parts whose signals of equal names are connected, outputs added to each other.

    Args:
        control: the package.
        parts: the parts; no connection closes a loop without states.
        inputs: names of the system's inputs, which are added to what is connected to inputs of these names.
        outputs: names of its outputs.
        name: name of the system.
    """
    states, given, seen = ([label for part in parts for label in part[i]] for i in (1, 2, 3))
    across = np.equal.outer(given, seen).astype(float)
    closed = reduce(lambda a, b: a.append(b), [part.system for part in parts]).feedback(across, sign=1)
    into, out = np.equal.outer(given, inputs).astype(float), np.equal.outer(outputs, seen).astype(float)
    matrices = closed.A, closed.B @ into, out @ closed.C, out @ closed.D @ into
    return control.ss(*matrices, states=states or None, inputs=inputs, outputs=outputs, name=name)


def _lag_part(control: Any, joint: str, valve: LinearValve) -> ModelPart:
    """Return the averaged valve of a joint, from the opening that its driver demands to its paths' conductances."""
    a_1, a_2 = valve.lag
    slopes = np.array(valve.slopes)[:, np.newaxis]
    states = [f"{joint}_opening", f"{joint}_opening_rate"]
    if a_2 > LAG_FLOOR:
        A, B = np.array([[0.0, 1.0], [-1.0 / a_2, -a_1 / a_2]]), np.array([[0.0], [1.0 / a_2]])
        system = control.ss(A, B, slopes @ [[1.0, 0.0]], np.zeros((2, 1)))
    elif a_1 > LAG_FLOOR**0.5:
        system, states = control.ss(-1.0 / a_1, 1.0 / a_1, slopes, np.zeros((2, 1))), states[:1]
    else:
        system, states = control.ss([], [], [], slopes), []
    return ModelPart(system, states, [f"{joint}_demand"], [f"{joint}_fills", f"{joint}_vents"])


def _delay_part(control: Any, joint: str, valve: Any, cycle: float) -> ModelPart:
    """Return the driver of a joint's valve, from its voltage to the opening that it demands, with its delay.

    A cycle is e^-sT; older commands pass through more of them: w_0 + e^-sT (w_1 + e^-sT (w_2 + ...)).
    """
    weights = [float(command_weight(valve.delay / cycle, age)) for age in range(MAX_DELAY_CYCLES + 1)]
    system = control.ss([], [], [], 0.0)
    for weight in weights[::-1]:
        delayed = control.tf2ss(*control.pade(cycle, 2)) * system if np.any(system.D) or system.nstates else system
        system = weight + delayed
    states = [f"{joint}_delay_{i + 1}" for i in range(system.nstates)]
    return ModelPart(system * (1.0 / valve.volts_to_full), states, [f"{joint}_voltage"], [f"{joint}_demand"])


def _losses_part(control: Any, joint: str, hose: str, losses: Any) -> ModelPart:
    """Return the losses of a hose (a or b), from velocity and pressure to their part of the joint's load."""
    n = len(losses.A)
    system = control.ss(losses.A, losses.B, -losses.C.reshape(1, n), -losses.D.reshape(1, 2))
    states = [f"{joint}_loss_{hose}_{i + 1}" for i in range(n)]
    return ModelPart(system, states, [f"{joint}_velocity", f"{joint}_pressure_{hose}"], [f"{joint}_load"])


def _air_part(control: Any, point: OperatingPoint) -> ModelPart:
    """Return air and motion, from conductances and loads to all that can be observed."""
    model, names = linearize_air(point), []
    for j, joint in enumerate(point.machine.joints):
        labels = dict(enumerate(MovingJoint._fields[:2]))
        for hose, columns in zip("ab", air_columns(point.plant.joints[j]), strict=True):
            labels |= {i: f"{name}_{hose}" for i, name in zip(columns, AIR_NAMES, strict=False)}
        names += [f"{joint}_{labels[i]}" for k, i in model.places if k == j]
    inputs = [f"{joint}_{name}" for joint in point.machine.joints for name in AirInputs._fields]
    C, outputs = _outputs(point, names)
    return ModelPart(control.ss(model.A, model.B, C, np.zeros((len(C), len(inputs)))), names, inputs, outputs)


def _outputs(point: OperatingPoint, names: list[str]) -> tuple[Array, list[str]]:
    """Return rows of the outputs over states with names, and the outputs' names."""
    rows: dict[str, Array] = {}
    row = partial(np.equal, names)
    for j, joint in enumerate(point.machine.joints):
        a, b = f"{joint}_pressure_a", f"{joint}_pressure_b"
        rows[f"{joint}_differential_pressure"] = row(a).astype(float) - row(b)
        plain = [a, b][: 1 + int(has_second(point.plant.joints[j].second))]
        plain += [] if point.plant.held[j] else [f"{joint}_angle", f"{joint}_velocity"]
        rows |= {name: row(name).astype(float) for name in plain}
    return np.array(list(rows.values())), list(rows)
