from __future__ import annotations

import numpy as np
import pytest

from layflat.cell.vision.prepare import normalize_light

TABLE = (143.0, 148.0, 153.0)


@pytest.mark.parametrize("light", [0.6, 1.1])
def test_a_tray_of_nearly_the_tables_colour_tells_nothing_of_the_light(light: float) -> None:
    """A third of the picture is a darker grey, some is white, some is in shadow."""
    x, y = np.meshgrid(np.linspace(-1, 1, 640), np.linspace(-1, 1, 480))
    lit = light * (1.0 + 0.1 * x - 0.08 * y)[..., None] * np.array([1.04, 1.0, 0.97])
    albedo = np.broadcast_to(np.array(TABLE), (480, 640, 3)).copy()
    albedo[200:460, 340:600] = (51.0, 56.0, 66.0)
    albedo[200:460, 320:340] *= 0.6
    albedo[:40, :40] = albedo[:40, -40:] = 240.0
    picture = np.clip(lit * albedo, 0, 255).astype(np.uint8)
    even = normalize_light(picture, TABLE).astype(float)
    on_table = (albedo == TABLE).all(axis=-1)
    assert np.abs(even[on_table] - TABLE).max() < 5.0
    assert even[220:440, 360:580].mean(axis=(0, 1)) == pytest.approx((51.0, 56.0, 66.0), abs=3.0)
