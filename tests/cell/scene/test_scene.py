from __future__ import annotations

import numpy as np
import pytest

from layflat.cell import Cell
from layflat.cell.scene import Scene
from layflat.errors import CellError
from tests.cell.scene.arms import Hand, mujoco, top


def crowded(cell: Cell, least: int, most: int, touching: float = 0.35) -> Cell:
    tray = cell.tray["infeed"]
    count = tray.count.model_copy(update={"min": least, "max": most})
    return cell.model_copy(
        update={"tray": {"infeed": tray.model_copy(update={"count": count, "touching_fraction": touching})}}
    )


@pytest.fixture(scope="module")
def scene(packing: Cell) -> Scene:
    return Scene(packing, 0)


def test_same_seed_same_scene_and_other_seed_another(packing: Cell) -> None:
    one, again, other = (Scene(packing, seed) for seed in (3, 3, 4))
    for scene in (one, again, other):
        scene.step(50)
    assert np.array_equal(one.data.qpos, again.data.qpos)
    assert np.array_equal(one.model.light_diffuse, again.model.light_diffuse)
    assert not np.array_equal(one.model.light_diffuse, other.model.light_diffuse)
    assert one.fruits != other.fruits


@pytest.mark.parametrize("seed", range(4))
def test_fruit_rests_in_its_tray_without_lying_in_one_another(packing: Cell, seed: int) -> None:
    scene = Scene(packing, seed)
    before = scene.truth().fruits
    scene.step(300)
    after = scene.truth()
    tray = packing.tray["infeed"]
    for name, fruit in after.fruits.items():
        assert np.linalg.norm(fruit.position - before[name].position) < 1e-3
        assert (np.abs(fruit.position[:2] - np.array(tray.centre)) < np.array(tray.size) / 2).all()
        assert packing.produce[fruit.kind].diameter.min <= fruit.diameter
        assert fruit.place is None
        assert fruit.peak_acceleration < 5.0
    assert after.collisions == ()
    assert scene.data.contact.dist.min(initial=0.0) > -2e-3


def test_touching_fruit_touches(packing: Cell) -> None:
    def touching(share: float) -> int:
        fruits = Scene(crowded(packing, 8, 8, share), 1).truth().fruits.values()
        spots = np.array([fruit.position[:2] for fruit in fruits])
        radii = np.array([fruit.diameter / 2 for fruit in fruits])
        gaps = np.hypot(*(spots[:, None] - spots[None]).T) - radii[:, None] - radii[None]
        return int((gaps[np.triu_indices(len(radii), 1)] < 3e-3).sum())

    assert touching(1.0) >= 5
    assert touching(0.0) <= 2


def test_an_empty_tray_is_a_scene(packing: Cell) -> None:
    scene = Scene(crowded(packing, 0, 0), 0)
    scene.step(10)
    assert scene.truth().fruits == {}


def test_a_tray_without_room_is_told(packing: Cell) -> None:
    with pytest.raises(CellError, match=r"packing: tray\.infeed: has no room for 60 fruit"):
        Scene(crowded(packing, 60, 60), 0)


def test_the_tip_stands_where_the_arm_says(scene: Scene, packing: Cell) -> None:
    q_1, q_2 = packing.mount.home.values()
    at = 0.4 * np.exp(1j * q_1) * (1 + np.exp(1j * (q_2 + np.pi / 2)))
    assert scene.truth().tip == pytest.approx([at.real, at.imag, packing.lift.clearance], abs=1e-6)


def test_the_arm_weighs_what_the_machine_says(scene: Scene, packing: Cell) -> None:
    from layflat.machine import parameters
    from layflat.physics.arms.planar import two_link_mass

    dofs = [int(scene.model.joint(name).dofadr[0]) for name in packing.machine.joints]
    elbow = packing.mount.home["small"] + packing.machine.arm.elbow
    M = np.zeros((scene.model.nv, scene.model.nv))
    mujoco.mj_fullM(scene.model, scene.data, M)
    arm = parameters.arm(packing.machine)
    expected = two_link_mass(arm, packing.lift.body + packing.lift.mass, np.sin(elbow), np.cos(elbow))[:3]
    found = M[np.ix_(dofs, dofs)]
    assert [found[0, 0], found[0, 1], found[1, 1]] == pytest.approx(list(expected), abs=1e-5)


