"""Sized arms: what their joints give is what moves ask of them, joints after them included."""

import csv
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from layflat.design import design_joint
from layflat.design.arm import read_task
from layflat.design.arm.sizing import SizedArm, size_arm
from layflat.design.arm.trade_off import SizingTrial, sizes_picture, trade_off, undominated, write_trials
from layflat.errors import DesignError
from layflat.machine import Machine, load
from layflat.motion.dynamics import rigid_torques
from layflat.motion.kinematics import Kinematics, tip_motion, tip_position

LIFT: dict[str, Any] = {"reach": "0.6 m", "joints": 1, "payload": "1 kg", "supply": "6 bar", "time": "1 s"}
TWO = LIFT | {"joints": 2}


def sized(**given: Any) -> SizedArm:
    return size_arm(read_task(None, **given))


@pytest.fixture(scope="module")
def picking() -> SizedArm:
    return size_arm(read_task("picking-arm"))


@pytest.fixture(scope="module")
def two() -> SizedArm:
    return sized(**TWO)


def test_it_gives_what_moves_ask_with_margin(picking: SizedArm) -> None:
    """By the laws of the machine that the text describes."""
    torques = np.abs(rigid_torques(picking.machine, picking.moves.states, 1.0)).max(axis=0)
    gives = [part.torque for part in picking.parts]
    assert (gives >= 1.3 * torques / (1.0 - 0.08)).all()
    assert_allclose(torques, [need.torque for need in picking.needs], rtol=0.02)


def test_its_text_describes_its_machine(picking: SizedArm, tmp_path: Path) -> None:
    found = load(picking.write(tmp_path / "arm.toml"))
    assert found == picking.machine
    notes = {source.note for source in found.provenance.values() if source.source in {"derived", "given"}}
    assert all(notes - {""})
    assert not picking.findings


def test_the_built_in_arm_is_what_its_task_comes_to(picking: SizedArm) -> None:
    """Sizes that are sold are a little above what is needed: all within 15 %."""
    built = load("picking-arm")
    assert list(built.joints) == [part.task.name for part in picking.parts]
    for name, joint in built.joint.items():
        of = picking.machine.joint[name]
        pairs = [
            (joint.hose.width, of.hose.width),
            (joint.cylinder.diameter, of.cylinder.diameter),
            (joint.output.radius, of.output.radius),
            (joint.strap.width, of.strap.width),
            (joint.body.mass, of.body.mass),
            (joint.brake.torque, of.brake.torque),
            (joint.valve_size, of.valve_size),
            (built.arm.link[name].mass, picking.machine.arm.link[name].mass),
        ]
        ours, asked = np.array(pairs).T
        assert_allclose(ours, asked, rtol=0.15, err_msg=name)
        torques = [design_joint(machine, name).mean_torque for machine in (built, picking.machine)]
        assert torques[0] == pytest.approx(torques[1], rel=0.15)
    masses = [built.joint[name].body.mass + built.arm.link[name].mass for name in built.joints]
    assert sum(masses) == pytest.approx(picking.mass, rel=0.15)
    assert built.arm.tool == picking.machine.arm.tool


def test_a_slow_lift_holds_its_load_as_a_lever() -> None:
    lift = sized(**LIFT | {"time": "20 s", "configurations": [["-60 deg"], ["60 deg"]]})
    (part,), (need,) = lift.parts, lift.needs
    lever = 9.81 * 0.6 * (1.0 + part.tube.mass / 2.0)
    assert need.static == pytest.approx(lever, rel=1e-3)
    assert need.torque == pytest.approx(lever, rel=0.02)
    assert part.torque >= 1.3 * lever


@pytest.mark.parametrize(
    "harder", [{"payload": "2 kg"}, {"reach": "0.9 m"}, {"time": "0.6 s"}, {"supply": "4 bar"}, {"margin": 1.8}]
)
def test_what_is_harder_takes_a_heavier_arm(two: SizedArm, harder: dict[str, Any]) -> None:
    assert sized(**TWO | harder).mass > 1.05 * two.mass


