from math import cos, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.bridge import arm_spec, to_mjcf, to_urdf
from layflat.machine import Machine, changed, load, parameters
from layflat.physics.arms import tip
from layflat.physics.arms.planar import OneLink, one_link_mass, two_link_gravity, two_link_mass

mujoco: Any = pytest.importorskip("mujoco")

ARM, SMALL = load("paper-arm-fast"), load("paper-small-joint-fast")
TILTED = changed(changed(ARM, "arm.gravity", 4.0), "arm.gravity_direction", radians(-70.0))
POSTURE = (0.3, -0.7)


def posed(model: Any) -> Any:
    data = mujoco.MjData(model)
    data.qpos[:] = POSTURE[: model.nq]
    mujoco.mj_forward(model, data)
    return data


def mass_matrix(model: Any) -> NDArray[np.float64]:
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, posed(model), M)
    return M


def own_mass_matrix(machine: Machine) -> NDArray[np.float64]:
    arm, payload = parameters.arm(machine), machine.arm.payload
    if isinstance(arm, OneLink):
        return np.array([[one_link_mass(arm, payload)]])
    M_11, M_12, M_22, _ = two_link_mass(arm, payload, sin(POSTURE[1] + arm.elbow), cos(POSTURE[1] + arm.elbow))
    return np.array([[M_11, M_12], [M_12, M_22]])


@pytest.mark.parametrize("machine", [ARM, SMALL, TILTED], ids=["arm", "small joint", "tilted arm"])
def test_every_form_has_the_mass_matrix_of_our_laws(machine: Machine) -> None:
    own = own_mass_matrix(machine)
    for model in (
        arm_spec(machine).compile(),
        mujoco.MjModel.from_xml_string(to_mjcf(machine)),
        mujoco.MjModel.from_xml_string(to_urdf(machine)),
    ):
        assert mass_matrix(model) == pytest.approx(own, rel=1e-6)


def test_gravity_and_tip_are_those_of_our_laws() -> None:
    model = arm_spec(TILTED).compile()
    data = posed(model)
    arm: Any = parameters.arm(TILTED)
    turned = POSTURE[1] + arm.elbow
    own = two_link_gravity(arm, TILTED.arm.payload, sin(POSTURE[0]), cos(POSTURE[0]), sin(turned), cos(turned))
    assert -data.qfrc_bias == pytest.approx(own, rel=1e-6)
    assert data.site("tip").xpos[:2] == pytest.approx(tip(arm, POSTURE))
    assert np.linalg.norm(model.opt.gravity) == pytest.approx(9.80665)


@pytest.mark.parametrize("write", [to_mjcf, to_urdf])
def test_files_carry_stops_bearings_and_brakes(write: Any) -> None:
    model = mujoco.MjModel.from_xml_string(write(ARM))
    assert model.jnt_range == pytest.approx(radians(70.0) * np.array([[-1.0, 1.0]] * 2))
    assert model.jnt_limited.all()
    assert model.dof_damping == pytest.approx([0.05, 0.02])
    assert model.dof_frictionloss == pytest.approx([6.7, 2.2])
    assert [model.joint(j).name for j in range(2)] == ["large", "small"]


def test_for_our_joints_it_is_bare() -> None:
    model = arm_spec(ARM).compile()
    assert not model.dof_damping.any()
    assert not model.dof_frictionloss.any()
    assert not model.jnt_limited.any()


def test_models_are_found_by_others_as_files(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(to_urdf(ARM), encoding="utf-8")
    assert mujoco.MjModel.from_xml_path(str(path)).nv == 2
