"""What is sought of the losses of a joint, by their kind, and where a search of another kind begins."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from layflat.description.change import annotation_at, quantity_of
from layflat.identify.benches.hysteresis.model import LEAST, MOST, element_unknowns, within
from layflat.identify.unknown import Unknown
from layflat.machine import Machine
from layflat.physics.hysteresis import LossesPart

FINE = "reversals, sampled finely where the motion reverses"
SMALL = "small motions beside large ones"
STEEPEST, HARDEST = 3.0, 0.2  # greatest beta, and stiffness of the spring over that of the curve's start
SLOPE = 2.0  # greatest power of an element's deflection that its share grows or falls with


def loss_unknowns(at: str, losses: LossesPart, travel: float) -> list[Unknown] | None:
    """Return the unknowns of losses at a path, of a joint that turned by `travel` (rad); None: not of this kind."""
    low, high = LEAST * travel, MOST * travel

    def turn(key: str) -> Unknown:
        return within(f"{at}.{key}", "rad", getattr(losses, key), low, high, FINE, log=True)

    def number(key: str, least: float, most: float) -> Unknown:
        found = within(f"{at}.{key}", "1", getattr(losses, key), least, most, SMALL)
        # The ends are those of the law, but for how large a number may sensibly be.
        return replace(found, floor=True, ceiling=key == "exponent")

    if losses.kind == "elasto-slip":
        return element_unknowns(at, "rad", losses.deflections, losses.weights, travel)
    if losses.kind == "elasto-slip-spectrum":
        return [turn("first"), turn("last"), number("slope", -SLOPE, SLOPE)]
    if losses.kind == "bouc-wen":
        shape = [number("beta", 0.5, STEEPEST), number("exponent", 1.0, 2.0), number("hardening", 0.0, HARDEST)]
        return [turn("deflection"), *shape]
    return None


STARTS: Mapping[str, Any] = {
    "elasto-slip-spectrum": lambda travel: {"first": 0.02 * travel, "last": 0.5 * travel},
    "bouc-wen": lambda travel: {"deflection": 0.05 * travel},
    "elasto-slip": lambda travel: {
        "deflections": tuple(share * travel for share in (0.02, 0.1, 0.5)),
        "weights": (0.4, 0.3, 0.3),
    },
}
"""Kinds that logs are compared by, the simplest first, and where each begins, from the travel (rad)."""


def replaced_losses(machine: Machine, joint: str) -> dict[str, Any]:
    """Return the table of a joint's losses as it stands in a file, by its path."""
    losses = machine.joint[joint].losses

    def text(path: str, value: Any) -> Any:
        quantity = quantity_of(annotation_at(losses, path))
        return value if quantity is None else quantity.text(value, quantity.unit)

    table = {}
    for key in type(losses).model_fields:
        value = getattr(losses, key)
        several = isinstance(value, tuple)
        table[key] = [text(f"{key}.{i}", one) for i, one in enumerate(value)] if several else text(key, value)
    return {f"joint.{joint}.losses": table}
