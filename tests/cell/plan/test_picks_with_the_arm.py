import numpy as np

from layflat.cell.plan.pick import PickOutcome, PickTask
from layflat.machine import load
from tests.cell.plan.pick_bench import Bench


def test_the_papers_arm_places_fruit_within_its_tolerance() -> None:
    bench = Bench(load("paper-arm-fast"), np.zeros(2))
    tasks = [
        PickTask((0.5, 0.2), (-0.3, -0.3), 0.06, 0.055, 0.05, 0.15, 0.15),
        PickTask((0.4, -0.4), (-0.4, 0.3), 0.06, 0.055, 0.05, 0.15, 0.15),
    ]
    for task in tasks:
        picked = bench.pick(task)
        assert picked.state.outcome is PickOutcome.PLACED
        assert picked.state.tried == 1
        assert picked.error < 3e-3
        assert picked.time < 5.0
