"""Paths of the tip of an arm of any kind."""

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.curve import Curve, TipPath
from layflat.motion.planar_path import PlanarPath
from layflat.motion.space_path import SpacePath
from layflat.physics.arms.planar import PlanarArmPart


def tip_path(
    machine: Machine, curve: Curve, start: Array, where: str, *, span: tuple[float, float] | None = None
) -> TipPath:
    """Return the way of the joints on which the tip follows a curve.

    Args:
        machine: whose arm follows it: in closed form in the plane, else as `SpacePath` does.
        curve: of the tip.
        start: posture (joints,), rad, whose tip is where the curve begins.
        where: it was given, for messages.
        span: distances along the curve between which the path is wanted, m; default: its beginning and its end.

    Raises:
        InputError: naming `where`: the arm has too few joints, or begins in a singular posture.
    """
    if isinstance(machine.arm, PlanarArmPart):
        return PlanarPath(machine, curve, start, where)
    return SpacePath(machine, curve, start, where, span=span)
