from math import inf, nan, radians
from typing import Any

import numpy as np
import pytest
import xarray

from layflat.tune.conditions import Conditions, candidate_costs, move_costs


def runs(**metrics: Any) -> xarray.Dataset:
    usual = {"settling": 0.5, "overshoot": 0.0, "steady_error": 0.0, "ripple": 0.0}
    return xarray.Dataset(
        {name: (("run", "move", "joint"), np.array([[[value]]])) for name, value in {**usual, **metrics}.items()}
    )


@pytest.mark.parametrize(
    ("metrics", "cost"),
    [
        ({}, 0.5),
        ({"overshoot": radians(3.0)}, 0.6),
        ({"settling": inf}, 2.0),
        ({"settling": inf, "ripple": radians(0.6)}, 2.2),
        ({"settling": inf, "steady_error": radians(-90.0)}, 4.0),
        ({"settling": nan}, 5.0),
    ],
)
def test_what_a_move_costs(metrics: dict[str, float], cost: float) -> None:
    assert move_costs(runs(**metrics), window=1.7).ravel() == pytest.approx([cost])


def candidates(settling: np.ndarray) -> xarray.Dataset:
    others = {name: np.zeros_like(settling) for name in ("overshoot", "steady_error", "ripple")}
    return xarray.Dataset({n: (("run", "move", "joint"), v) for n, v in {"settling": settling, **others}.items()})


def by(runs: int, nominal: int) -> Conditions:
    return Conditions([], {"seed": np.arange(float(runs))}, nominal, 1.7)


def test_the_worst_and_the_nominal_count_more_and_candidates_are_apart() -> None:
    settling = np.full((80, 1, 1), 0.4)
    settling[3] = 1.4
    bad, good = candidate_costs(candidates(settling), by(40, 2), 2)
    assert good == pytest.approx(0.4 + 0.5 * 0.4 + 0.4)
    assert bad == pytest.approx((39 * 0.4 + 1.4) / 40 + 0.5 * (1.4 + 0.4) / 2 + 0.4)


def test_a_slow_move_costs_more_when_nominal_and_faster_never_costs_more() -> None:
    usual = np.full((40, 2, 2), 0.5)
    nominal, other, faster = usual.copy(), usual.copy(), usual.copy()
    nominal[0, 1, 0] = other[20, 1, 0] = 0.9
    faster[7] = 0.2
    costs = candidate_costs(candidates(np.concatenate([usual, nominal, other, faster])), by(40, 4), 4)
    assert costs[1] == pytest.approx(costs[2] + 0.4 / 4)
    assert costs[3] < costs[0] < costs[2]