@pytest.mark.parametrize("kind", ["tomato", "mushroom", "apple"])
def test_a_fruit_is_picked_carried_and_laid_into_a_pack(packing: Cell, kind: str) -> None:
    scene = Scene(packing, 0)
    hand = Hand(scene)
    fruit = next(fruit for fruit in scene.truth().fruits.values() if fruit.kind == kind)
    hand.pick(fruit)
    held = scene.truth().fruits[fruit.name]
    assert held.gripped
    assert scene._grip._pull == pytest.approx(9.81 * fruit.mass, rel=1e-3)
    assert held.position[2] > fruit.position[2] + 0.05
    name, pack = next((name, pack) for name, pack in packing.container.items() if pack.kind == kind)
    x, y = map(float, pack.places[2])
    hand.go(x, y)
    rise = pack.layout.wall - packing.tray["infeed"].wall + 5e-3
    scene.lift.demand = packing.lift.clearance - top(fruit) - rise
    hand.wait(450)
    scene.cup.on = False
    hand.wait(250)
    laid = scene.truth()
    assert laid.fruits[fruit.name].place == (name, 2)
    assert not laid.fruits[fruit.name].gripped
    assert laid.fruits[fruit.name].peak_acceleration < packing.limits.acceleration
    assert laid.fruits[fruit.name].press < packing.limits.contact_force
    assert laid.collisions == ()
    assert scene.cup.air > 0.0


def test_a_fruit_far_from_the_cups_axis_is_not_sealed(packing: Cell) -> None:
    scene = Scene(crowded(packing, 1, 1), 2)
    (fruit,) = scene.truth().fruits.values()
    Hand(scene).pick(fruit, aside=(0.35 * fruit.diameter, 0.0))
    assert not scene.truth().fruits[fruit.name].gripped


def test_a_fruit_falls_when_the_vacuum_goes_and_the_fall_is_felt(packing: Cell) -> None:
    scene = Scene(crowded(packing, 1, 1), 2)
    hand = Hand(scene)
    (fruit,) = scene.truth().fruits.values()
    hand.pick(fruit)
    hand.wait(300)
    high = scene.truth().fruits[fruit.name]
    assert high.gripped
    scene.cup.on = False
    hand.wait(100)
    falling = scene.truth().fruits[fruit.name]
    assert not falling.gripped
    assert falling.acceleration == pytest.approx(9.81, rel=0.02)
    hand.wait(500)
    fallen = scene.truth().fruits[fruit.name]
    assert fallen.position[2] < high.position[2] - 0.05
    assert fallen.peak_acceleration > 3 * high.peak_acceleration


def test_too_little_vacuum_lifts_nothing(packing: Cell) -> None:
    weak = packing.model_copy(update={"cup": packing.cup.model_copy(update={"vacuum": 500.0})})
    scene = Scene(crowded(weak, 1, 1), 2)
    (fruit,) = scene.truth().fruits.values()
    Hand(scene).pick(fruit)
    assert not scene.truth().fruits[fruit.name].gripped
    assert scene.truth().fruits[fruit.name].position[2] == pytest.approx(fruit.position[2], abs=5e-3)


def test_a_cup_that_strikes_a_wall_is_a_collision(packing: Cell) -> None:
    scene = Scene(crowded(packing, 0, 0), 0)
    hand = Hand(scene)
    tray = packing.tray["infeed"]
    hand.go(tray.centre[0] - tray.size[0] / 2, tray.centre[1])
    scene.lift.demand = packing.lift.stroke
    hand.wait(400)
    found = scene.truth().collisions
    assert found
    assert found[0].part == "cup"
    assert found[0].other.startswith("tray.infeed.wall")
