from math import degrees, radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.bridge import save_arm
from layflat.bridge.robots import ChainEnds, import_arm
from layflat.machine import Machine, load, parameters
from layflat.physics.arms import ARM_KINDS
from layflat.sim.plant import SteppedPlant
from tests.bridge.meshes import write_wedge
from tests.bridge.robot_files import ELBOW, MJCF, SHOULDER, UPPER, urdf, written
from tests.physics.arms.chain.chains import as_chain, random_arm

mujoco: Any = pytest.importorskip("mujoco")

State = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def state(machine: Machine, angles: NDArray[np.float64]) -> State:
    """Mass matrix, torques of gravity, and place of the tip in space."""
    mass, pull = parameters.mass_and_pull(parameters.arm(machine), machine.arm.payload, angles.tolist())
    bodies: Any = ARM_KINDS.named(machine.arm.kind).bodies
    return mass, pull, bodies(machine.arm, list(machine.joints.values())).poses(angles)[-1][1]


def in_mujoco(model: Any, angles: NDArray[np.float64], tip: str) -> State:
    """The same of the joints of a model that stand first; others are held where the model has them."""
    data, n = mujoco.MjData(model), len(angles)
    data.qpos[:n] = angles
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    place = data.site(tip).xpos if model.nsite else data.body(tip).xpos
    return mass[:n, :n], -data.qfrc_bias[:n], place


def assert_same(one: State, other: State, within: float = 1e-11) -> None:
    for a, b in zip(one, other, strict=True):
        assert np.abs(a - b).max() <= within * max(np.abs(a).max(), 1e-3)


@pytest.mark.parametrize("name", ["arm.urdf", "arm.xml"])
@pytest.mark.parametrize(
    "machine", [load("paper-arm"), as_chain(), random_arm(1, 2), random_arm(4, 1), random_arm(7, 3)],
    ids=["planar", "chained", "1", "4", "7"],
)  # fmt: skip
def test_what_was_exported_comes_back_the_same(machine: Machine, name: str, tmp_path: Path) -> None:
    save_arm(machine, tmp_path / name)
    found = import_arm(tmp_path / name).machine
    angles = np.array([0.3, -0.7, 0.5, -0.2, 0.4, 0.1, -0.6])[: len(machine.joints)]
    assert_same(state(machine, angles), state(found, angles))
    assert tuple(found.joints) == tuple(machine.joints)
    assert found.arm.payload == pytest.approx(machine.arm.payload)
    for own, other in zip(machine.joints.values(), found.joints.values(), strict=True):
        assert other.stops.mechanical_stroke == pytest.approx(own.stops.mechanical_stroke)
        assert other.stops.working_stroke == pytest.approx(own.stops.working_stroke)


def test_a_urdf_moves_as_mujoco_has_it(tmp_path: Path) -> None:
    file = written(tmp_path, urdf())
    found = import_arm(file)
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.gravity[:] = 0.0, 0.0, -9.80665
    angles, middle = np.array([0.3, -0.5]), np.array([turn.middle for turn in found.turning])
    assert middle == pytest.approx([0.6, 0.0])
    ours = state(found.machine, angles)
    mass, pull, _ = in_mujoco(model, angles + middle, "upper")
    assert_same(ours, (mass, pull, ours[2]))
    assert found.chain.tool_name == "tool0"
    assert found.notes() == ["left out: collision geometry"]


def test_limits_off_centre_become_a_stroke_about_its_middle(tmp_path: Path) -> None:
    found = import_arm(written(tmp_path, urdf()), stroke={"elbow": (radians(-10.0), radians(70.0))})
    assert degrees(found.turning[1].middle) == pytest.approx(30.0)
    assert found.machine.joints["elbow"].stops.mechanical_stroke == pytest.approx(radians(80.0))
    long = SHOULDER.replace('lower="-0.2"', 'lower="-3"')
    found = import_arm(written(tmp_path, urdf(shoulder=long)))
    assert found.machine.joints["shoulder"].stops.mechanical_stroke == pytest.approx(radians(140.0))
    assert "hoses reach no further: shoulder turns 140 of 252.1 deg" in found.notes()
    assert found.machine.joints["shoulder"].stops.working_stroke == pytest.approx(radians(120.0))


def test_a_working_stroke_is_never_longer_than_the_hoses_own(tmp_path: Path) -> None:
    soft = '<safety_controller soft_lower_limit="-1.2" soft_upper_limit="1.2" k_velocity="1"/></joint>'
    wide = ELBOW.replace('lower="-1" upper="1"', 'lower="-1.2" upper="1.2"').replace("</joint>", soft)
    found = import_arm(written(tmp_path, urdf(elbow=wide)))
    stops = found.machine.joints["elbow"].stops
    assert stops.mechanical_stroke == pytest.approx(2.4)
    assert stops.working_stroke == pytest.approx(radians(120.0))


@pytest.mark.parametrize(
    ("robot", "note"),
    [
        (
            {"elbow": ELBOW.replace('rpy="1.5707963267948966 0 0"', 'rpy="0 90 0"')},
            "joint 'elbow': rpy=\"0 90 0\" is read in rad, as URDF has it: more than a full turn; are they degrees?",
        ),
        (
            {
                "elbow": ELBOW.replace(
                    "</joint>", '<safety_controller soft_lower_limit="1" soft_upper_limit="-1"/></joint>'
                )
            },
            "joint 'elbow': soft limits from 1 to -1, the wrong way round: left out",
        ),
    ],
)
def test_numbers_that_look_mistaken_are_told(robot: dict[str, str], note: str, tmp_path: Path) -> None:
    assert note in import_arm(written(tmp_path, urdf(**robot))).notes()
    assert note not in import_arm(written(tmp_path, urdf())).notes()


