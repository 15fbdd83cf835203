"""Reward of a step: the closer the tip to its goal, the greater.

It is -(d / L + d / (d + l)), from 0 at the goal down to about -2: the first term leads from afar, the second rewards
the last millimetres.

| symbol | meaning | unit |
|---|---|---|
| d | distance of the tip from the goal at the end of the step | m |
| L, l | `FAR_SCALE`, `NEAR_SCALE` | m |
"""

from layflat.jit import law

FAR_SCALE, NEAR_SCALE = 0.5, 0.01  # m
SUCCESS_DISTANCE = 0.002  # within which the tip is there, m: section 4.2 of the paper


@law
def step_reward(d, far, near):
    """Return the reward at a distance d, with L (far) and l (near), m."""
    return -(d / (d + near) + d / far)
