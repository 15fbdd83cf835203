from math import inf, nan, radians
from typing import Any

import numpy as np
import pytest
import xarray

from layflat.tune.cost import candidate_costs, move_costs


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


def test_the_worst_counts_twice_and_candidates_are_apart() -> None:
    settling = np.full((80, 1, 1), 0.4)
    settling[3] = 1.4
    both = xarray.Dataset(
        {
            "settling": (("run", "move", "joint"), settling),
            **{
                name: (("run", "move", "joint"), np.zeros((80, 1, 1)))
                for name in ("overshoot", "steady_error", "ripple")
            },
        }
    )
    bad, good = candidate_costs(both, 1.7, 2)
    assert good == pytest.approx(0.4 + 0.5 * 0.4)
    assert bad == pytest.approx((39 * 0.4 + 1.4) / 40 + 0.5 * (1.4 + 0.4) / 2)
