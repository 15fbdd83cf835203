"""Unknowns of a machine in motion, block by block, with their bounds; those of an arm in space by link.

A joint feels of the links after it what its own turn moves, so that some values act on no joint at all (the height of a
base that turns about an upright axis) and others only together (the mass of a link and where that of the link before
it is). The first are left out here; of the others a fit says so.

Pairs of elements of a joint's losses can be exchanged for others that act nearly the same. Two elements of given
weights w that slip at d have, together, a stiffness k = sum w / d and an area s = sum w d of their small and large
loops. Both stay the same where each d is replaced by s / (k d): the logs tell the two by what is left, and a search
that goes downhill ends at whichever is nearer.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from layflat.arrays import Array
from layflat.description.change import replaced, value_at
from layflat.errors import InputError
from layflat.identify.benches.contract import check_known
from layflat.identify.unknown import ParameterSpec, Range, Unknown, around, factor_range, fixed_range, from_zero
from layflat.machine import Machine, parameters
from layflat.physics.arms import dynamics
from layflat.physics.arms.chain.description import LinkPart
from layflat.physics.delay import LONGEST
from layflat.physics.friction.stribeck import StribeckPart
from layflat.physics.hysteresis.elasto_slip import ElastoSlipPart
from layflat.physics.valves.switching import SwitchingValvesPart


def mirrored_losses(machine: Machine, columns: dict[str, Array]) -> Iterator[dict[str, Array]]:
    """Yield the values of each pair of elements of each joint that act nearly as the present ones.

    Args:
        machine: that is described; its weights hold.
        columns: values of the unknowns by path, rad for deflections.

    Returns:
        The two that change, by path.
    """
    for name, joint in machine.joints.items():
        if not isinstance(joint.losses, ElastoSlipPart):
            continue
        paths = [f"joint.{name}.losses.deflections.{i}" for i in range(len(joint.losses.deflections))]
        weights = zip(paths, joint.losses.weights, strict=True)
        sought = [(path, weight) for path, weight in weights if path in columns and weight > 0.0]
        for pair in combinations(sought, 2):
            k = sum(weight / columns[path] for path, weight in pair)
            s = sum(weight * columns[path] for path, weight in pair)
            yield {path: s / (k * columns[path]) for path, _ in pair}


RESTS = "rests and slow ramps in many postures of all joints"
SWINGS = "chirps up to 3 Hz of all joints, one after the other, without payload"
SCALES = "the weight of the link by itself"

MASSES = factor_range(3.0, 0.1, log=False)  # what adds to something known does not change by factors
LOOKS = 3  # motions by which it is seen whether a value acts on any joint
ASIDE = 0.1  # of a link's size, by which its centre is then moved
FELT = 1e-9  # share of the torques by which it then changes them at least


def links(machine: Machine) -> list[ParameterSpec]:
    """Return what is looked for of every link, from the base on; nothing of an arm that has its links in its joints."""
    if not machine.arm.own_links:
        return []
    ends = [machine.arm.link[name].place for name in machine.arm.joints[1:]] + [machine.arm.tool]
    crooked = _crooked(machine)
    usual = some_torques(crooked)
    return [
        spec._replace(path=f"arm.link.{name}.{spec.path}")
        for name, end in zip(machine.arm.joints, ends, strict=True)
        for spec in _of_link(machine.arm.link[name], max(float(np.linalg.norm(end)), _size(machine.arm.link[name])))
        if _acts(crooked, f"arm.link.{name}.{spec.path}", usual)
    ]


def _of_link(link: LinkPart, length: float) -> Iterator[ParameterSpec]:
    yield ParameterSpec("mass", "kg", MASSES, SCALES)
    for i in range(3):
        yield ParameterSpec(f"centre.{i}", "m", around(lambda _: 0.5 * length), RESTS)
    for i in range(len(link.inertia)):
        yield ParameterSpec(f"inertia.{i}", "kg m^2", MASSES if i < 3 else _product(link), SWINGS)
    yield ParameterSpec("rotor_inertia", "kg m^2", factor_range(3.0, 0.01, log=False), SWINGS)


def _product(link: LinkPart) -> Range:
    """Return the bound of a product of inertia: as far as it could be if the body were turned any way."""
    return around(lambda _: 0.5 * max(link.inertia[:3]))


def _size(link: LinkPart) -> float:
    """Return how far a link reaches if nothing follows on it, from how its mass is spread, m."""
    return float(np.sqrt(3.0 * max(link.inertia[:3]) / link.mass))


def _crooked(machine: Machine) -> Machine:
    """The machine with no mass on any axis, where a value may be without effect only by chance."""
    for number, name in enumerate(machine.arm.joints):
        link = machine.arm.link[name]
        shift = ASIDE * _size(link) * np.array([1.0, -0.7, 0.4]) * (1.0 + 0.1 * number)
        centre = tuple((np.array(link.centre) + shift).tolist())
        machine = replaced(machine, ["arm", "link", name, "centre"], centre)
    return machine


def _acts(machine: Machine, path: str, usual: Array) -> bool:
    """Return whether a value changes the usual torques of any motion."""
    changed = replaced(machine, path.split("."), 1.5 * value_at(machine, path) + 1e-3)
    return bool(np.max(np.abs(some_torques(changed) - usual)) > FELT * np.max(np.abs(usual)))


def some_torques(machine: Machine) -> Array:
    """Torques of a few random motions, (motions, joints), N m."""
    arm, n, draw = parameters.arm(machine), len(machine.joints), np.random.default_rng(0)
    halves = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
    found = []
    for _ in range(LOOKS):
        q, v, a = draw.uniform(-1.0, 1.0, (3, n)) * [halves, np.ones(n), 10.0 * np.ones(n)]
        upper, moving, pulls = dynamics(arm, machine.arm.payload, tuple(q.tolist()), tuple(v.tolist()))
        mass = np.zeros((n, n))
        mass[np.triu_indices(n)] = upper
        found.append((mass + np.triu(mass, 1).T) @ a - moving - pulls)
    return np.array(found)


FILLING = "steps large enough to open the valve fully, both ways"
SLOW = "slow ramps over the stroke, both ways"
CENTRE = "small motions about the valve's centre"
PAUSES = "pauses of seconds"
SAMPLED = "steps, with the pressure sampled every few milliseconds"

DELAYS = from_zero(lambda machine, _: LONGEST * machine.cycle)
OFFSETS = around(lambda machine: 0.02 * machine.pressure_sensor.range)

VALVE = (
    ParameterSpec("valve.conductance", "m^3/(s Pa)", factor_range(3.0), FILLING),
    ParameterSpec("valve.critical_ratio", "1", fixed_range(0.05, 0.9), "filling from low pressure and venting to it"),
    ParameterSpec("valve.leakage", "m^3/(s Pa)", factor_range(20.0, 1e-9), PAUSES),
    ParameterSpec("valve.centre_voltage", "V", around(lambda machine: 0.2 * machine.valve.volts_to_full), PAUSES),
    ParameterSpec("valve.volts_to_full", "V", factor_range(2.0), "voltages beyond full opening"),
    ParameterSpec("valve.delay", "s", DELAYS, "steps, and chirps up to 3 Hz"),
)
SPOOL = (
    ParameterSpec("valve.overlap", "1", fixed_range(0.0, 0.3), CENTRE),
    ParameterSpec("valve.natural_frequency", "Hz", factor_range(4.0), SAMPLED),
)
SWITCHING = (
    ParameterSpec("valve.dead_band", "1", fixed_range(0.0, 0.3), CENTRE),
    ParameterSpec("valve.opening_delay", "s", factor_range(3.0), "pulses of all lengths"),
    ParameterSpec("valve.closing_delay", "s", factor_range(3.0), "pulses of all lengths"),
)
HOSE = (
    ParameterSpec("hose.torque_factor", "1", factor_range(2.0), "fast moves with a known payload, and without"),
    ParameterSpec("hose.dead_volume", "m^3", factor_range(3.0), FILLING),
    ParameterSpec("hose.compliance", "m^3/Pa", factor_range(10.0, 1e-10), "filling from low pressure"),
    ParameterSpec("hose.wall_conductance", "W/K", factor_range(10.0, 10.0), "fast filling, then pauses of seconds"),
)
LOSSES = (
    ParameterSpec("hose.loss_share", "1", factor_range(3.0, 0.5, most=1.0), SLOW),
    ParameterSpec("losses.pressure_free", "1", fixed_range(0.0, 1.0), f"{SLOW}, at two supply pressures"),
    ParameterSpec("losses.deflections.0", "rad", factor_range(5.0), "small motions to and fro"),
    ParameterSpec("losses.deflections.1", "rad", factor_range(5.0), "motions of a few degrees to and fro"),
    ParameterSpec("losses.deflections.2", "rad", factor_range(4.0), "slow ramps of several sizes"),
)
FRICTION = (
    ParameterSpec("brake.torque", "N m", factor_range(5.0, 5.0), SLOW),
    ParameterSpec("brake.viscous", "N m s/rad", factor_range(20.0, 1.0), "chirps up to 3 Hz"),
)
STRIBECK = (
    ParameterSpec("friction.static_ratio", "1", fixed_range(1.0, 3.0), f"{SLOW}, with pauses"),
    ParameterSpec("friction.velocity", "rad/s", factor_range(10.0), f"{SLOW}, with pauses"),
    ParameterSpec("friction.load_share", "1", fixed_range(0.0, 0.3), f"{SLOW}, at two supply pressures"),
)
LINE = (
    ParameterSpec("line.length", "m", factor_range(3.0), f"{FILLING}, and chirps up to 3 Hz"),
    ParameterSpec("line.bore", "m", factor_range(2.0), FILLING),
)
INERTIA = (ParameterSpec("link.inertia", "kg m^2", MASSES, "chirps up to 3 Hz without payload"),)
PAYLOAD = ParameterSpec("arm.payload", "kg", from_zero(lambda _, guess: max(3.0 * guess, 2.0)), "chirps up to 3 Hz")
SENSORS = ParameterSpec("pressure_sensor.offset", "Pa", OFFSETS, "both pressures by themselves")

BY_JOINT = {"hose": HOSE, "losses": LOSSES, "friction": FRICTION, "inertia": INERTIA}
BLOCKS = ("valve", *BY_JOINT, "line", "payload", "sensors")  # what `--fit` takes for a machine that moves


def unknowns(machine: Machine, blocks: Sequence[str]) -> list[Unknown]:
    """Return what is to be fitted of a machine; raise InputError if there is no such block, or none is given."""
    if not blocks:
        raise InputError("names no block", where="fit", right=f"choose from {', '.join(BLOCKS)}")
    of_kind = SWITCHING if isinstance(machine.valve, SwitchingValvesPart) else SPOOL
    specs = {"valve": [*VALVE, *of_kind], "payload": [PAYLOAD], "sensors": [SENSORS]}
    for block, of in BY_JOINT.items():
        specs[block] = [
            spec._replace(path=f"joint.{name}.{spec.path}")
            for name, joint in machine.joints.items()
            for spec in (*of, *(STRIBECK if block == "friction" and isinstance(joint.friction, StribeckPart) else ()))
        ]
    if machine.arm.own_links:
        specs["inertia"] = links(machine)
    specs["line"] = _of_lines(machine)
    if "line" in blocks and not specs["line"]:
        raise InputError("has no line", where=machine.origin, right="describe its [line], or leave line out of --fit")
    return [spec.unknown(machine) for block in check_known(blocks, BLOCKS, "fit", "block") for spec in specs[block]]


def _of_lines(machine: Machine) -> list[ParameterSpec]:
    """The machine's own line, which all joints without theirs share, then those of joints."""
    shared = machine.line is not None and any(joint.line is None for joint in machine.joints.values())
    own = [f"joint.{name}." for name, joint in machine.joints.items() if joint.line is not None]
    return [spec._replace(path=f"{at}{spec.path}") for at in ([""] if shared else []) + own for spec in LINE]
