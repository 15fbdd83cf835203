"""Statistics of features as LeRobot keeps them: of each episode, and of all together, by which policies normalise."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array, Picture

Statistics = dict[str, NDArray[Any]]
"""Statistics of a feature by name: min, max, mean, std, count, and the quantiles q01 to q99."""

QUANTILE_SHARES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
PIXEL_LEVELS = 256  # values of a colour in a picture


def vector_statistics(values: NDArray[np.generic]) -> Statistics:
    """Return the statistics of a feature over an episode, (frames, components) or (frames,)."""
    rows: Array = values.reshape(len(values), -1).astype(np.float64)
    quantiles = np.quantile(rows, list(QUANTILE_SHARES.values()), axis=0)
    return {
        "min": rows.min(axis=0),
        "max": rows.max(axis=0),
        "mean": rows.mean(axis=0),
        "std": rows.std(axis=0),
        "count": np.array([len(rows)]),
        **dict(zip(QUANTILE_SHARES, quantiles, strict=True)),
    }


class PictureStatistics:
    """Statistics of a camera over an episode, of all pixels of all pictures, by their histograms."""

    def __init__(self) -> None:
        self._counts = np.zeros((3, PIXEL_LEVELS), dtype=np.int64)
        self._pictures = 0

    def add(self, picture: Picture) -> None:
        """Add a picture, (H, W, 3) RGB."""
        for colour in range(3):
            self._counts[colour] += np.bincount(picture[:, :, colour].ravel(), minlength=PIXEL_LEVELS)
        self._pictures += 1

    def result(self) -> Statistics:
        """Return the statistics by colour, (3, 1, 1), of values from 0 to 1; `count` is the number of pictures."""
        levels, counts = np.arange(PIXEL_LEVELS) / (PIXEL_LEVELS - 1), self._counts
        shares = counts / counts.sum(axis=1, keepdims=True)
        mean = shares @ levels
        summed = counts.cumsum(axis=1)
        by_name = {
            "min": levels[(counts > 0).argmax(axis=1)],
            "max": levels[::-1][(counts[:, ::-1] > 0).argmax(axis=1)],
            "mean": mean,
            "std": np.sqrt((shares * (levels - mean[:, None]) ** 2).sum(axis=1)),
            **{
                name: levels[(summed >= share * summed[:, -1:]).argmax(axis=1)]
                for name, share in QUANTILE_SHARES.items()
            },
        }
        columns: Statistics = {name: values.reshape(3, 1, 1) for name, values in by_name.items()}
        return columns | {"count": np.array([self._pictures])}


def combine_statistics(parts: Sequence[Statistics]) -> Statistics:
    """Return the statistics of several episodes together; quantiles are, as LeRobot's, means weighted by frames."""
    count = np.array([int(part["count"][0]) for part in parts])
    stacked = {name: np.stack([part[name] for part in parts]) for name in parts[0] if name != "count"}

    def average(values: NDArray[Any]) -> Array:
        """Return the mean over episodes, weighted by frames."""
        weighted: Array = np.average(values.astype(np.float64), axis=0, weights=count)
        return weighted

    mean = average(stacked["mean"])
    variance = average(stacked["std"] ** 2 + (stacked["mean"] - mean) ** 2)
    return {
        "min": stacked["min"].min(axis=0),
        "max": stacked["max"].max(axis=0),
        "mean": mean,
        "std": np.sqrt(variance),
        "count": np.array([count.sum()]),
        **{name: average(stacked[name]) for name in QUANTILE_SHARES},
    }


def flatten_statistics(by_feature: Mapping[str, Statistics]) -> dict[str, list[object]]:
    """Return statistics as columns of the table of episodes, such as "stats/action/min"."""
    return {
        f"stats/{feature}/{name}": values.tolist()
        for feature, statistics in by_feature.items()
        for name, values in statistics.items()
    }
