"""What a cloud says of each value."""

import numpy as np
import pytest

from research.cloud.open import GROUPS, built_in_shares
from research.cloud.pinned import draw, effective, pinned, table


def test_what_is_pinned_down_covers_little_of_its_range() -> None:
    rng = np.random.default_rng(0)
    shares = rng.random((400, len(built_in_shares())))
    shares[:, 0] = 0.3 + 0.01 * rng.standard_normal(400)
    shares[:, 2] = 1.0 - shares[:, 1]
    shares[1::2, 5:7] = 0.9 + 0.1 * shares[1::2, 5:7]
    found = pinned(shares, 2)
    assert found[0].covered == pytest.approx(0.01 * 3.29 / 0.9, rel=0.15)
    assert found[1].covered == pytest.approx(1.0, abs=0.08)
    names = [one.name for group in GROUPS for one in group.unknowns]
    assert found[1].trades == f"{names[2]} (-1.0)"
    assert found[5].trades == ""
    lines = table(found).splitlines()
    assert len(lines) == 2 + len(names)
    assert names[0] in lines[2]
    assert len(draw(found).axes[0].get_yticklabels()) == len(names)


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.8])
def test_a_walk_that_remembers_is_worth_less(memory: float) -> None:
    rng = np.random.default_rng(1)
    walks = [rng.standard_normal((50, 3))]
    for _ in range(799):
        walks.append(memory * walks[-1] + np.sqrt(1.0 - memory**2) * rng.standard_normal((50, 3)))
    assert effective(walks) == pytest.approx(50 * 800 * (1.0 - memory) / (1.0 + memory), rel=0.1)
