from dataclasses import replace
from math import radians
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.bridge import arm_spec, save_arm, to_mjcf, to_urdf
from layflat.errors import InputError
from layflat.kinds import KindTable
from layflat.machine import Machine, changed, load, parameters
from layflat.motion.kinematics import Kinematics
from layflat.physics.arms import ARM_KINDS as KINDS
from tests.bridge.meshes import write_wedge
from tests.physics.arms.chain.chains import as_chain, random_arm

mujoco: Any = pytest.importorskip("mujoco")

ARM, SMALL = load("paper-arm-fast"), load("paper-small-joint-fast")
TILTED = changed(changed(ARM, "arm.gravity", 4.0), "arm.gravity_direction", radians(-70.0))
ARMS = [ARM, SMALL, TILTED, as_chain(), random_arm(1, 5), random_arm(4, 1), random_arm(7, 3)]


def pose(machine: Machine) -> NDArray[np.float64]:
    return np.array([0.3, -0.7, 0.5, -0.2, 0.4, 0.1, -0.6])[: len(machine.joints)]


def posed(model: Any, machine: Machine) -> Any:
    data = mujoco.MjData(model)
    data.qpos[:] = pose(machine)
    mujoco.mj_forward(model, data)
    return data


def models(machine: Machine) -> list[Any]:
    texts = to_mjcf(machine), to_urdf(machine)
    return [arm_spec(machine).compile(), *map(mujoco.MjModel.from_xml_string, texts)]


@pytest.mark.parametrize("machine", ARMS, ids=["arm", "small joint", "tilted", "chained", "1", "4", "7"])
def test_every_form_has_masses_and_gravity_of_our_laws(machine: Machine) -> None:
    own, pull = parameters.mass_and_pull(parameters.arm(machine), machine.arm.payload, pose(machine).tolist())
    for model in models(machine):
        data, mass = posed(model, machine), np.zeros(own.shape)
        mujoco.mj_fullM(model, data, mass)
        assert np.abs(mass - own).max() < 1e-10 * np.abs(own).max()
        assert np.abs(data.qfrc_bias + pull).max() <= 1e-10 * np.abs(pull).max()


@pytest.mark.parametrize("machine", ARMS[2:6])
def test_places_and_axes_are_those_of_our_laws(machine: Machine) -> None:
    like = tuple(map(float, pose(machine)))
    places, axes = Kinematics(machine).joints(np.array([like]))
    data = posed(arm_spec(machine).compile(), machine)
    assert data.xanchor == pytest.approx(places[0, :-1], abs=1e-12)
    assert data.xaxis == pytest.approx(axes[0], abs=1e-12)
    assert data.site("tip").xpos == pytest.approx(places[0, -1], abs=1e-12)


def test_gravity_that_a_plane_does_not_show_acts_across_it() -> None:
    assert np.linalg.norm(arm_spec(TILTED).compile().opt.gravity) == pytest.approx(9.80665)


@pytest.mark.parametrize("write", [to_mjcf, to_urdf])
def test_files_carry_stops_bearings_brakes_and_torques(write: Any) -> None:
    model = mujoco.MjModel.from_xml_string(write(ARM))
    assert model.jnt_range == pytest.approx(radians(70.0) * np.array([[-1.0, 1.0]] * 2))
    assert model.jnt_limited.all()
    assert model.dof_damping == pytest.approx([0.05, 0.02])
    assert model.dof_frictionloss == pytest.approx([6.7, 2.2])
    torques = [parameters.torque_constant(joint) * ARM.supply.pressure_gauge for joint in ARM.joints.values()]
    assert model.jnt_actfrcrange[:, 1] == pytest.approx(torques, rel=1e-5)
    assert [model.joint(j).name for j in range(2)] == ["large", "small"]


def test_urdf_tells_the_working_stroke_and_the_speed_that_valves_feed() -> None:
    text = to_urdf(ARM)
    half = ARM.joints["large"].stops.working_stroke / 2
    assert f'soft_lower_limit="{-half!r}" soft_upper_limit="{half!r}"' in text
    fast = to_urdf(changed(ARM, "joint.large.valve_size", 2.0))
    speeds = [float(one.split('velocity="')[1].split('"')[0]) for one in (text, fast)]
    assert speeds[1] == pytest.approx(2.0 * speeds[0], rel=1e-5)


def test_for_our_joints_it_is_bare() -> None:
    model = arm_spec(ARM).compile()
    assert not model.dof_damping.any()
    assert not model.dof_frictionloss.any()
    assert not model.jnt_limited.any()
    assert not model.jnt_actfrclimited.any()


