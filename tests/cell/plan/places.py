"""Equal places in rows and columns."""

from __future__ import annotations

from layflat.cell.plan.order import ContainerPlace


def places(
    container: str, first: tuple[float, float, float], pitch: float, count: tuple[int, int],
    *limits: float, sort: tuple[str, str] = ("tomato", "A"),
) -> tuple[ContainerPlace, ...]:  # fmt: skip
    """Places of a container, row by row along x, from the middle of the first and the height of its floor, m."""
    x, y, z = first
    return tuple(
        ContainerPlace(container, f"{row + 1}-{column + 1}", x + row * pitch, y + column * pitch, z, sort, *limits)
        for row in range(count[0])
        for column in range(count[1])
    )