def test_joints_carry_those_after_them(tmp_path: Path) -> None:
    """Stretched out and slow, the first joint holds the load, both tubes, and the body of the second joint."""
    path = tmp_path / "stretched.toml"
    link = 'axis = [0, -1, 0]\nlink = ["0.3 m", "0 m", "0 m"]'
    heading = 'name = "stretched"\ntitle = ""\npayload = "1 kg"\nsupply = "6 bar"\ntime = "30 s"\n'
    configurations = 'configurations = [["-60 deg", "0 deg"], ["60 deg", "0 deg"]]\n'
    path.write_text(f'{heading}{configurations}[[joint]]\nname = "a"\n{link}\n[[joint]]\nname = "b"\n{link}\n')
    arm = size_arm(read_task(path))
    first, second = arm.parts
    held = 0.6 + 0.15 * first.tube.mass + 0.45 * second.tube.mass + 0.3 * second.mass
    assert arm.needs[0].static == pytest.approx(9.81 * held, rel=1e-3)
    assert arm.needs[1].static == pytest.approx(9.81 * (0.3 + 0.15 * second.tube.mass), rel=1e-3)


def test_moves_are_from_rest_to_rest(picking: SizedArm) -> None:
    states = picking.moves.states
    q, v, a = (picking.moves.by_move(of) for of in states)
    assert_allclose(q[:, 0], picking.moves.starts)
    assert_allclose(q[:, -1], picking.moves.ends)
    assert_allclose(np.stack([v[:, 0], v[:, -1], a[:, 0], a[:, -1]]), 0.0, atol=1e-12)
    turned = np.abs(picking.moves.ends - picking.moves.starts).max(axis=1)
    assert turned.max() == pytest.approx(radians(60.0))


def test_an_acceleration_is_the_tips() -> None:
    arm = sized(**TWO | {"time": None, "acceleration": "4 m/s^2"})
    _, accelerated = tip_motion(arm.machine, *arm.moves.states)
    greatest = np.linalg.norm(arm.moves.by_move(accelerated), axis=2).max(axis=1)
    assert_allclose(greatest, 4.0)


def test_points_are_gone_to_in_turn() -> None:
    points = [(0.5, 0.1, 0.3), (0.6, -0.2, 0.0), (0.4, 0.0, 0.5)]
    arm = size_arm(read_task("picking-arm", points=[[f"{x} m" for x in point] for point in points]))
    tips = tip_position(arm.machine, arm.moves.ends)
    assert_allclose(tips, [points[1], points[2], points[0]], atol=1e-5)


def test_any_chain_is_sized(tmp_path: Path) -> None:
    """Axes any way: a joint about the load's own line carries it without torque, but has to turn what is beside it."""
    path = tmp_path / "roll.toml"
    path.write_text(
        """
name = "roll"
title = "A lift and a roll"
payload = "1 kg"
supply = "6 bar"
time = "2 s"
rotation = "90 deg"
[[joint]]
name = "lift"
axis = [0, -1, 0]
link = ["0.3 m", "0 m", "0 m"]
[[joint]]
name = "roll"
axis = [3, 0, 0]
stroke = "180 deg"
link = ["0.2 m", "0 m", "0 m"]
""",
        encoding="utf-8",
    )
    arm = size_arm(read_task(path))
    lift, roll = arm.needs
    assert roll.torque < 0.01 * lift.torque
    assert arm.machine.joint["roll"].stops.working_stroke == pytest.approx(np.pi)
    assert_allclose(Kinematics(arm.machine).tip_and_jacobian(np.zeros((1, 2)))[1][0, :, 1], 0.0, atol=1e-12)


@pytest.mark.parametrize(("axis", "middle"), [((1.0, 2.0, 3.0), 40.0), ((0.0, -1.0, 0.0), 90.0)])
def test_axes_and_middles_lie_any_way(tmp_path: Path, axis: tuple[float, ...], middle: float) -> None:
    """In mid-stroke a link is turned about its own axis; axes that cross have no link between them."""
    path = tmp_path / "skew.toml"
    heading = 'name = "skew"\ntitle = ""\npayload = "0.2 kg"\nsupply = "6 bar"\ntime = "1 s"\n'
    tables = [("a", axis, middle, (0.0, 0.0, 0.0)), ("b", (0.0, 1.0, 0.0), -25.0, (0.3, 0.1, -0.2))]
    text = heading
    for name, way, turn, link in tables:
        lengths = ", ".join(f'"{one} m"' for one in link)
        text += f'[[joint]]\nname = "{name}"\naxis = {list(way)}\nmiddle = "{turn} deg"\nlink = [{lengths}]\n'
    path.write_text(text, encoding="utf-8")
    arm = size_arm(read_task(path))
    angles = np.array([[0.0, 0.0], [0.3, -0.2]])
    turned = np.eye(3)[None].repeat(2, axis=0)
    for (_, way, turn, _), angle in zip(tables, angles.T, strict=True):
        unit = np.array(way) / np.linalg.norm(way)
        turned = turned @ Rotation.from_rotvec((radians(turn) + angle)[:, None] * unit).as_matrix()
    assert_allclose(tip_position(arm.machine, angles), turned @ tables[1][3], atol=1e-6)
    first = arm.machine.arm.link["a"]
    assert first.mass == pytest.approx(arm.parts[0].tube.mass, rel=1e-3)
    assert arm.needs[0].static > 0.0


