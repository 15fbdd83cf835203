"""Pairs of elements of a joint's losses whose values can be exchanged for others that act nearly the same.

Two elements of given weights w that slip at d have, together, a stiffness k = sum w / d and an area s = sum w d of
their small and large loops. Both stay the same where each d is replaced by s / (k d): the logs tell the two by what is
left, and a search that goes downhill ends at whichever is nearer.
"""

from collections.abc import Iterator
from itertools import combinations

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.physics.hysteresis.elasto_slip import ElastoSlipPart


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
