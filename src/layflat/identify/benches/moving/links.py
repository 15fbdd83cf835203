"""What can be fitted of the links of an arm in space: where their masses are, and how far they spread.

A joint feels of the links after it what its own turn moves, so that some values act on no joint at all (the height of a
base that turns about an upright axis) and others only together (the mass of a link and where that of the link before
it is). The first are left out here; of the others a fit says so.
"""

from collections.abc import Iterator

import numpy as np

from layflat.arrays import Array
from layflat.description.change import replaced, value_at
from layflat.identify.unknown import ParameterSpec, Range, around, factor_range
from layflat.machine import Machine, parameters
from layflat.physics.arms import dynamics
from layflat.physics.arms.chain.description import LinkPart

RESTS = "rests and slow ramps in many postures of all joints"
SWINGS = "chirps up to 3 Hz of all joints, one after the other, without payload"
SCALES = "the weight of the link by itself"

MASSES = factor_range(3.0, 0.1, log=False)  # what adds to something known does not change by factors
LOOKS = 3  # motions by which it is seen whether a value acts on any joint
ASIDE = 0.1  # of a link's size, by which its centre is then moved
FELT = 1e-9  # share of the torques by which it then changes them at least


def links(machine: Machine) -> list[ParameterSpec]:
    """What is looked for of every link, from the base on; nothing of an arm that has its links in its joints."""
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
    """Of a product of inertia: as far as it could be if the body were turned any way."""
    return around(lambda _: 0.5 * max(link.inertia[:3]))


def _size(link: LinkPart) -> float:
    """How far a link reaches if nothing follows on it, from how its mass is spread, m."""
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
    """Whether a value changes the usual torques of any motion."""
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
