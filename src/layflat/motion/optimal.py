"""The quickest motion along a path that hoses and valves can do, from rest to rest.

| symbol | meaning | unit |
|---|---|---|
| s, b | how far along the path; s'^2 | m or rad, that^2/s^2 |
| t | torques of the joints, but for dry friction | N m |
| m, c, g | torques per s'', per s'^2, and of gravity (dynamics.py) | N m per that |
| d | damping | N m s/rad |
| R, k | greatest rate of a joint's torque; stiffness of its hoses | N m/s, N m/rad |
| h | time between the middles of two intervals | s |

On a grid of the path b is linear in between, so that s'' = (b_(k+1) - b_k)/(2 ds) and m s'' + c s'^2 + g are linear in
it (bobrow1985, verscheure2009). Two things are not, and are replaced by their tangents at the last solution: damping,
and the time h, which is a convex function of b. The air that a valve lets through changes the torque, and feeds the
hoses of a joint that turns by dq: |dt + k dq| <= R h. A tangent of h lies below it, so that each linear programme
allows only what the limits allow, and its solution is one to begin the next with.

Dry friction counts in what the hoses have to give, and not in its rate: a joint that turns round is held by it
meanwhile, and one at rest has the torque that friction takes before it moves.
"""

import numpy as np
from scipy.interpolate import CubicSpline

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.limits import RESERVE, Ability, TipLimits, abilities
from layflat.motion.path import CLOSE, Path
from layflat.motion.programme import INTERVALS, Programme
from layflat.motion.trajectory import Along, Rest, Trajectory

STEP = 4.0  # factor by which b changes at most from one solution to the next
CONVERGED = 1e-5  # relative gain of time at which the last solution is taken
MOST = 60  # linear programmes on a grid
GRIDS = 2  # the nodes of the first are even in the time of a gentle motion, of the next in that of what was found
SHORT = 0.02  # duration of a motion that is too quick for any arm, s


def time_optimal(
    machine: Machine, path: Path, *, payload: float | None = None, tip: TipLimits | None = None,
    reserve: float = RESERVE, able: Ability | None = None,
) -> Trajectory:  # fmt: skip
    """Return the quickest motion along a path, from rest to rest.

    Args:
        machine: whose arm moves.
        path: of its joints.
        payload: kg; default: the machine's.
        tip: limits of the tip's motion; default: none.
        reserve: share of speeds, torques and their rates that is left to feedback.
        able: what the joints can do; default: what hoses and valves can.

    Raises:
        MachineError: the arm can't hold itself somewhere on the path, or has no valves.
    """
    if path.length < CLOSE:
        return Rest(0.0, path.end)
    mass = machine.arm.payload if payload is None else payload
    left, tip = (able or abilities(machine)).less(reserve), tip or TipLimits()
    s = _least_jerk(path.length)
    for _ in range(GRIDS):
        times = np.linspace(0.0, s.x[-1], INTERVALS + 1)
        programme = Programme(machine, path, mass, left, tip, s(times))
        b = _quickest(programme, programme.slowed(s(times, 1) ** 2))
        s = CubicSpline(np.append(0.0, np.cumsum(programme.times(b))), programme.s, bc_type="clamped")
    return Along(float(s.x[-1]), path, lambda times: (s(times), s(times, 1), s(times, 2)))


def _least_jerk(length: float) -> CubicSpline:
    """Return the motion with the least jerk, much too quick.

    From rest it goes with t^3, as do motions whose torques have limited rates.
    """
    u = np.linspace(0.0, 1.0, INTERVALS + 1)
    return CubicSpline(SHORT * u, length * u**3 * (10.0 - 15.0 * u + 6.0 * u**2), bc_type="clamped")


def _quickest(programme: Programme, b: Array) -> Array:
    """Return the b to which linear programmes converge from another one."""
    duration, step = programme.times(b).sum(), STEP
    for _ in range(MOST):
        found = programme.improved(b, step)
        gain = 1.0 - programme.times(found).sum() / duration
        if gain > 0.0:
            b, duration = found, programme.times(found).sum()
        else:
            step = step**0.5
        if abs(gain) < CONVERGED:
            break
    return b
