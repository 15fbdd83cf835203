"""Brakes on some joints of a MuJoCo model, which hold exactly.

| symbol | meaning | unit |
|---|---|---|
| A | inverse of the mass matrix, rows and columns of the braked joints | 1/(kg m2) |
| v | velocities that the step would end with, were there no brakes | rad/s |
| B, J | greatest and actual impulse of each brake in the step | N m s |

Find J with |J| <= B such that each joint either stands still, or slides with J = -B sign(v + A J). It is the problem of
physics/friction.py for any number of joints: a convex quadratic in J over a box.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.bridge.engine import engine
from layflat.jit import kernel
from layflat.physics.friction import brake_one, brake_two

Array = NDArray[np.float64]

SWEEPS, EXACT = 2000, 1e-13
"""Sweeps over the joints at most, and the change of J, as a share of the greatest B, at which they end."""

ROUNDS, CLOSE = 30, 1e-7
"""The same for rounds in which contacts answer to the brakes."""


@kernel
def hold(A, v, B, J, after):  # type: ignore[no-untyped-def]
    """Solve for J, beginning with what it holds, and write the velocities after it; those of held joints are 0.0.

    Args: arrays (n, n), (n,), (n,), and (n,) twice to be written. One and two joints are solved in closed form, more by
    projected Gauss-Seidel sweeps, which converge as A is positive definite.
    """
    n = len(v)
    if n == 2:
        per_det = 1.0 / (A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0])
        M_11, M_12, M_22 = A[1, 1] * per_det, -A[0, 1] * per_det, A[0, 0] * per_det
        p_1, p_2 = M_11 * v[0] + M_12 * v[1], M_12 * v[0] + M_22 * v[1]
        after[0], after[1], J[0], J[1] = brake_two(M_11, M_12, M_22, p_1, p_2, B[0], B[1])
        return
    worst, strongest = np.inf, np.max(B)
    for _ in range(SWEEPS):
        if worst <= EXACT * strongest:
            break
        worst = 0.0
        for i in range(n):
            free = v[i] - A[i, i] * J[i]
            for j in range(n):
                free += A[i, j] * J[j]
            before = J[i]
            after[i], J[i] = brake_one(1.0 / A[i, i], free / A[i, i], B[i])
            worst = max(worst, abs(J[i] - before))


class Brakes:
    """Brakes on some degrees of freedom of a model.

    Contacts and other constraints answer to the brakes and the brakes to them: both are solved in turns.

    Args:
        model: an MjModel.
        dofs: what is braked, (n,).
    """

    def __init__(self, model: Any, dofs: NDArray[np.int64]) -> None:
        self._mj, self._model, self._dofs = engine(), model, dofs
        # The mass matrix couples nothing beyond a tree of bodies.
        self._tree = np.flatnonzero(np.isin(model.dof_treeid, model.dof_treeid[dofs]))
        self._at = np.searchsorted(self._tree, dofs)
        self._impulses, self._after = np.zeros(len(dofs)), np.zeros(len(dofs))

    def apply(self, data: Any, torques: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Add the brakes' torques to `data.qfrc_applied`; all else that acts in this step is there already.

        Args:
            data: MjData between `mj_step1` and `mj_step2`.
            torques: at which the brakes slip, N m, (n,).

        Returns:
            Impulses (N m s, (n,)), and which joints are held.
        """
        mj, model, h = self._mj, self._model, self._model.opt.timestep
        mj.mj_fwdActuation(model, data)
        others, most, J = data.qfrc_applied[self._dofs].copy(), h * torques, self._impulses
        np.clip(J, -most, most, out=J)
        inverse = self._inverse(data)
        A = np.ascontiguousarray(inverse[np.ix_(self._at, self._at)])
        for _ in range(ROUNDS):
            data.qfrc_applied[self._dofs] = others + J / h
            mj.mj_fwdAcceleration(model, data)
            mj.mj_fwdConstraint(model, data)
            forces = data.qfrc_smooth[self._tree] + data.qfrc_constraint[self._tree]
            free = data.qvel[self._dofs] + h * (inverse @ forces)[self._at] - A @ J
            before = J.copy()
            hold(A, free, most, J, self._after)
            if data.nefc == 0 or np.max(np.abs(J - before)) <= CLOSE * np.max(most):
                break
        data.qfrc_applied[self._dofs] = others + J / h
        return J.copy(), self._after == 0.0

    def forget(self) -> None:
        """Begin the next step without what was found in the last."""
        self._impulses[:] = 0.0

    def _inverse(self, data: Any) -> Array:
        """Inverse of the trees' mass matrix as the integrator sees it: with the damping that it takes implicitly."""
        model, tree = self._model, self._tree
        unit, product = np.zeros(model.nv), np.zeros(model.nv)
        M = np.empty((len(tree), len(tree)))
        for k, dof in enumerate(tree):
            unit[dof] = 1.0
            self._mj.mj_mulM(model, data, product, unit)
            unit[dof] = 0.0
            M[k] = product[tree]
        if not model.opt.disableflags & self._mj.mjtDisableBit.mjDSBL_EULERDAMP:
            M.flat[:: len(tree) + 1] += model.opt.timestep * model.dof_damping[tree]
        return np.asarray(np.linalg.inv(M))
