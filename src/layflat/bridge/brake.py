"""Brakes and bearings on some joints of a MuJoCo model, whose friction holds exactly.

| symbol | meaning | unit |
|---|---|---|
| A | inverse of the mass matrix, rows and columns of the braked joints | 1/(kg m2) |
| u, v | velocities before the step, and those that it would end with, were there no brakes | rad/s |
| B, J | greatest and actual impulse of each brake in the step | N m s |
| S | the same as B, of a joint that comes to rest in the step, or is at rest | N m s |
| W | A of all degrees of freedom of the braked trees of bodies | 1/(kg m2) |

Each joint either stands still, or slides with J = -B sign(v + A J). It is the problem of physics/friction, whose laws
solve it: with A inverted and what MuJoCo has found so far for the momentum.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.jit import kernel
from layflat.lanes import gather, write_numbers
from layflat.physics.friction.turning import slide

ROUNDS, CLOSE = 30, 1e-7
"""Rounds in which contacts answer to the brakes; the change of J, as a share of the greatest B, that ends them."""


@kernel
def rub(like, A, u, v, B, S, J, after):  # type: ignore[no-untyped-def]
    """Solve for J of friction that slides at B and holds up to S, and write it and the velocities after it.

    Args: two tuples with an item a joint, and an item for each in the upper triangle of a matrix; arrays (n, n), and
    (n,) each, the last two to be written. Velocities of held joints are 0.0.
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
    w, impulses = slide(0.0, gather(upper, triangle), gather(items, p), gather(items, u), limits[0], limits[1])
    write_numbers(J, impulses)
    write_numbers(after, w)


def tuples_for(n: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return what tells `rub` of how many joints it is."""
    return (0.0,) * n, (0.0,) * (n * (n + 1) // 2)


@kernel
def begin(values, entries, damping, tree, at, h, B, applied, W, J, others):  # type: ignore[no-untyped-def]
    """Write W and what others apply to the braked joints, and apply J as far as the brakes can.

    Args:
        values: of MuJoCo's sparse mass matrix.
        entries: row and column in W, and place in `values`, of each item, (items, 3).
        damping: to be added to the diagonal, (m,).
        tree: degrees of freedom of the braked trees of bodies, (m,).
        at: where the braked joints are among them, (n,).
        h: timestep, s.
        B: greatest impulses, moving or not, (n,).
        applied: torques on all degrees of freedom, N m.
        W: (m, m).
        J: (n,).
        others: (n,), N m.
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
def answer(like, W, tree, at, h, limits, qvel, smooth, constraint, applied, own):  # type: ignore[no-untyped-def]
    """Apply the brakes' answer to forces on all degrees of freedom, which hold with the impulses J.

    The new J are applied, and the velocities after them written; returns whether they are close to the old ones.
    `like` is that of `rub`; B and S are the rows of `limits` (2, n), and J, the velocities after it and what others
    apply those of `own` (3, n).
    """
    J, after, others = own[0], own[1], own[2]
    n, before = len(at), J.copy()
    A, free, u = np.empty((n, n)), np.empty(n), np.empty(n)
    for i, row in enumerate(at):
        free[i] = u[i] = qvel[tree[row]]
        for k, dof in enumerate(tree):
            free[i] += h * W[row, k] * (smooth[dof] + constraint[dof])
        for j, column in enumerate(at):
            A[i, j] = W[row, column]
            free[i] -= A[i, j] * J[j]
    rub(like, A, u, free, limits[0], limits[1], J, after)
    for i, row in enumerate(at):
        applied[tree[row]] = others[i] + J[i] / h
    return np.max(np.abs(J - before)) <= CLOSE * np.max(limits[0])


class Brakes:
    """Brakes on some degrees of freedom of a model.

    Contacts and other constraints that touch the braked trees of bodies answer to the brakes and the brakes to them:
    both are solved in turns.

    Args:
        model: an MjModel.
        dofs: what is braked, (n,).
    """

    def __init__(self, model: Any, dofs: NDArray[np.int64]) -> None:
        from layflat.bridge.arm import engine  # noqa: PLC0415  # kernels stand here, which do not depend on it

        self._mj, self._model = engine(), model
        # The mass matrix couples nothing beyond a tree of bodies.
        tree = np.flatnonzero(np.isin(model.dof_treeid, model.dof_treeid[dofs]))
        self._tree, self._at = tree, np.searchsorted(tree, dofs)
        rows = [(i, model.M_rowadr[dof] + np.arange(model.M_rownnz[dof])) for i, dof in enumerate(tree)]
        self._entries = np.array([(i, np.searchsorted(tree, model.M_colind[k]), k) for i, row in rows for k in row])
        n, m = len(dofs), len(tree)
        self._like = tuples_for(n)
        self._own = np.zeros((3, n))
        self._inverse, self._unconstrained = np.eye(m), np.zeros(model.nv)
        self._undamped = self._mj.mjtDisableBit.mjDSBL_EULERDAMP.value
        self._compile()

    def apply(self, data: Any, torques: Array) -> Array:
        """Add the brakes' torques to `data.qfrc_applied`; all else that acts in this step is there already.

        Args:
            data: MjData between `mj_step1` and `mj_step2`.
            torques: at which the joints slide, and up to which they are held where they come to rest, N m, (2, n).

        Returns:
            Impulses (N m s), and the velocities that they leave (rad/s), exactly 0.0 where they hold, (2, n), until the
            next call.
        """
        mj, model, h = self._mj, self._model, self._model.opt.timestep
        mj.mj_fwdActuation(model, data)
        tree, at, W, own = self._tree, self._at, self._inverse, self._own
        applied, limits = data.qfrc_applied, h * torques
        damping = (0.0 if model.opt.disableflags & self._undamped else h) * model.dof_damping[tree]
        begin(data.M, self._entries, damping, tree, at, h, limits.max(axis=0), applied, W, own[0], own[2])
        coupled = self._coupled(data)
        qvel, smooth = data.qvel, data.qfrc_smooth
        constraint = data.qfrc_constraint if coupled else self._unconstrained
        for _ in range(ROUNDS if coupled else 1):
            mj.mj_fwdAcceleration(model, data)
            if coupled:
                mj.mj_fwdConstraint(model, data)
            if answer(self._like, W, tree, at, h, limits, qvel, smooth, constraint, applied, own):
                break
        return own[:2]

    def forget(self) -> None:
        """Begin the next step without what was found in the last."""
        self._own[0] = 0.0

    def _coupled(self, data: Any) -> bool:
        """Return whether a constraint touches the trees; MuJoCo tells where it looks for islands."""
        if data.nisland == 0:
            return bool(data.nefc > 0)
        return bool(data.dof_island[self._tree].max() >= 0)

    def _compile(self) -> None:
        """Now, not while a clock runs."""
        tree, at, W, own = self._tree, self._at, self._inverse, self._own
        values, nothing = np.zeros(1 + self._entries[:, 2].max()), np.zeros(self._model.nv)
        begin(values, self._entries, np.ones(len(tree)), tree, at, 1.0, own[0].copy(), nothing, W, own[0], own[2])
        answer(self._like, W, tree, at, 1.0, own[:2].copy(), nothing, nothing, nothing, nothing, own)
