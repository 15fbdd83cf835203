from __future__ import annotations

import numpy as np
import pytest

from layflat.cell import Cell
from layflat.cell.geometry import outlines_overlap, rectangle_corners
from layflat.cell.scene import Scene


def cluttered(cell: Cell, count: int) -> Cell:
    """The cell with so many pieces of each sort."""
    most = {"count": next(iter(cell.clutter.values())).count.model_copy(update={"min": count, "max": count})}
    return cell.model_copy(
        update={"clutter": {name: one.model_copy(update=most) for name, one in cell.clutter.items()}}
    )


def pieces(scene: Scene) -> dict[str, int]:
    names = [scene.model.geom(number).name for number in range(scene.model.ngeom)]
    return {name: number for number, name in enumerate(names) if name.startswith("clutter.")}


@pytest.mark.parametrize("seed", range(3))
def test_clutter_lies_in_trays_and_on_the_table_clear_of_all_else(packing: Cell, seed: int) -> None:
    scene = Scene(cluttered(packing, 6), seed)
    tray = packing.tray["infeed"]
    fruits = np.array([[*fruit.position[:2], fruit.diameter / 2] for fruit in scene.fruits])
    in_tray = on_table = 0
    for number in pieces(scene).values():
        spot = scene.data.geom_xpos[number]
        # A piece is nowhere nearer to a fruit than its narrow side, and a stick's is its radius.
        least = 0.0 if scene.model.geom_type[number] == 3 else np.min(scene.model.geom_size[number][:2])
        assert (np.hypot(*(fruits[:, :2] - spot[:2]).T) > fruits[:, 2] + least - 2e-3).all()
        inside = bool((np.abs(spot[:2] - tray.centre) < np.array(tray.size) / 2).all())
        in_tray, on_table = in_tray + inside, on_table + (not inside)
        if not inside:
            speck = rectangle_corners((float(spot[0]), float(spot[1])), 0.0, (1e-3, 1e-3))
            assert not any(outlines_overlap(speck, outline) for outline in packing.outlines.values())
        assert spot[2] < (tray.wall if inside else 0.0) + 5e-3
    assert in_tray >= 2
    assert on_table >= 2


def test_clutter_changes_nothing_but_what_is_seen(packing: Cell) -> None:
    bare, full = (Scene(cluttered(packing, count), 5) for count in (0, 4))
    assert not pieces(bare)
    assert pieces(full)
    for scene in (bare, full):
        scene.step(100)
    assert np.array_equal(bare.data.qpos, full.data.qpos)
    assert np.array_equal(bare.model.light_diffuse, full.model.light_diffuse)


def test_same_seed_same_clutter(packing: Cell) -> None:
    one, again, other = (Scene(cluttered(packing, 3), seed) for seed in (1, 1, 2))
    assert np.array_equal(one.model.geom_pos, again.model.geom_pos)
    assert set(pieces(one)) != set() != set(pieces(other))