def with_shapes(folder: Path) -> Machine:
    """An arm of two joints in space that shows every kind of shape; meshes beside its file."""
    write_wedge(folder / "wedge.stl")
    write_wedge(folder / "other" / "wedge.obj")
    turned = {"position": ["10 mm", "0 mm", "0 mm"], "rotation": ["0 deg", "90 deg", "0 deg"]}
    large = [
        {"kind": "box", "size": ["100 mm", "40 mm", "20 mm"]} | turned,
        {"kind": "capsule", "size": ["30 mm", "100 mm"]} | turned,
        {"kind": "sphere", "size": ["50 mm"]},
        {"kind": "cylinder", "size": ["30 mm", "100 mm"]},
    ]
    small = [
        {"kind": "mesh", "file": "wedge.stl", "scale": [0.1, 0.2, 0.3]} | turned,
        {"kind": "mesh", "file": "other/wedge.obj"},
    ]
    return as_chain(shapes={"large": large, "small": small}, where=str(folder / "arm.toml"))


def test_shapes_are_drawn_where_they_are_described(tmp_path: Path) -> None:
    machine = with_shapes(tmp_path)
    model = arm_spec(machine).compile()
    kinds = [mujoco.mjtGeom(int(kind)).name.removeprefix("mjGEOM_").lower() for kind in model.geom_type]
    assert kinds == ["box", "capsule", "sphere", "cylinder", "mesh", "mesh"]
    assert not model.geom_contype.any()
    corners = mujoco.MjData(model)
    mujoco.mj_kinematics(model, corners)
    geom = corners.geom("small-0")
    at = model.mesh_vertadr[model.geom("small-0").dataid[0]]
    seen = geom.xpos + geom.xmat.reshape(3, 3) @ model.mesh_vert[at : at + 4].T.astype(float).mean(1)
    # The wedge's corners are 0, x, y and z of length 1; turned by a quarter about y, z lies along x.
    wanted = np.array([0.01, 0.0, 0.0]) + np.array([0.25 * 0.3, 0.25 * 0.2, -0.25 * 0.1])
    link = corners.body("small-link")
    assert seen == pytest.approx(link.xpos + link.xmat.reshape(3, 3) @ wanted, abs=1e-6)


@pytest.mark.parametrize("name", ["arm.xml", "arm.urdf"])
def test_files_have_their_meshes_beside_them(name: str, tmp_path: Path) -> None:
    written = save_arm(with_shapes(tmp_path / "from"), tmp_path / "to" / name)
    folder = f"to/arm-{Path(name).suffix[1:]}-meshes"
    assert [path.relative_to(tmp_path).as_posix() for path in written] == [
        f"to/{name}", f"{folder}/wedge.stl", f"{folder}/wedge.obj"
    ]  # fmt: skip
    model = mujoco.MjModel.from_xml_path(str(written[0]))
    assert model.nmesh == 2
    assert model.ngeom == 6 + 2 * (name == "arm.urdf") + 2  # a capsule's ends, and bodies of joints


def test_a_mesh_that_is_missing_is_named(tmp_path: Path) -> None:
    machine = with_shapes(tmp_path)
    (tmp_path / "wedge.stl").unlink()
    with pytest.raises(InputError, match=r"arm.toml: arm.link.small.shapes.0.file: wedge.stl is not there; put"):
        to_urdf(machine)


def test_an_arm_without_bodies_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    from layflat.bridge import pieces

    bare = [replace(kind, bodies=kind.bodies if kind.name == "chain" else None) for kind in KINDS]
    monkeypatch.setattr(pieces, "ARM_KINDS", KindTable("arm", *bare))
    with pytest.raises(InputError, match=r"arm\.kind: arms of the kind 'planar' have no bodies"):
        arm_spec(ARM)


class Unusable(ModuleType):
    """Leftover of a package after an upgrade: a folder without its module, or a library of another version."""

    def __init__(self, error: Exception | None = None, **attributes: str) -> None:
        super().__init__("mujoco")
        self.__dict__.update(attributes)
        self.error = error


REPAIR = "pip uninstall -y mujoco mujoco-studio && pip install --force-reinstall --no-deps 'mujoco-core>=4.0.1'"


@pytest.mark.parametrize(
    ("package", "expected"),
    [
        (
            Unusable(),
            "needs mujoco-core, can't be imported (module 'mujoco' has no attribute '__version__'); repair it",
        ),
        (Unusable(__version__="3.17.0"), "MuJoCo is of version 3.17.0; before 4.0.1 it solves some models wrongly; "),
        (Unusable(__version__="4.0.0"), "MuJoCo is of version 4.0.0; before 4.0.1 it solves some models wrongly; "),
        (Unusable(OSError("libmujoco.so.3.17.0: no such file")), "needs mujoco-core, can't be imported (libmujoco.so"),
        (
            Unusable(ImportError("is missing\nRepair it")),
            "needs mujoco-core, can't be imported (is missing); repair it",
        ),
    ],
)
def test_what_an_upgrade_has_broken_says_how_to_repair_it(
    package: Unusable, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def load(_: str) -> ModuleType:
        if package.error is not None:
            raise package.error
        return package

    monkeypatch.setattr("layflat.extras.import_module", load)
    with pytest.raises(InputError) as caught:
        arm_spec(ARM)
    assert str(caught.value).startswith(expected)
    assert REPAIR in str(caught.value)
