"""Stale values of descriptions: derived from others that have changed since."""

from dataclasses import dataclass

from layflat.description.library import Layer
from layflat.description.tables import leaves, overlay
from layflat.machine import tube
from layflat.machine.loader import MACHINE_LIBRARY
from layflat.machine.model import Machine
from layflat.machine.parts import Joint, body_mass

DERIVED_FROM = {
    "link.centre": ("link.length",),
    "link.inertia": ("link.length", "link.mass"),
    "body.mass": ("hose.width", "cylinder.diameter", "cylinder.wall", "output.radius"),
}
"""Values of a joint that can be derived, and the values that they are derived from."""

UNITS = {"link.centre": "m", "link.inertia": "kg m^2", "body.mass": "kg"}

MAX_DEVIATION = 0.05  # relative deviation up to which a derived or assumed value is not stale


@dataclass(frozen=True)
class StaleValue:
    """Value that is inconsistent with those that it is derived from."""

    path: str  # dotted path
    what: str  # the inconsistency, for the message
    right: str  # advice


def stale_values(machine: Machine) -> list[StaleValue]:
    """Return the values of a description that belong to other sizes than it has now.

    A value is stale if it deviates from the derived one by more than `MAX_DEVIATION`, and either a file changes the
    sizes but inherits the value, or its source is "derived" or "assumed" (not of a body's mass).

    Raises:
        MachineError: files of the description are missing or broken by now.
    """
    layers = MACHINE_LIBRARY.layers(machine.origin)
    stale = []
    for name, joint in machine.joints.items():
        for key, now in _derived(joint).items():
            path, sizes = f"joint.{name}.{key}", DERIVED_FROM[key]
            value = _value(joint, key)
            changed = _changed_above(layers, path, [f"joint.{name}.{size}" for size in sizes])
            source = machine.provenance.get(path)
            off = abs(value - now) > MAX_DEVIATION * abs(now)
            unsure = source is not None and source.source in {"derived", "assumed"} and key != "body.mass"
            if off and (changed or unsure):
                why = f"{changed} has changed" if changed else f"{' and '.join(sizes)} say otherwise"
                right = f"give it anew, or leave it out (omits) for {now:.3g} {UNITS[key]}"
                stale.append(StaleValue(path, f"{value:.4g} {UNITS[key]} is from before: {why}", right))
    return stale


def tubes_counted_twice(machine: Machine) -> list[StaleValue]:
    """Return the dead volumes of a machine's hoses that seem to include the air of a tube that is described as well.

    A dead volume does if its note names the tube, or if it is inherited by the file that describes the tube.

    Raises:
        MachineError: files of the description are missing or broken by now.
    """
    layers = [dict(leaves(layer.plain)) for layer in MACHINE_LIBRARY.layers(machine.origin)]
    double = []
    for name, line in machine.lines.items():
        path = f"joint.{name}.hose.dead_volume"
        if line is None:
            continue
        tubes = (f"joint.{name}.line.length", "line.length")
        first = next((i for i, layer in enumerate(layers) if any(tube in layer for tube in tubes)), 0)
        source = machine.provenance.get(path)
        noted = source is not None and "tube" in source.note
        if noted or not any(path in layer for layer in layers[first:]):
            volume = machine.joint[name].hose.dead_volume
            more = f"the line has {1e6 * tube.volume(line):.3g} ml more"
            what = f"{1e6 * volume:.4g} ml seem to include the tube, of which {more}"
            double.append(StaleValue(path, what, "give it without the tube"))
    return double


def _value(joint: Joint, key: str) -> float:
    """Return the value of a joint at a key such as "link.mass"."""
    part, _, name = key.partition(".")
    return float(getattr(getattr(joint, part), name))


def _derived(joint: Joint) -> dict[str, float]:
    """Return the values of a joint that the package derives, by key: body mass, and centre and inertia of the link."""
    mass, link = {"body.mass": body_mass(joint)}, joint.link
    if link is None:
        return mass
    return {"link.centre": link.length / 2, "link.inertia": link.mass * link.length**2 / 12} | mass


def _changed_above(layers: list[Layer], path: str, sizes: list[str]) -> str:
    """Return the first of the sizes that a layer above the last one with the value changes; empty if none does."""
    plain: dict[str, object] = {}
    changed = ""
    for layer in layers:
        before, here = dict(leaves(plain)), dict(leaves(layer.plain))
        plain = overlay(plain, layer.plain)
        if path in here:
            changed = ""
            continue
        for size in sizes:
            if path in before and size in here and here[size] != before.get(size):
                changed = changed or size
    return changed
