"""Small-signal model of the losses of a hose whose joint slides: hysteresis, creep, or any kind of them.

| symbol | meaning | unit |
|---|---|---|
| s | numbers of the state of the losses | |
| v, p_g | velocity of the joint, gauge pressure in the hose, means over a period of the valve's wave | rad/s, Pa |
| f | torque against the motion, mean as well | N m |

ds/dt = A s + B (v, p_g), f = C s + D (v, p_g), all as deviations. The law itself, `turned`, is differentiated in each
step of a period of steady sliding. A state that slips in some step forgets its past: it follows velocity and pressure,
with a lag, and its part of f is a lag of first order and a part of D. Of others, the mean of all steps is taken.

The ripple of pressure and velocity matters: an element slips at a torque that follows the pressure, and where that
rises faster than the element is loaded by the rotation, it sticks for a part of the period. Then its mean torque grows
with the velocity, which damps a slow motion, and stiffens a fast one, as that lags.
"""

from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.lanes import leaves, read_numbers
from layflat.linear.differences import jacobian
from layflat.physics.hysteresis import at_rest, torques, turned

SLID_ROTATION, SLID_TURNS = 0.5, 100  # rotation that has made all elements slip, rad, and number of its parts
SETTLING_PERIODS = 3  # of the ripple after that
RELATIVE_CHANGE = 1e-6  # of a state or pressure: small beside the rotation in a step, in which slipping elements slip
TORQUE_CHANGE = 1e-9  # of a state that is zero, N m
FORGOTTEN_FRACTION = 0.5  # fraction of a state that is left after a step, below which it has slipped
FOLLOWED_PERIODS = 10  # in which states that slip have forgotten their start
MIN_LAG = 1e-5  # least lag that is modelled, s


class Ripple(NamedTuple):
    """Deviations of velocity and pressure from their means over a period of the valve's wave, in each step."""

    step: float  # s
    velocity: Array  # at the start of each step, whose rotation the losses follow in it, (steps,), rad/s
    pressure: Array  # (steps,), Pa


class LinearLosses(NamedTuple):
    """Losses of a hose near a steady sliding (symbols as in the module's table)."""

    state: Any  # in the steady sliding, of the law
    torque: float  # f there, N m
    A: Array  # (states, states)
    B: Array  # (states, 2)
    C: Array  # (states,)
    D: Array  # (2,)


def steady_losses(loss: Any, p_g: float, speed: float, ripple: Ripple) -> tuple[Any, Array]:
    """Return the state of losses in steady sliding, at the start of a period of the ripple, and their torques in it.

    Args:
        loss: parameters of the losses.
        p_g: mean gauge pressure, Pa.
        speed: mean velocity, with a sign, rad/s.
        ripple: deviations from both over a period.

    Returns:
        The state, and the torque in each step, N m, (steps,).
    """
    state, turn = at_rest(loss), np.copysign(SLID_ROTATION / SLID_TURNS, speed)
    for _ in range(SLID_TURNS):
        state = turned(loss, state, float(turn), p_g, float(turn / speed))
    for _ in range(SETTLING_PERIODS):
        state, torques_in_steps = slide_a_period(loss, state, p_g, speed, ripple)
    return state, torques_in_steps


def slide_a_period(loss: Any, state: Any, p_g: float, speed: float, ripple: Ripple) -> tuple[Any, Array]:
    """Return the state of losses after a period of a ripple, and their torques in its steps, N m, (steps,).

    Args:
        loss: parameters of the losses.
        state: at the start of the period.
        p_g: mean gauge pressure, Pa.
        speed: mean velocity, rad/s.
        ripple: deviations from both over the period.
    """
    torques_in_steps = []
    for v, p in zip((speed + ripple.velocity).tolist(), (p_g + ripple.pressure).tolist(), strict=True):
        state = turned(loss, state, v * ripple.step, p, ripple.step)
        torques_in_steps.append(sum(torques(loss, state)))
    return state, np.array(torques_in_steps)


