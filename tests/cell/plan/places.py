"""Equal places in rows and columns."""

from __future__ import annotations

from layflat.cell.plan.containers import Acceptance, Place


def places(
    container: str, first: tuple[float, float, float], pitch: float, count: tuple[int, int], accepts: Acceptance
) -> tuple[Place, ...]:
    """Places of a container, row by row along x, from the middle of the first and the height of its floor, m."""
    x, y, z = first
    return tuple(
        Place(container, f"{row + 1}-{column + 1}", x + row * pitch, y + column * pitch, z, accepts)
        for row in range(count[0])
        for column in range(count[1])
    )
