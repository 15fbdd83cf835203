"""Statistics of features against NumPy's over all values at once."""

from typing import Any

import numpy as np
import pytest

from layflat.lerobot.statistics import (
    QUANTILE_SHARES,
    PictureStatistics,
    combine_statistics,
    flatten_statistics,
    vector_statistics,
)

RANDOM = np.random.default_rng(5)
MEASURES: dict[str, Any] = {"min": np.min, "max": np.max, "mean": np.mean, "std": np.std}


def test_a_vector_has_those_of_its_components() -> None:
    values = (1e5 * RANDOM.normal(3.0, 0.2, (300, 4))).astype(np.float32)
    found = vector_statistics(values)
    exact = values.astype(np.float64)
    for name, of in MEASURES.items():
        np.testing.assert_allclose(found[name], of(exact, axis=0), rtol=1e-14)
    for name, share in QUANTILE_SHARES.items():
        np.testing.assert_allclose(found[name], np.quantile(exact, share, axis=0), rtol=1e-14)
    assert found["count"].tolist() == [300]


def test_numbers_without_components_are_one() -> None:
    assert {name: values.shape for name, values in vector_statistics(np.arange(5)).items()} == dict.fromkeys(
        ("min", "max", "mean", "std", "count", *QUANTILE_SHARES), (1,)
    )


def test_a_single_frame_does_not_spread() -> None:
    found = vector_statistics(np.array([[2.0, 3.0]]))
    assert found["std"].tolist() == [0.0, 0.0]
    assert found["q01"].tolist() == found["q99"].tolist() == [2.0, 3.0]


def test_pictures_have_those_of_all_their_pixels_from_0_to_1() -> None:
    pictures = RANDOM.integers(20, 201, (7, 12, 16, 3)).astype(np.uint8)
    collected = PictureStatistics()
    for picture in pictures:
        collected.add(picture)
    found = collected.result()
    pixels = pictures.reshape(-1, 3) / 255.0
    for name, of in MEASURES.items():
        assert found[name].shape == (3, 1, 1)
        np.testing.assert_allclose(found[name].ravel(), of(pixels, axis=0), rtol=1e-12)
    for name, share in QUANTILE_SHARES.items():
        expected = np.quantile(pixels, share, axis=0, method="inverted_cdf")
        np.testing.assert_allclose(found[name].ravel(), expected, rtol=1e-12)
    assert found["count"].tolist() == [7]


def test_parts_combine_to_those_of_the_whole() -> None:
    parts = [RANDOM.normal(k, 1.0 + k, (50 + 30 * k, 3)) for k in range(4)]
    found = combine_statistics([vector_statistics(part) for part in parts])
    whole = vector_statistics(np.concatenate(parts))
    for name in ("min", "max", "mean", "std", "count"):
        np.testing.assert_allclose(found[name], whole[name], rtol=1e-12)
    weights = [len(part) for part in parts]
    medians = np.average([np.median(part, axis=0) for part in parts], axis=0, weights=weights)
    np.testing.assert_allclose(found["q50"], medians, rtol=1e-12)


def test_columns_of_the_table_are_named_by_feature_and_statistic() -> None:
    flat = flatten_statistics({"action": vector_statistics(np.ones((3, 2)))})
    assert flat["stats/action/mean"] == [1.0, 1.0]
    assert flat["stats/action/count"] == [3]
    assert all(key.startswith("stats/action/") for key in flat)
    assert len(flat) == 10


@pytest.mark.parametrize("count", [1, 3])
def test_equal_parts_change_nothing_but_the_count(count: int) -> None:
    part = vector_statistics(RANDOM.normal(size=(40, 2)))
    found = combine_statistics([part] * count)
    for name, values in part.items():
        factor = count if name == "count" else 1
        np.testing.assert_allclose(found[name], factor * values, rtol=1e-12)
