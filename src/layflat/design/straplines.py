"""The line along which the strap pulls the cam: its lever arm, its direction, and how well it follows the shell.

The frame has its origin on the cylinder's axis; y points away from the clamps, along the line of symmetry between the
two opposing hoses. Drawn is the hose on the left, which turns the output anticlockwise (positive); the other is its
mirror image. Derived in docs/derivations-cam.md.

| symbol | meaning | unit |
|---|---|---|
| O | output axis | m |
| A(s) | strap point of the shell; it moves on a circle about its hinge, the clamp | m |
| a | unit vector along A'(s) | 1 |
| u | unit vector along the strap, from the cam to A | 1 |
| n, psi | normal of the strap's line, pointing from O to it, and its angle; u is n turned by +90 deg | 1, rad |
| p | lever arm of the strap about O | m |
| f | force along the travel per pressure | m2 |
| K | torque per pressure that is wanted, the same at all travels | m3/rad |
"""

from dataclasses import dataclass
from math import cos, hypot, pi, sin

import numpy as np
from numpy.typing import ArrayLike

from layflat.arrays import Array
from layflat.design.plates import Plate
from layflat.errors import DesignError
from layflat.machine import Joint

Point = tuple[float, float]

CLAMP_ANGLE = -pi / 2  # angle on the cylinder at which both hoses are clamped, back to back


@dataclass(frozen=True)
class Lines:
    """Line of the strap at each travel; arrays of shape (n,) except `strap_point`."""

    lever: Array  # p, m
    normal_angle: Array  # psi, rad, continuous
    alignment: Array  # A'.u, component of the tension along the shell's motion, over the tension
    strap_point: Array  # A, m, shape (n, 2)


@dataclass(frozen=True)
class ShellLine:
    """Strap straight from the outer shell to the cam on `axis`, without deflecting rollers.

    The shell rotates about `hinge`; `start` is its strap point with a collapsed hose. Eq. (1) gives the force at right
    angles to the chord from clamp to strap point, which is the direction of this point's motion.
    """

    axis: Point
    hinge: Point
    start: Point

    @property
    def chord(self) -> float:
        """Distance of the strap point from the hinge, m."""
        return hypot(self.start[0] - self.hinge[0], self.start[1] - self.hinge[1])

    def lines(self, travel: Array, force: Array, torque_constant: float) -> Lines:
        """Return the strap's lines that yield a constant torque.

        Virtual work: tension A'.u = F, so p = K (A'.u)/f, solved for the direction of u.

        Args:
            travel: s, m, (n,).
            force: f, force per pressure, m2, (n,).
            torque_constant: K, torque per pressure, m3/rad.

        Raises:
            DesignError: at some travel no lever arm yields the torque.
        """
        first = np.arctan2(self.start[1] - self.hinge[1], self.start[0] - self.hinge[0])
        A = np.array(self.hinge) + self.chord * direction_vector(first + travel / self.chord)
        a = rotate_quarter(A - np.array(self.hinge)) / self.chord
        out = A - np.array(self.axis)
        D = np.hypot(out[:, 0], out[:, 1])
        e = out / D[:, None]
        across = rotate_quarter(e)
        along, sideways = np.sum(a * e, axis=-1), np.sum(a * across, axis=-1)
        remainder = D * force / torque_constant - sideways
        bad = ~((along > 0) & (remainder > 0))
        if bad.any():
            at = int(np.argmax(bad))
            away = along[at] > 0
            what = "no lever arm is long enough" if away else "the shell does not move away from the output axis"
            right = "a longer stroke lowers the lever arms; an output axis further from the clamps aligns the strap"
            raise DesignError(f"{what} at {travel[at] * 1e3:.4g} mm of travel", where="cam", right=right)
        beta = np.arctan2(along, remainder)
        u = np.cos(beta)[:, None] * e + np.sin(beta)[:, None] * across
        return Lines(D * np.sin(beta), _normal_angle(u), np.sum(a * u, axis=-1), A)


@dataclass(frozen=True)
class RollerLine:
    """Strap along the drum, over a deflecting roller, to the cam on `axis`; its speed is the travel's everywhere.

    `centre` and `radius` are the roller's; the strap passes roller and cam on the same side.
    """

    axis: Point
    centre: Point
    radius: float

    def lines(self, travel: Array, force: Array, torque_constant: float) -> Lines:
        """Return the strap's lines that yield a constant torque: the tension is F, so p = K/f.

        Args:
            travel: s, m, (n,).
            force: f, force per pressure, m2, (n,).
            torque_constant: K, torque per pressure, m3/rad.

        Raises:
            DesignError: at some travel the lever arm is longer than the roller's distance from the axis allows.
        """
        p = torque_constant / force
        out = np.array(self.centre) - np.array(self.axis)
        D = hypot(*out)
        far = (p - self.radius) / D if D > 0 else np.full_like(p, np.inf)
        bad = np.abs(far) >= 1
        if bad.any():
            at = int(np.argmax(bad))
            needed = f"a lever arm of {p[at] * 1e3:.4g} mm is needed at {travel[at] * 1e3:.4g} mm of travel"
            what = f"{needed}, but the deflecting roller is only {D * 1e3:.4g} mm from the output axis"
            right = "a longer stroke lowers the lever arms; so does a smaller roller radius"
            raise DesignError(what, where="cam", right=right)
        beta = np.arcsin(far)
        e = out / D
        u = np.cos(beta)[:, None] * e + np.sin(beta)[:, None] * rotate_quarter(e)
        psi = _normal_angle(u)
        leaves = np.array(self.centre) + self.radius * direction_vector(psi)
        return Lines(p, psi, np.ones_like(p), leaves)


StrapLine = ShellLine | RollerLine  # line of the strap between hose and cam


def joint_strap_line(joint: Joint) -> StrapLine:
    """Return the line of the strap in a described joint.

    With a deflecting roller, or a shaft in the cylinder's middle, the strap runs along the drum and is deflected at the
    rim; with an offset shaft and no roller it is straight from the shell to the cam.
    """
    R, gamma = joint.cylinder.diameter / 2, joint.hose.wrap
    roller = joint.deflecting_roller
    axis, free = (0.0, joint.output.shaft_offset), CLAMP_ANGLE - gamma
    if roller is not None or joint.output.shaft_offset == 0:
        radius = roller.diameter / 2 if roller else 0.0
        return RollerLine(axis, ((R - radius) * cos(free), (R - radius) * sin(free)), radius)
    return ShellLine(axis, (R * cos(CLAMP_ANGLE), R * sin(CLAMP_ANGLE)), (R * cos(free), R * sin(free)))


def plate_strap_line(plate: Plate, distance: float, height: float) -> ShellLine:
    """Return the line of the strap with plates on either side of the output shaft, straight from shell to cam.

    Args:
        plate: the left one, with a vertical chord, hinged at its lower end.
        distance: distance of the chord from the output axis, m.
        height: height of the output axis above the hinge, m.
    """
    return ShellLine((0.0, height), (-distance, 0.0), (-distance, plate.chord))


def direction_vector(angle: ArrayLike) -> Array:
    """Return unit vectors at angles (rad), shape (..., 2)."""
    return np.stack((np.cos(angle), np.sin(angle)), axis=-1)


def rotate_quarter(vectors: Array) -> Array:
    """Return vectors rotated by +90 deg, shape (..., 2)."""
    return np.stack((-vectors[..., 1], vectors[..., 0]), axis=-1)


def _normal_angle(u: Array) -> Array:
    return np.unwrap(np.arctan2(u[:, 1], u[:, 0])) - pi / 2
