from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from layflat.cell.file.produce import Skin
from layflat.cell.kinds import SkinRegion, divide_overlap

channels = st.floats(0.05, 0.95)
skins = st.builds(
    lambda red, green, blue, spread: Skin(rgb=(red, green, blue), std=spread, fraction=1.0),
    channels, channels, channels, st.floats(0.01, 0.1),
)  # fmt: skip


def held(region: SkinRegion, hue: float, saturation: float) -> int:
    """How many of its parts hold a colour."""
    return sum(
        low <= saturation < high and 0.0 <= (hue - start) % 360.0 < end - start
        for start, end, low, high in region.parts
    )


@given(skins, skins)
def test_what_two_skins_share_is_divided_without_loss(one: Skin, other: Skin) -> None:
    before, after = (
        [SkinRegion.from_skin(one), SkinRegion.from_skin(other)],
        [SkinRegion.from_skin(one), SkinRegion.from_skin(other)],
    )
    divide_overlap(*after)
    rng = np.random.default_rng(0)
    start, end, low, high = before[0].parts[0]
    for hue, saturation in zip(rng.uniform(start, end, 40), rng.uniform(low, high, 40), strict=True):
        was = [held(region, hue, saturation) for region in before]
        now = [held(region, hue, saturation) for region in after]
        assert sum(now) == (1 if sum(was) else 0)
        if sum(was) == 1:
            assert now == was


@given(skins, skins)
def test_what_is_shared_goes_to_the_nearer_skin(one: Skin, other: Skin) -> None:
    first, second = SkinRegion.from_skin(one), SkinRegion.from_skin(other)
    both = (SkinRegion.from_skin(one), SkinRegion.from_skin(other))
    divide_overlap(first, second)
    turn = 360.0 * round((first.midpoint[0] - second.midpoint[0]) / 360.0)
    for start, end, low, high in first.parts:
        hue, saturation = (start + end) / 2, (low + high) / 2
        if held(both[1], hue, saturation) and held(both[0], hue, saturation):
            assert first.distance(hue, saturation) <= second.distance(hue - turn, saturation) + 1e-9
