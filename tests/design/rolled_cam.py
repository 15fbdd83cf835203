"""A cam rolled numerically, and strap lines found by root finding: apart from how the package makes either."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, pi, sin

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import brentq

from layflat.machine import Joint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shell:
    """The left hose of a joint with an offset shaft, written out from the paper and docs/derivations-cam.md."""

    joint: Joint

    def force(self, s: float) -> float:
        """F/P by Eq. (1) at travel s."""
        hose, R = self.joint.hose, self.joint.cylinder.diameter / 2
        alpha = hose.wrap - s / (hose.peel_ratio * R)
        wide = hose.width - R * (hose.wrap - alpha) / 2
        return R / (2 * cos((pi - hose.wrap) / 2)) * wide * (1 - cos(alpha))

    @property
    def full_travel(self) -> float:
        hose = self.joint.hose
        return hose.peel_ratio * self.joint.cylinder.diameter / 2 * (hose.wrap - hose.contact_end)

    @property
    def torque_constant(self) -> float:
        """K by energy: swept volume over the stroke of the round roller."""
        swept, _ = quad(self.force, 0, self.full_travel, epsrel=1e-12)
        return swept * self.joint.output.radius / self.full_travel

    @property
    def axis(self) -> Array:
        return np.array([0.0, self.joint.output.shaft_offset])

    def strap_point(self, s: float) -> Array:
        """The shell turns rigidly about the clamp at the cylinder's lowest point."""
        R, gamma = self.joint.cylinder.diameter / 2, self.joint.hose.wrap
        hinge = np.array([0.0, -R])
        arm = np.array([-R * sin(gamma), -R * cos(gamma)]) - hinge
        turn = s / float(np.hypot(*arm))
        turned: Array = np.array([[cos(turn), -sin(turn)], [sin(turn), cos(turn)]]) @ arm
        return hinge + turned

    def motion(self, s: float) -> Array:
        """A'(s) by finite differences."""
        return (self.strap_point(s + 1e-6) - self.strap_point(s - 1e-6)) / 2e-6

    def line(self, s: float) -> tuple[float, float]:
        """Lever arm and angle of the normal for which virtual work gives the torque K, by root finding."""
        out = self.strap_point(s) - self.axis
        D, towards = float(np.hypot(*out)), atan2(out[1], out[0])

        def too_much(beta: float) -> float:
            u = np.array([cos(towards + beta), sin(towards + beta)])
            tension = self.force(s) / float(self.motion(s) @ u)
            return tension * D * sin(beta) - self.torque_constant

        beta = float(brentq(too_much, 1e-6, 1.2, xtol=1e-14))
        return D * sin(beta), towards + beta - pi / 2


@dataclass(frozen=True)
class RolledCam:
    """A polygon whose strap is tied to its first corner and lies along the working corners."""

    corners: Array
    shell: Shell

    def placed(self, angle: float) -> Array:
        c, s = cos(angle), sin(angle)
        turned: Array = self.corners @ np.array([[c, s], [-s, c]])
        return turned + self.shell.axis

    def touch(self, angle: float, s: float) -> tuple[int, Array]:
        """The corner at which the strap from A leaves the polygon, and that corner's place."""
        A, corners = self.shell.strap_point(s), self.placed(angle)
        sight = self.shell.axis - A
        seen = corners - A
        bearing = np.arctan2(sight[0] * seen[:, 1] - sight[1] * seen[:, 0], seen @ sight)
        k = int(np.argmax(bearing))
        return k, corners[k]

    def strap_length(self, angle: float, s: float) -> float:
        k, corner = self.touch(angle, s)
        wound = float(np.hypot(*np.diff(self.corners[: k + 1], axis=0).T).sum())
        return wound + float(np.hypot(*(self.shell.strap_point(s) - corner)))

    def travel(self, angle: float) -> float:
        """Travel at which the strap is as long as at the start."""
        length = self.strap_length(0.0, 0.0)
        end = self.shell.full_travel
        return float(brentq(lambda s: self.strap_length(angle, s) - length, -0.05 * end, 1.05 * end, xtol=1e-13))

    def torque_by_work(self, angle: float, step: float = 0.01) -> float:
        """P dV/dphi per pressure, from how far the shell moves when the cam is turned."""
        return (
            self.shell.force(self.travel(angle)) * (self.travel(angle + step) - self.travel(angle - step)) / (2 * step)
        )

    def torque_by_lever(self, angle: float) -> float:
        """Tension times lever arm per pressure, with the tension that balances the shell."""
        s = self.travel(angle)
        A = self.shell.strap_point(s)
        pull = A - self.touch(angle, s)[1]
        u = pull / np.hypot(*pull)
        out = A - self.shell.axis
        lever = float(u[1] * out[0] - u[0] * out[1])
        return lever * self.shell.force(s) / float(self.shell.motion(s) @ u)