@pytest.mark.parametrize(
    ("harder", "told"),
    [
        ({"payload": "300 kg"}, "task: joint 'shoulder': would have to give at least"),
        ({"time": "0.05 s"}, "task: joint 'shoulder': "),
        ({"reach": "8 m"}, "times what the widest hose gives; ask for less reach, payload or speed, or give more"),
        ({"joints": 1, "supply": "0.5 bar", "payload": "9 kg"}, "task: joint 'lift': would have to give at least"),
        ({"configurations": [["0 deg", "0 deg"]] * 2}, "task: its moves go nowhere; give configurations or points"),
    ],
)
def test_what_no_joint_can_do_names_the_joint(harder: dict[str, Any], told: str) -> None:
    with pytest.raises(DesignError) as caught:
        sized(**TWO | harder)
    assert told in str(caught.value)


def test_a_point_out_of_reach_names_the_nearest() -> None:
    far = [["0.5 m", "0 m", "0.2 m"], ["3 m", "0 m", "0.18 m"]]
    with pytest.raises(DesignError, match="points: the point x = 3000 mm, y = 0 mm, z = 180 mm is 21") as caught:
        size_arm(read_task("picking-arm", points=far))
    nearest = str(caught.value).partition("whose nearest is x = ")[2]
    assert 860 < float(nearest.partition(" mm")[0]) < 900


def test_arms_that_are_heavier_and_slower_are_dominated() -> None:
    trials = [SizingTrial(4e5, time, mass, 0.0) for time, mass in ((1.0, 5.0), (1.2, 5.0), (1.5, 4.0), (0.9, np.inf))]
    assert undominated(trials) == [True, False, True, False]


def test_a_cheaper_arm_is_not_dominated_by_a_lighter_one() -> None:
    costs = (10.0, 8.0, 10.0, np.inf)
    trials = [SizingTrial(4e5, 1.0, 5.0, 0.0, built_mass=mass, cost=cost)
              for mass, cost in zip((5.0, 6.0, 7.0, np.inf), costs, strict=True)]  # fmt: skip
    assert undominated(trials) == [True, True, False, False]


def total_of(machine: Machine) -> tuple[float, float]:
    """Stand for mass and cost as built: none for arms of more than a kilogram."""
    mass = sum(joint.body.mass for joint in machine.joints.values())
    if mass > 1.0:
        raise DesignError("too heavy", where="arm", right="more pressure")
    return 2 * mass, 100 * mass


def test_arms_are_compared_as_they_would_be_built(tmp_path: Path) -> None:
    arm = sized(**LIFT)
    trials = trade_off(arm, [2e5, 6e5], [1.0, 2.0], totals=total_of)
    built = [one for one in trials if not one.refused]
    assert built
    for one in trials:
        same = size_arm(read_task(None, **LIFT | {"supply": f"{one.supply!r} Pa", "time": f"{one.time!r} s"}))
        assert one.mass == pytest.approx(same.mass, abs=1e-12)
        mass = sum(joint.body.mass for joint in same.machine.joints.values())
        assert (one.built_mass, one.cost) == (pytest.approx((2 * mass, 100 * mass)) if mass <= 1.0 else (np.inf,) * 2)
        assert one.refused == ("" if mass <= 1.0 else "can't be built: arm: too heavy; more pressure")
    with write_trials(trials, tmp_path / "trials.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["cost"] for row in rows] == [f"{one.cost:.6g}" if not one.refused else "" for one in trials]
    axes = sizes_picture(arm, trials, (1.0, 50.0)).axes
    assert [one.get_ylabel() for one in axes] == ["Mass of the arm as built (kg)", "Cost of the arm"]
