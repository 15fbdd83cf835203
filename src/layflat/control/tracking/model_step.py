"""Step of the law's model: short enough for what is light to oscillate on its air.

Steps of more than two radians of an oscillation would make it grow without limit, and so would damping that takes more
than twice a velocity in a step (see docs/derivations.md).
"""

from math import ceil, log2
from typing import Any

from layflat.physics.joint import Joint, Surroundings
from layflat.physics.natural_rates import natural_rates

STEP = 2.5e-3  # longest of the model, s
MAX_PHASE, MAX_DECAY = 1.0, 1.0  # of an oscillation, rad, and of a velocity, in a step: half of what would grow
MAX_DOUBLINGS = 5  # of the number of steps: a model that needed more would take longer than a control cycle


def step_count(arm: Any, joints: tuple[Joint, ...], around: Surroundings, cycle: float) -> int:
    """Return the number of the model's steps in a control cycle (s): as `STEP` needs, or doubled for what is light.

    Args:
        arm: parameters of its kind; as all of these, with arrays where runs differ: the lightest counts.
        joints: parameters, an item a joint.
        around: supply and surroundings.
        cycle: s.
    """
    usual = ceil(cycle / STEP - 1e-9)
    frequency, decay = natural_rates(arm, joints, around)
    over = max(frequency / MAX_PHASE, decay / MAX_DECAY) * cycle / usual
    doublings = min(max(ceil(log2(max(over, 1e-9)) - 1e-9), 0), MAX_DOUBLINGS)
    return usual << doublings
