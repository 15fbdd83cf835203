from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.study.description import StudyFile, VariedQuantity
from layflat.study.sampling import draw_samples, saltelli_points, sobol_indices
from layflat.study.varied import StudyAxis

A, B = 7.0, 0.1


def ishigami_variances() -> tuple[float, float, float, float]:
    """The whole variance of Ishigami's function and what of it goes with x1, with x2, and with x1 and x3 together."""
    first = 0.5 * (1.0 + B * pi**4 / 5.0) ** 2
    second = A**2 / 8.0
    both = B**2 * pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    return first + second + both, first, second, both


def test_indices_of_a_function_that_has_known_ones() -> None:
    whole, one, two, both = ishigami_variances()
    file = StudyFile.model_validate({"name": "x", "machine": "x", "sampling": "saltelli", "runs": 2048, "scenario": {}})
    kind = VariedQuantity(float)
    varied = [
        StudyAxis("a", kind, -pi, pi, group="odd"),
        StudyAxis("b", kind, -pi, pi),
        StudyAxis("c", kind, -pi, pi, group="odd"),
    ]
    drawn = draw_samples(varied, file)
    values = np.sin(drawn["a"]) + A * np.sin(drawn["b"]) ** 2 + B * drawn["c"] ** 4 * np.sin(drawn["a"])
    found = sobol_indices(values, 4)
    assert found.first == pytest.approx([one / whole, two / whole, 0.0, (one + both) / whole], abs=0.03)
    total = [(one + both) / whole, two / whole, both / whole, (one + both) / whole]
    assert found.total == pytest.approx(total, abs=0.03)
    for ends, true in ((found.first_ends, [one / whole, two / whole, 0.0]), (found.total_ends, total[:3])):
        assert np.all(ends[0, :3] - 0.02 <= true)
        assert np.all(true <= ends[1, :3] + 0.02)
        assert np.all(ends[1] - ends[0] < 0.2)


def test_what_nothing_changes_depends_on_nothing() -> None:
    found = sobol_indices(np.full(5 * 8, 3.0), 3)
    assert not found.total.any()
    assert not found.first_ends.any()


@given(st.integers(1, 5), st.integers(0, 5), st.integers(0, 9), st.data())
def test_a_block_is_a_with_its_columns_from_b(dimensions: int, power: int, seed: int, data: st.DataObject) -> None:
    group = data.draw(st.sets(st.integers(0, dimensions - 1), min_size=1))
    points = saltelli_points(dimensions, 1 << power, seed, [sorted(group)])
    blocks = points.reshape(dimensions + 3, 1 << power, dimensions)
    a, b = blocks[:2]
    for i, taken in enumerate([*({i} for i in range(dimensions)), group]):
        for column in range(dimensions):
            assert np.array_equal(blocks[2 + i][:, column], (b if column in taken else a)[:, column])
    # Both halves are balanced in every dimension.
    for half in (a, b):
        for column in half.T:
            assert np.all(np.bincount((len(half) * column).astype(int), minlength=len(half)) == 1)
