"""Values that follow from others, were given once, and do not fit any more since those others changed."""

from dataclasses import dataclass

from layflat.description.library import Layer
from layflat.description.tables import laid_over, leaves
from layflat.machine import tube
from layflat.machine.loader import MACHINES
from layflat.machine.model import Machine
from layflat.machine.parts import Joint, body_mass

FOLLOWS = {
    "link.centre": ("link.length",),
    "link.inertia": ("link.length", "link.mass"),
    "body.mass": ("hose.width", "cylinder.diameter", "cylinder.wall", "output.radius"),
}
"""What a value of a joint follows from."""

UNITS = {"link.centre": "m", "link.inertia": "kg m^2", "body.mass": "kg"}

DEVIATION = 0.05  # share by which a value that a file calls derived or assumed may be off


@dataclass(frozen=True)
class Stale:
    """A value that does not fit what it follows from."""

    path: str  # where it stands
    what: str  # why it does not fit
    right: str  # what to do


def stale_values(machine: Machine) -> list[Stale]:
    """Return the values of a description that were given for other sizes than it has now.

    A value is stale if a file changes what it follows from but not the value, which the file has from one that it
    extends; or if its source says that it is derived or assumed, and it is not what follows.

    Raises:
        MachineError: its files are missing or broken by now.
    """
    layers = MACHINES.layers(machine.origin)
    found = []
    for name, joint in machine.joints.items():
        for key, now in _derived(joint).items():
            path, sizes = f"joint.{name}.{key}", FOLLOWS[key]
            given = _value(joint, key)
            changed = _changed_above(layers, path, [f"joint.{name}.{size}" for size in sizes])
            source = machine.provenance.get(path)
            off = abs(given - now) > DEVIATION * abs(now)
            unsure = source is not None and source.source in {"derived", "assumed"} and key != "body.mass"
            if off and (changed or unsure):
                why = f"{changed} has changed" if changed else f"{' and '.join(sizes)} say otherwise"
                right = f"give it anew, or leave it out (omits) for {now:.3g} {UNITS[key]}"
                found.append(Stale(path, f"{given:.4g} {UNITS[key]} is from before: {why}", right))
    return found


def counted_twice(machine: Machine) -> list[Stale]:
    """Return the dead volumes of a machine's hoses that seem to hold the air of a tube that is described as well.

    A dead volume does if its note says so, or if it stands in a file below the one that describes the tube.

    Raises:
        MachineError: its files are missing or broken by now.
    """
    given = [dict(leaves(layer.plain)) for layer in MACHINES.layers(machine.origin)]
    found = []
    for name, line in machine.lines.items():
        path = f"joint.{name}.hose.dead_volume"
        if line is None:
            continue
        tubes = (f"joint.{name}.line.length", "line.length")
        first = next((i for i, layer in enumerate(given) if any(tube in layer for tube in tubes)), 0)
        source = machine.provenance.get(path)
        noted = source is not None and "tube" in source.note
        if noted or not any(path in layer for layer in given[first:]):
            own = machine.joint[name].hose.dead_volume
            more = f"the line has {1e6 * tube.volume(line):.3g} ml more"
            what = f"{1e6 * own:.4g} ml seem to include the tube, of which {more}"
            found.append(Stale(path, what, "give it without the tube"))
    return found


def _value(joint: Joint, key: str) -> float:
    part, _, name = key.partition(".")
    return float(getattr(getattr(joint, part), name))


def _derived(joint: Joint) -> dict[str, float]:
    """Return what the values would be where they are not given."""
    mass, link = {"body.mass": body_mass(joint)}, joint.link
    if link is None:
        return mass
    return {"link.centre": link.length / 2, "link.inertia": link.mass * link.length**2 / 12} | mass


def _changed_above(layers: list[Layer], path: str, sizes: list[str]) -> str:
    """The first of the sizes that a layer above the one that gives a value changes; empty where none does."""
    plain: dict[str, object] = {}
    changed = ""
    for layer in layers:
        before, own = dict(leaves(plain)), dict(leaves(layer.plain))
        plain = laid_over(plain, layer.plain)
        if path in own:
            changed = ""
            continue
        for size in sizes:
            if path in before and size in own and own[size] != before.get(size):
                changed = changed or size
    return changed