def test_an_mjcf_moves_as_mujoco_has_it_up_to_a_body(tmp_path: Path) -> None:
    file = written(tmp_path, MJCF, "robot.xml")
    found = import_arm(file, ends=ChainEnds(to="fore", tool="grip"))
    model = mujoco.MjModel.from_xml_path(str(file))
    assert found.turning[0].middle == pytest.approx(radians(-5.0))  # of -50 and 40; the file draws it at 10
    angles, middle = np.array([0.3, -0.5]), np.array([turn.middle for turn in found.turning])
    assert_same(state(found.machine, angles), in_mujoco(model, angles + middle, "grip"))
    assert found.notes()[:2] == [
        "joints held still at zero: close, shut",
        "left out: collision geometry, actuators, damping and friction of joints",
    ]
    assert [shape.kind for shape in found.machine.arm.link["swing"].shapes] == ["capsule"]


@pytest.mark.parametrize("name", ["robot.urdf", "robot.xml"])
def test_meshes_come_along_with_place_and_scale(name: str, tmp_path: Path) -> None:
    (tmp_path / "from").mkdir()
    write_wedge(tmp_path / "from" / "parts" / "wedge.stl")
    write_wedge(tmp_path / "from" / "wedge.stl")
    shapes = [
        {"kind": "mesh", "file": one, "scale": [0.1, 0.2, 0.3], "position": ["10 mm", "20 mm", "0 mm"],
         "rotation": ["0 deg", "0 deg", "30 deg"]} for one in ("wedge.stl", "parts/wedge.stl")
    ]  # fmt: skip
    machine = as_chain(shapes={"large": shapes}, where=str(tmp_path / "from" / "arm.toml"))
    save_arm(machine, tmp_path / "out" / name)
    found = import_arm(tmp_path / "out" / name, name="back")
    saved = found.save(tmp_path / "last")
    assert [path.relative_to(tmp_path / "last").as_posix() for path in saved] == [
        "back.toml", "back-meshes/wedge.stl", "back-meshes/wedge-2.stl"
    ]  # fmt: skip
    back = load(saved[0])
    assert Path(back.arm.link["large"].shapes[1].file) == saved[2]
    for own, other in zip(machine.arm.link["large"].shapes, back.arm.link["large"].shapes, strict=True):
        assert other.scale == pytest.approx(own.scale)
        assert other.position == pytest.approx(own.position, abs=1e-7)
        assert other.rotation == pytest.approx(own.rotation, abs=1e-6)
    assert state(back, np.array([0.1, 0.2]))[0].tolist() == state(found.machine, np.array([0.1, 0.2]))[0].tolist()


def test_meshes_of_a_package_are_found_around_the_file(tmp_path: Path) -> None:
    write_wedge(tmp_path / "my_robot" / "meshes" / "wedge.dae")
    (tmp_path / "my_robot" / "urdf").mkdir()
    mesh = '<visual><geometry><mesh filename="package://my_robot/meshes/wedge.dae" scale="0.001"/></geometry></visual>'
    upper = UPPER.replace("</link>", f"{mesh}</link>")
    found = import_arm(written(tmp_path / "my_robot" / "urdf", urdf(upper=upper)))
    assert [shape.kind for shape in found.machine.arm.link["shoulder"].shapes] == ["cylinder", "mesh"]
    assert found.machine.arm.link["shoulder"].shapes[1].scale == (0.001, 0.001, 0.001)
    assert list(found.text.meshes.values()) == [tmp_path / "my_robot" / "meshes" / "wedge.dae"]


def test_joints_of_hose_are_chosen_for_each(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text('extends = "paper-small-joint-fast"\nname = "own"\n[joint.small.cylinder]\ndiameter = "110 mm"\n')
    chosen = ["paper-arm-fast:large", f"elbow={own}:small"]
    machine = import_arm(written(tmp_path, urdf()), joints=chosen, name="mine").machine
    large = load("paper-arm-fast").joints["large"]
    assert machine.name == "mine"
    assert machine.joints["shoulder"].hose == large.hose
    assert machine.joints["elbow"].cylinder.diameter == pytest.approx(0.11)


def test_what_hoses_can_not_carry_is_told(tmp_path: Path) -> None:
    heavy = UPPER.replace('<mass value="0.5"/>', '<mass value="90"/>')
    (note,) = import_arm(written(tmp_path, urdf(upper=heavy))).notes()[1:]
    assert note.startswith("joint 'shoulder' can't carry the arm: gravity takes up to ")


@pytest.mark.compiled
def test_what_was_imported_moves_at_once(tmp_path: Path) -> None:
    save_arm(random_arm(4, seed=1), tmp_path / "arm.urdf")
    written_to = import_arm(tmp_path / "arm.urdf").save(tmp_path)
    plant = SteppedPlant(load(written_to[0]), noise=False)
    plant.drive(np.array([7.0, 3.0, 7.0, 3.0]))
    plant.advance(0.3)
    assert np.abs(np.degrees(plant.angles)).min() > 1.0
