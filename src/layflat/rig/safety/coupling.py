"""What a joint has to bear of the others and of gravity: what of its pressure says nothing of the joint itself.

| symbol | meaning | unit |
|---|---|---|
| M | mass matrix of the arm | kg m2 |
| t | torques: of hoses, gravity and velocities, less friction | N m |
| j, T | a joint, and those of the others that turn | |
| b_j | torque of its hoses with which joint j stays at rest | N m |

While the joints T turn and j is at rest, M_TT a_T = t_T, and j needs M_jT a_T. Part of that gravity and the others'
velocities give it, g_j: b_j = M_jT a_T - g_j. Joints that rest hold themselves by their brakes.
"""

from layflat.jit import kernel


@kernel
def torques_at_rest(mass, torques, pulls, turns, work, out):
    """Write b_j of each joint into `out`, (joints,).

    Args: M, (joints, joints); t and g, (joints,); 1 where a joint turns, else 0; room for M_TT and a_T, (joints,
    joints + 1).
    """
    n = len(torques)
    for j in range(n):
        m = 0
        for i in range(n):
            if i != j and turns[i] > 0.0:
                column = 0
                for k in range(n):
                    if k != j and turns[k] > 0.0:
                        work[m, column] = mass[i, k]
                        column += 1
                work[m, n] = torques[i]
                m += 1
        _solve(work, m, n)
        needed, m = -pulls[j], 0
        for i in range(n):
            if i != j and turns[i] > 0.0:
                needed += mass[j, i] * work[m, n]
                m += 1
        out[j] = needed


@kernel
def _solve(work, m, right):
    # Gauss's elimination of m symmetric, positive definite rows, which needs no pivots; the solution replaces `right`.
    for i in range(m):
        for k in range(i + 1, m):
            factor = work[k, i] / work[i, i]
            for column in range(i, m):
                work[k, column] -= factor * work[i, column]
            work[k, right] -= factor * work[i, right]
    for i in range(m - 1, -1, -1):
        for k in range(i + 1, m):
            work[i, right] -= work[i, k] * work[k, right]
        work[i, right] /= work[i, i]
