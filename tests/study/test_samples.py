from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.arrays import Array
from layflat.study.description import StudyFile, VariedQuantity
from layflat.study.sampling import draw_samples, study_rows
from layflat.study.varied import StudyAxis

NUMBER = VariedQuantity(float)


def a_file(sampling: str, runs: int | None = None, seed: int = 0) -> StudyFile:
    plain: dict[str, object] = {
        "name": "x",
        "machine": "x",
        "sampling": sampling,
        "runs": runs,
        "seed": seed,
        "scenario": {},
    }
    return StudyFile.model_validate(plain)


@given(
    st.sampled_from(["sobol", "lhs"]), st.integers(0, 7), st.integers(0, 99), st.floats(-1e3, 1e3), st.floats(1e-3, 1e3)
)
def test_samples_lie_in_range_and_come_again(sampling: str, power: int, seed: int, low: float, span: float) -> None:
    varied = [
        StudyAxis("even", NUMBER, low, low + span),
        StudyAxis("log", NUMBER, span, 50.0 * span, log=True),
        StudyAxis("normal", NUMBER, low - span, low + 2 * span, mean=low, std=span),
        StudyAxis("values", NUMBER, values=(low, low + span)),
    ]
    drawn = draw_samples(varied, a_file(sampling, 1 << power, seed))
    again = draw_samples(varied, a_file(sampling, 1 << power, seed))
    for one in varied:
        values = drawn[one.path]
        assert len(values) == 1 << power
        assert np.array_equal(values, again[one.path])
        if one.values:
            assert set(values) <= set(one.values)
        else:
            assert one.low is not None
            assert one.high is not None
            assert np.all((values >= one.low) & (values <= one.high))


def test_another_seed_gives_other_samples() -> None:
    varied = [StudyAxis("even", NUMBER, 0.0, 1.0)]
    for sampling in ("sobol", "lhs"):
        one, other = (draw_samples(varied, a_file(sampling, 16, seed))["even"] for seed in (1, 2))
        assert not np.array_equal(one, other)


@pytest.mark.parametrize("seed", range(5))
def test_sobol_samples_are_balanced(seed: int) -> None:
    varied = [StudyAxis(name, NUMBER, 0.0, 1.0) for name in "abc"]
    varied.append(StudyAxis("log", NUMBER, 1.0, 16.0, log=True))
    varied.append(StudyAxis("values", NUMBER, values=(1.0, 2.0, 3.0, 4.0)))
    drawn = draw_samples(varied, a_file("sobol", 64, seed))
    for name in "abc":
        assert np.all(np.bincount((64 * drawn[name]).astype(int), minlength=64) == 1)
    # Two at a time, too: 2 and 2 and 4 and 4 cells hold equally many.
    for a, b in ("ab", "bc", "ac"):
        for cells in (2, 4):
            cell = cells * (cells * drawn[a]).astype(int) + (cells * drawn[b]).astype(int)
            assert np.all(np.bincount(cell, minlength=cells**2) == 64 // cells**2)
    assert np.all(np.bincount(np.log2(drawn["log"]).astype(int), minlength=4) == 16)
    assert np.all(np.bincount(drawn["values"].astype(int), minlength=5)[1:] == 16)


@given(st.integers(1, 50), st.integers(0, 9))
def test_a_latin_hypercube_has_one_sample_in_every_row(runs: int, seed: int) -> None:
    drawn = draw_samples(
        [StudyAxis("a", NUMBER, 0.0, 1.0), StudyAxis("b", NUMBER, 0.0, 1.0)], a_file("lhs", runs, seed)
    )
    for values in drawn.values():
        assert sorted((runs * values).astype(int)) == list(range(runs))


def test_a_normal_distribution_has_its_mean_and_deviation() -> None:
    drawn = draw_samples([StudyAxis("a", NUMBER, mean=5.0, std=2.0)], a_file("sobol", 4096))["a"]
    assert drawn.mean() == pytest.approx(5.0, abs=0.02)
    assert drawn.std() == pytest.approx(2.0, rel=0.02)


@given(st.integers(2, 5), st.integers(2, 5))
def test_a_grid_is_complete(points: int, more: int) -> None:
    varied = [
        StudyAxis("a", NUMBER, -1.0, 1.0, points),
        StudyAxis("b", NUMBER, 1.0, 100.0, more, log=True),
        StudyAxis("c", NUMBER, values=(7.0, 3.0)),
    ]
    drawn = draw_samples(varied, a_file("grid"))
    found = list(zip(drawn["a"], drawn["b"], drawn["c"], strict=True))
    expected = product(np.linspace(-1, 1, points), np.geomspace(1, 100, more), (7.0, 3.0))
    assert np.allclose(found, list(expected))


@given(st.integers(1, 5), st.integers(1, 3), st.integers(1, 3), st.integers(1, 20))
def test_rows_are_the_same_in_any_pieces(count: int, scenarios: int, noise_seeds: int, piece: int) -> None:
    drawn: dict[str, Array] = {"a": np.linspace(0.5, count - 0.5, count)}
    seeds = [100 * i for i in range(scenarios)]
    total = count * scenarios * noise_seeds
    whole = study_rows(drawn, count, 1, seeds, noise_seeds, 0, total)
    expected = list(product(range(count), range(scenarios), range(noise_seeds)))
    assert list(whole["sample"]) == [sample for sample, _, _ in expected]
    assert list(whole["a"]) == [sample + 0.5 for sample, _, _ in expected]
    assert list(whole["scenario"]) == [scenario for _, scenario, _ in expected]
    assert list(whole["seed"]) == [100 * scenario + noise for _, scenario, noise in expected]
    pieces = [study_rows(drawn, count, 1, seeds, noise_seeds, i, min(i + piece, total)) for i in range(0, total, piece)]
    for key, values in whole.items():
        assert np.array_equal(values, np.concatenate([part[key] for part in pieces]))
