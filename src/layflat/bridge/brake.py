"""Friction of brakes and bearings on joints of a MuJoCo model, which holds exactly.

| symbol | meaning | unit |
|---|---|---|
| A | inverse of the mass matrix, rows and columns of the braked joints | 1/(kg m2) |
| u, v | velocities before the step, and after it without brakes | rad/s |
| B, J | maximum and actual impulse of each brake in the step | N m s |
| S | B of a joint that comes to rest in the step, or is at rest | N m s |
| W | A of all degrees of freedom of the braked trees of bodies | 1/(kg m2) |

Each joint either is at rest, or slides with J = -B sign(v + A J). It is the problem of physics/friction, whose laws
solve it with the inverse of A and the momentum of MuJoCo's velocities.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.jit import kernel
from layflat.lanes import gather, write_numbers
from layflat.physics.friction.turning import solve_varying_friction

MAX_CONTACT_ROUNDS, IMPULSE_TOLERANCE = 30, 1e-7
"""Upper limit of rounds between contacts and brakes; change of J over the maximum B that ends them."""


@kernel
def solve_brakes(like, A, u, v, B, S, J, after):  # type: ignore[no-untyped-def]
    """Solve for J of friction that slides at B and holds up to S, and write it and the velocities after it.

    Args: `like` of `like_tuples`, A (n, n), and arrays (n,), of which J and `after` (rad/s) are written. Velocities of
    held joints are exactly 0.0.
    """
    items, upper = like
    n, at = len(v), 0
    M, triangle = np.linalg.inv(A), np.empty(len(upper))
    for i in range(n):
        for j in range(i, n):
            triangle[at] = M[i, j]
            at += 1
    p = M @ v
    limits = gather(items, B), gather(items, S)
    w, impulses = solve_varying_friction(
        0.0, gather(upper, triangle), gather(items, p), gather(items, u), limits[0], limits[1]
    )
    write_numbers(J, impulses)
    write_numbers(after, w)


def like_tuples(n: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return tuples with an item a joint, and an item of a matrix's upper triangle: `like` of `solve_brakes`."""
    return (0.0,) * n, (0.0,) * (n * (n + 1) // 2)


@kernel
def prepare_brakes(values, entries, damping, tree, at, h, B, applied, W, J, others):  # type: ignore[no-untyped-def]
    """Write W and `others`, limit J to the brakes' maximum in place, and add its torques to `applied`.

    Args:
        values: values of MuJoCo's sparse mass matrix.
        entries: row and column in W, and place in `values`, of each item, (items, 3).
        damping: damping times timestep, added to the diagonal, kg m2, (m,).
        tree: degrees of freedom of the braked trees of bodies, (m,).
        at: indices of the braked joints among them, (n,).
        h: timestep, s.
        B: greatest impulses, moving or not, N m s, (n,).
        applied: torques on all degrees of freedom, N m, changed.
        W: (m, m), written.
        J: impulses of the last step, (n,), limited.
        others: torques in `applied` on the braked joints before, N m, (n,), written.
    """
    M = np.diag(damping)
    for i, j, k in entries:
        M[i, j] += values[k]
        if i != j:
            M[j, i] = M[i, j]
    W[:] = np.linalg.inv(M)
    for i, row in enumerate(at):
        J[i] = min(max(J[i], -B[i]), B[i])
        others[i] = applied[tree[row]]
        applied[tree[row]] = others[i] + J[i] / h


@kernel
def apply_brakes(like, W, tree, at, h, limits, qvel, smooth, constraint, applied, rows):  # type: ignore[no-untyped-def]
    """Apply the brakes' impulses for the forces on all degrees of freedom, which were computed with the old impulses J.

    The new J replace the old ones in `applied` and `rows`. Return whether they differ by `IMPULSE_TOLERANCE` at most.

    Args: W, `tree`, `at`, h and `applied` of `prepare_brakes`; B and S are the rows of `limits` (2, n); velocities and
    forces (N m) of all degrees of freedom; J, the velocities after it and `others` are the rows of `rows` (3, n).
    """
    J, after, others = rows[0], rows[1], rows[2]
    n, before = len(at), J.copy()
    A, free, u = np.empty((n, n)), np.empty(n), np.empty(n)
    for i, row in enumerate(at):
        free[i] = u[i] = qvel[tree[row]]
        for k, dof in enumerate(tree):
            free[i] += h * W[row, k] * (smooth[dof] + constraint[dof])
        for j, column in enumerate(at):
            A[i, j] = W[row, column]
            free[i] -= A[i, j] * J[j]
    solve_brakes(like, A, u, free, limits[0], limits[1], J, after)
    for i, row in enumerate(at):
        applied[tree[row]] = others[i] + J[i] / h
    return np.max(np.abs(J - before)) <= IMPULSE_TOLERANCE * np.max(limits[0])


class Brakes:
    """Brakes on some degrees of freedom of a model.

    Contacts and other constraints that touch the braked trees of bodies interact with the brakes: both are solved
    alternately, in up to `MAX_CONTACT_ROUNDS` rounds, of which the last one counts even if it has not converged.

    Args:
        model: an MjModel.
        dofs: braked degrees of freedom, (n,).
    """

    def __init__(self, model: Any, dofs: NDArray[np.int64]) -> None:
        """Find the trees of bodies in which the brakes act, and compile the kernels."""
        from layflat.bridge.arm import import_mujoco  # noqa: PLC0415  # the kernels of this module do not depend on it

        self._mj, self._model = import_mujoco(), model
        # The mass matrix couples nothing beyond a tree of bodies.
        tree = np.flatnonzero(np.isin(model.dof_treeid, model.dof_treeid[dofs]))
        self._tree, self._at = tree, np.searchsorted(tree, dofs)
        rows = [(i, model.M_rowadr[dof] + np.arange(model.M_rownnz[dof])) for i, dof in enumerate(tree)]
        self._entries = np.array([(i, np.searchsorted(tree, model.M_colind[k]), k) for i, row in rows for k in row])
        n, m = len(dofs), len(tree)
        self._like = like_tuples(n)
        self._own = np.zeros((3, n))
        self._inverse, self._unconstrained = np.eye(m), np.zeros(model.nv)
        self._undamped = self._mj.mjtDisableBit.mjDSBL_EULERDAMP.value
        self._compile()

    def apply(self, data: Any, torques: Array) -> Array:
        """Add the brakes' torques to `data.qfrc_applied`, which already has all other torques of this step.

        Args:
            data: MjData between `mj_step1` and `mj_step2`.
            torques: friction at which the joints slide, and its limit where they come to rest, N m, (2, n).

        Returns:
            Impulses (N m s), and the velocities after them (rad/s), exactly 0.0 of held joints, (2, n), valid until the
            next call.
        """
        mj, model, h = self._mj, self._model, self._model.opt.timestep
        mj.mj_fwdActuation(model, data)
        tree, at, W, rows = self._tree, self._at, self._inverse, self._own
        applied, limits = data.qfrc_applied, h * torques
        damping = (0.0 if model.opt.disableflags & self._undamped else h) * model.dof_damping[tree]
        prepare_brakes(data.M, self._entries, damping, tree, at, h, limits.max(axis=0), applied, W, rows[0], rows[2])
        coupled = self._is_constrained(data)
        qvel, smooth = data.qvel, data.qfrc_smooth
        constraint = data.qfrc_constraint if coupled else self._unconstrained
        for _ in range(MAX_CONTACT_ROUNDS if coupled else 1):
            mj.mj_fwdAcceleration(model, data)
            if coupled:
                mj.mj_fwdConstraint(model, data)
            if apply_brakes(self._like, W, tree, at, h, limits, qvel, smooth, constraint, applied, rows):
                break
        return rows[:2]

    def forget(self) -> None:
        """Discard the impulses of the last step, with which the next one would start."""
        self._own[0] = 0.0

    def _is_constrained(self, data: Any) -> bool:
        """Return whether a constraint touches the trees; without MuJoCo's islands, whether there is any constraint."""
        if data.nisland == 0:
            return bool(data.nefc > 0)
        return bool(data.dof_island[self._tree].max() >= 0)

    def _compile(self) -> None:
        """Compile the kernels, so that the first step does not."""
        tree, at, W, rows = self._tree, self._at, self._inverse, self._own
        values, nothing = np.zeros(1 + self._entries[:, 2].max()), np.zeros(self._model.nv)
        prepare_brakes(
            values, self._entries, np.ones(len(tree)), tree, at, 1.0, rows[0].copy(), nothing, W, rows[0], rows[2]
        )
        apply_brakes(self._like, W, tree, at, 1.0, rows[:2].copy(), nothing, nothing, nothing, nothing, rows)
