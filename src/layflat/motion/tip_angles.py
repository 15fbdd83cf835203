"""Joint angles for positions of the tip as people write them."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.motion.inverse import InverseKinematics, solve_tip_demand, tip_axes
from layflat.motion.signal_values import Angles, SignalKind, Value, check_real, read_row


def inverse_kinematics(
    machine: str | Path | Machine, tip: Mapping[str, Value] | Sequence[Value] | Array, *, near: Angles = 0.0
) -> Array:
    """Return the joint angles, within the strokes, that place the tip of an arm at a position.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        tip: position, by axis or in the order of the axes: {"x": "0.5 m", "y": "0 m"}, in space with "z"; a number is
            in m. Or several, (positions, axes): each configuration is near to the one before.
        near: angles to which the configuration is near, of all joints, by joint or in their order; a number is in rad.

    Returns:
        Angles (joints,), or (positions, joints), rad.

    Raises:
        InputError: a position is out of reach, or reached by singular configurations alone: with the nearest position
            that is not; or an argument is wrong.

    Example:
        >>> import layflat as lf
        >>> lf.inverse_kinematics("paper-arm", {"x": "0.5 m", "y": "0.3 m"})
        array([-0.2137, -0.0625])
    """
    described = load(machine)
    axes, rest = tip_axes(described), np.zeros(len(described.joints))
    reference = read_row(near, SignalKind("near", u.ANGLE, list(described.joints)), rest)
    kind = SignalKind("tip", u.LENGTH, axes, "axis")
    if isinstance(tip, np.ndarray) and tip.ndim > 1:
        check_real(tip, kind)
        if tip.ndim != 2 or tip.shape[1] != len(axes) or not np.isfinite(tip).all():
            what, right = f"is an array of shape {tip.shape}", f"give finite numbers, (positions, {len(axes)})"
            raise InputError(what, where="tip", right=right)
        return solve_tip_demand(described, tip.astype(np.float64), reference, "tip")
    position = read_row(tip, kind, np.full(len(axes), np.nan))
    if missing := [axis for axis, value in zip(axes, position, strict=True) if np.isnan(value)]:
        raise InputError(f"has no {missing[0]}", where="tip", right=f"give {', '.join(axes)}")
    return InverseKinematics(described).compute_configuration(position, reference, "tip")
