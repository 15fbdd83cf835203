"""Small-signal model of the losses of a hose whose joint slides: hysteresis, creep, or any kind of them.

| symbol | meaning | unit |
|---|---|---|
| s | numbers of the state of the losses | |
| v, p_g | velocity of the joint, gauge pressure in the hose, means over a period of the valve's wave | rad/s, Pa |
| f | torque against the motion, mean as well | N m |

ds/dt = A s + B (v, p_g), f = C s + D (v, p_g), all as deviations. The law itself, `turned`, is differentiated over a
period of steady sliding, and its change is divided by the period. A state that forgets its past in a period, as an
element that slips, follows pressure and velocity at once: it is eliminated, and its part of f is in D.

The ripple of pressure and velocity matters: an element slips at a torque that follows the pressure, and where that
rises faster than the element is loaded by the rotation, it sticks for a part of the period. Then its mean torque grows
with the velocity, which damps a slow motion.
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
FORGOTTEN_FRACTION = 0.5  # fraction of a state that is left after a period, below which it follows at once


class Ripple(NamedTuple):
    """Deviations of velocity and pressure from their means over a period of the valve's wave, in each step."""

    step: float  # s
    velocity: Array  # (steps,), rad/s
    pressure: Array  # (steps,), Pa


class LinearLosses(NamedTuple):
    """Losses of a hose near a steady sliding (symbols as in the module's table)."""

    state: Any  # in the steady sliding, of the law
    torque: float  # f there, N m
    A: Array  # (states, states)
    B: Array  # (states, 2)
    C: Array  # (states,)
    D: Array  # (2,)


def steady_losses(loss: Any, p_g: float, speed: float, ripple: Ripple) -> tuple[Any, float]:
    """Return the state of losses in steady sliding, at the start of a period of the ripple, and their mean torque, N m.

    Args:
        loss: parameters of the losses.
        p_g: mean gauge pressure, Pa.
        speed: mean velocity, with a sign, rad/s.
        ripple: deviations from both over a period.
    """
    state, turn = at_rest(loss), np.copysign(SLID_ROTATION / SLID_TURNS, speed)
    for _ in range(SLID_TURNS):
        state = turned(loss, state, float(turn), p_g, float(turn / speed))
    for _ in range(SETTLING_PERIODS):
        state, torque = slide_a_period(loss, state, p_g, speed, ripple)
    return state, torque


def slide_a_period(loss: Any, state: Any, p_g: float, speed: float, ripple: Ripple) -> tuple[Any, float]:
    """Return the state of losses after a period of a ripple, and their mean torque in it, N m.

    Args:
        loss: parameters of the losses.
        state: at the start of the period.
        p_g: mean gauge pressure, Pa.
        speed: mean velocity, rad/s.
        ripple: deviations from both over the period.
    """
    torque = 0.0
    for v, p in zip((speed + ripple.velocity).tolist(), (p_g + ripple.pressure).tolist(), strict=True):
        state = turned(loss, state, v * ripple.step, p, ripple.step)
        torque += sum(torques(loss, state))
    return state, torque / len(ripple.velocity)


def linearize_losses(loss: Any, p_g: float, speed: float, ripple: Ripple) -> LinearLosses:
    """Return the small-signal model of the losses of a hose in steady sliding.

    Args:
        loss: parameters of the losses.
        p_g: mean gauge pressure, Pa.
        speed: mean velocity, with a sign, rad/s.
        ripple: deviations from both over a period.
    """
    steady, mean = steady_losses(loss, p_g, speed, ripple)
    state = np.array(list(leaves(steady)))

    def slide_from(numbers: Array) -> Array:
        *given, v, p = numbers.tolist()
        ended, torque = slide_a_period(loss, read_numbers(steady, given), p, v, ripple)
        return np.array([*leaves(ended), torque])

    changes = np.maximum(RELATIVE_CHANGE * np.abs(state), TORQUE_CHANGE)
    point = np.array([*state, speed, p_g])
    derivatives = jacobian(slide_from, point, [*changes, 1e-3 * abs(speed), RELATIVE_CHANGE * max(p_g, 1.0)])
    n, period = len(state), len(ripple.velocity) * ripple.step
    (A, B), (C, D) = np.split(derivatives[:-1], [n], axis=1), np.split(derivatives[-1], [n])
    fast = np.diag(A) < FORGOTTEN_FRACTION
    slow, across = ~fast, A[np.ix_(~fast, fast)]
    # s_F = A_FF s_F + A_FS s_S + B_F w: what the fast states are while the slow ones and the inputs change slowly.
    kept = np.linalg.inv(np.eye(int(fast.sum())) - A[np.ix_(fast, fast)])
    by_slow, by_input = kept @ A[np.ix_(fast, slow)], kept @ B[fast]
    rate = (A[np.ix_(slow, slow)] + across @ by_slow - np.eye(int(slow.sum()))) / period
    gain = (B[slow] + across @ by_input) / period
    return LinearLosses(steady, mean, rate, gain, C[slow] + C[fast] @ by_slow, D + C[fast] @ by_input)
