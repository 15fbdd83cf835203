import re
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import MachineError
from layflat.identify.benches.moving.blocks import machine_unknowns
from layflat.machine import Machine, load, parameters
from layflat.physics.friction.coulomb import Coulomb
from layflat.physics.friction.stribeck import KIND, Stribeck
from layflat.sim import Scenario, rollout
from layflat.sim.ensemble import ensemble
from layflat.sim.sweep import sweep

FALLING = 'kind = "stribeck"\nstatic_ratio = 1.4\nvelocity = "0.1 rad/s"\ndrag = "0.5 N m"\nload_ratio = 0.02'
STICTION = '[valve.stiction]\nstatic_ratio = 1.5\nvelocity = "2 1/s"'


def made(folder: Path, text: str, base: str = "paper-arm") -> Machine:
    file = folder / "mine.toml"
    file.write_text(f'extends = "{base}"\nname = "mine"\n{text}\n', encoding="utf-8")
    return load(file)


PAGE = Path(__file__).parents[2] / "docs" / "friction.md"


def test_the_pages_example_is_a_description(tmp_path: Path) -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    machine = made(tmp_path, text)
    assert parameters.joints(machine)[0].friction == pytest.approx(Stribeck(0.3, 100.0, 0.3, 0.01))
    assert machine.valve is not None
    assert machine.valve.stiction.static_ratio == 1.5


def test_without_a_word_it_is_coulombs(tmp_path: Path) -> None:
    assert all(joint.friction == Coulomb() for joint in parameters.joints(load("paper-arm")))
    named = made(tmp_path, '[joint.large.friction]\nkind = "coulomb"')
    assert parameters.joints(named) == parameters.joints(load("paper-arm"))


def test_one_joint_of_a_kind_and_one_with_coulomb_friction_go_side_by_side(tmp_path: Path) -> None:
    machine = made(tmp_path, f"[joint.small.friction]\n{FALLING}")
    large, small = parameters.joints(machine)
    assert large.friction == KIND.plain
    assert small.friction == pytest.approx(Stribeck(0.4, 100.0, 0.5, 0.02))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (FALLING.replace("1.4", "0.8"), r"friction\.static_ratio: 0\.8 is out of range; give at least 1"),
        (FALLING.replace('"0.1 rad/s"', '"-1 rad/s"'), r"friction\.velocity: '-1 rad/s' .*; give more than 0"),
        (FALLING.replace('"0.5 N m"', '"-1 N m"'), r"friction\.drag: '-1 N m' .*; give at least 0"),
        (FALLING.replace("0.02", "-0.02"), r"friction\.load_ratio: -0\.02 .*; give at least 0"),
        (FALLING.replace("stribeck", "stribek"), r'friction\.kind: .*did you mean "stribeck"'),
        (f"{FALLING}\n{STICTION}".replace("1.5", "0.5"), r"valve\.stiction\.static_ratio: .*; give at least 1"),
        (f"{FALLING}\n{STICTION}".replace("2 1/s", "-2 1/s"), r"valve\.stiction\.velocity: .*; give more than 0"),
    ],
)
def test_impossible_friction_is_refused_in_one_line(tmp_path: Path, text: str, expected: str) -> None:
    with pytest.raises(MachineError, match=expected) as caught:
        made(tmp_path, f"[joint.small.friction]\n{text}")
    assert "\n" not in str(caught.value)


def test_a_slow_sweep_meets_static_friction(tmp_path: Path) -> None:
    plain = load("paper-small-joint")
    falling = made(tmp_path, f"[joint.small.friction]\n{FALLING}", plain.name)
    pressure, joint = 3e5, plain.joint["small"]
    more = sweep(falling, "small", pressure).height - sweep(plain, "small", pressure).height
    kinetic = joint.brake.torque + 0.5 + 0.02 * parameters.torque_constant(joint) * pressure
    assert more == pytest.approx(2.0 * (1.4 * kinetic - joint.brake.torque), rel=1e-9)
    assert parameters.static_friction(falling.joint["small"], 0.5 * pressure) == pytest.approx(1.4 * kinetic)
    assert parameters.static_friction(joint, pressure) == joint.brake.torque


def test_the_fall_can_be_fitted_where_there_is_one(tmp_path: Path) -> None:
    machine = made(tmp_path, f"[joint.small.friction]\n{FALLING}")
    paths = [one.path.removeprefix("joint.") for one in machine_unknowns(machine, ["friction"])]
    fall = ["small.friction.static_ratio", "small.friction.velocity", "small.friction.load_ratio"]
    assert paths == ["large.brake.torque", "large.brake.viscous", "small.brake.torque", "small.brake.viscous", *fall]


@pytest.mark.compiled
def test_runs_of_an_ensemble_are_the_rollouts(tmp_path: Path) -> None:
    text = f"{STICTION}\n[joint.small.friction]\n{FALLING}\n[joint.large.friction]\n{FALLING}"
    machine = made(tmp_path, text)
    moves = Scenario(demand=[("0 s", ("-5 deg", "0 deg")), ("0.1 s", ("10 deg", "5 deg"))], duration="0.6 s")
    ratios = np.array([1.0, 1.4, 2.0])
    runs = ensemble(machine, moves, {"joint.small.friction.static_ratio": ratios}, traces=("angle", "velocity"))
    for i, ratio in enumerate(ratios):
        run = rollout(made(tmp_path, text.replace("static_ratio = 1.4", f"static_ratio = {ratio}", 1)), scenario=moves)
        for name in ("angle", "velocity"):
            assert np.array_equal(runs[name].isel(run=i), run[name][:-1]), name
        assert np.any(run["velocity"][20:] == 0.0)
        assert np.any(run["velocity"] != 0.0)
    assert not np.array_equal(runs["angle"][0], runs["angle"][1])