def linearize_losses(loss: Any, p_g: float, speed: float, ripple: Ripple) -> LinearLosses:
    """Return the small-signal model of the losses of a hose in steady sliding.

    Args:
        loss: parameters of the losses.
        p_g: mean gauge pressure, Pa.
        speed: mean velocity, with a sign, rad/s.
        ripple: deviations from both over a period.
    """
    state, torques_in_steps = steady_losses(loss, p_g, speed, ripple)
    A, B, C, D = _linearize_steps(loss, state, p_g, speed, ripple)
    forgets = (np.diagonal(A, axis1=1, axis2=2) < FORGOTTEN_FRACTION).any(axis=0)
    slow, fast = np.flatnonzero(~forgets), np.flatnonzero(forgets)
    n, h = len(slow), ripple.step
    # Inputs of the fast states x are the slow ones s, velocity and pressure: w.
    to_fast = np.concatenate([A[:, fast][:, :, slow], B[:, fast]], axis=2)
    x, late = _follow(A[:, fast][:, :, fast], to_fast, h)
    C_x, inverse = C[:, np.newaxis, fast], np.linalg.inv(np.eye(n) + A[:, slow][:, :, slow])
    # With s at the middle of a step, (s_k + s_k+1) / 2, its change in the step is that of a continuous state.
    driven = A[:, slow][:, :, fast] @ x + np.concatenate([np.zeros((len(B), n, n)), B[:, slow]], axis=2)
    C_s = C[:, np.newaxis, slow] @ inverse
    change = (2.0 / h) * (inverse @ driven).mean(axis=0)
    output = (C_x @ x - C_s @ driven).mean(axis=0)[0]
    change[:, :n] += (2.0 / h) * (np.eye(n) - 2.0 * inverse.mean(axis=0))
    output += np.concatenate([2.0 * C_s.mean(axis=0)[0], D.mean(axis=0)])
    model = LinearLosses(state, float(torques_in_steps.mean()), change[:, :n], change[:, n:], output[:n], output[n:])
    return _with_lag(model, *((C_x @ part).mean(axis=0)[0, n] for part in (x, late)))


def _linearize_steps(
    loss: Any, state: Any, p_g: float, speed: float, ripple: Ripple
) -> tuple[Array, Array, Array, Array]:
    """Return A, B, C and D of every step of a period, from a state, velocity and pressure to the next and the torque.

    Args:
        loss: parameters of the losses.
        state: at the start of the period.
        p_g: mean gauge pressure, Pa.
        speed: mean velocity, rad/s.
        ripple: deviations from both over the period.
    """

    def step(numbers: Array) -> Array:
        *before, v, p = numbers.tolist()
        after = turned(loss, read_numbers(state, before), v * ripple.step, p, ripple.step)
        return np.array([*leaves(after), sum(torques(loss, after))])

    numbers, steps = np.array(list(leaves(state))), []
    for v, p in zip(speed + ripple.velocity, p_g + ripple.pressure, strict=True):
        changes = np.maximum(RELATIVE_CHANGE * np.abs(numbers), TORQUE_CHANGE)
        point = np.array([*numbers, v, p])
        steps.append(jacobian(step, point, [*changes, 1e-3 * abs(speed), RELATIVE_CHANGE * max(p_g, 1.0)]))
        numbers = step(point)[:-1]
    every, n = np.array(steps), len(numbers)
    return every[:, :n, :n], every[:, :n, n:], every[:, n, :n], every[:, n, n:]


def _follow(A: Array, B: Array, h: float) -> tuple[Array, Array]:
    """Return the answer of states to constant inputs, and how it lags: that to w = t is `answer t - lag`.

    Args:
        A: from states to the next ones, in every step of a period, (steps, states, states).
        B: from inputs to the next states, (steps, states, inputs).
        h: step, s.

    Returns:
        Answer and lag (s times its unit) at the start of every step of the period, (steps, states, inputs) each.
    """
    constant, rising, answers = np.zeros(B.shape[1:]), np.zeros(B.shape[1:]), []
    for k in range(-FOLLOWED_PERIODS * len(A), len(A)):
        if k >= 0:
            answers.append((constant, constant * (h * k) - rising))
        constant, rising = A[k % len(A)] @ constant + B[k % len(A)], A[k % len(A)] @ rising + B[k % len(A)] * (h * k)
    answer, lag = np.array(answers).swapaxes(0, 1)
    return answer, lag


def _with_lag(losses: LinearLosses, drag: float, late: float) -> LinearLosses:
    """Return losses of which a part follows the velocity with a lag of first order.

    Args:
        losses: losses that follow at once.
        drag: torque by velocity that lags, N m s/rad.
        late: the same times the lag, N m s2/rad.
    """
    if drag <= 0.0 or late < MIN_LAG * drag:
        return losses
    n, rate = len(losses.A), drag / late
    A, B = np.zeros((n + 1, n + 1)), np.vstack([losses.B, [rate, 0.0]])
    A[:n, :n], A[n, n] = losses.A, -rate
    return losses._replace(A=A, B=B, C=np.append(losses.C, drag), D=losses.D - [drag, 0.0])
