from math import cos, degrees, radians, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.arms.planar import (
    KIND,
    LevelTwoLink,
    OneLink,
    TwoLink,
    one_link_gravity,
    one_link_mass,
    parameters,
    two_link_coriolis,
    two_link_gravity,
    two_link_mass,
)
from layflat.sim.loop import Timing
from tests.physics.plants import CYCLE, PASSIVE, Floats, kinetic_energy, run, signals

mujoco: Any = pytest.importorskip("mujoco")

LENGTH, PAYLOAD, ELBOW = 0.4, 1.5, radians(60.0)
MASSES, CENTRES, INERTIAS = (3.0, 0.8), (0.25, 0.15), (0.05, 0.02)
GRAVITY = (3.0, -9.0)
DAMPING = 0.4
ARM = TwoLink(
    INERTIAS[0] + MASSES[0] * CENTRES[0] ** 2 + MASSES[1] * LENGTH**2 + INERTIAS[1] + MASSES[1] * CENTRES[1] ** 2,
    MASSES[1] * LENGTH * CENTRES[1],
    INERTIAS[1] + MASSES[1] * CENTRES[1] ** 2,
    MASSES[0] * CENTRES[0] + MASSES[1] * LENGTH,
    MASSES[1] * CENTRES[1],
    LENGTH,
    LENGTH,
    ELBOW,
    *GRAVITY,
)

MODEL = f"""
<mujoco>
  <compiler angle="radian"/>
  <option gravity="{GRAVITY[0]} {GRAVITY[1]} 0" timestep="1e-4" integrator="RK4"/>
  <worldbody>
    <body>
      <joint axis="0 0 1" damping="{DAMPING}"/>
      <inertial pos="{CENTRES[0]} 0 0" mass="{MASSES[0]}" diaginertia="{" ".join([str(INERTIAS[0])] * 3)}"/>
      <body pos="{LENGTH} 0 0" euler="0 0 {ELBOW}">
        <joint axis="0 0 1" damping="{DAMPING}"/>
        <inertial pos="{CENTRES[1]} 0 0" mass="{MASSES[1]}" diaginertia="{" ".join([str(INERTIAS[1])] * 3)}"/>
        <body pos="{LENGTH} 0 0">
          <inertial pos="0 0 0" mass="{PAYLOAD}" diaginertia="1e-9 1e-9 1e-9"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
POSED = (mujoco.MjModel.from_xml_string(MODEL), mujoco.MjData(mujoco.MjModel.from_xml_string(MODEL)))


def test_moments_of_both_links_are_those_of_their_masses() -> None:
    def joint(i: int, carried: float) -> Any:
        link = SimpleNamespace(
            mass=MASSES[i], centre=CENTRES[i], length=LENGTH, inertia=0.6 * INERTIAS[i], rotor_inertia=0.4 * INERTIAS[i]
        )
        return SimpleNamespace(planar_link=link, body=SimpleNamespace(mass=carried))

    size, way = float(np.hypot(*GRAVITY)), float(np.arctan2(GRAVITY[1], GRAVITY[0]))
    described: Any = SimpleNamespace(gravity=size, gravity_direction=way, elbow=ELBOW)
    assert parameters(described, [joint(0, 9.0), joint(1, 0.0)]) == pytest.approx(ARM)
    heavier = ARM._replace(a=ARM.a + 2.0 * LENGTH**2, moment_1=ARM.moment_1 + 2.0 * LENGTH)
    assert parameters(described, [joint(0, 9.0), joint(1, 2.0)]) == pytest.approx(heavier)
    alone = OneLink(INERTIAS[0] + MASSES[0] * CENTRES[0] ** 2, MASSES[0] * CENTRES[0], LENGTH, *GRAVITY)
    assert parameters(described, [joint(0, 9.0)]) == pytest.approx(alone)
    level = parameters(SimpleNamespace(gravity=0.0, gravity_direction=way, elbow=ELBOW), [joint(0, 0.0), joint(1, 0.0)])  # type: ignore[arg-type]
    assert level == pytest.approx(LevelTwoLink(*ARM[:3], LENGTH, LENGTH, ELBOW))


def test_points_are_those_of_links_laid_end_to_end() -> None:
    first, second = 0.3 * np.exp(0.7j), 0.5 * np.exp(1j * (0.7 - 0.4 + ELBOW))
    arm = ARM._replace(length_1=0.3, length_2=0.5)
    found = KIND.laws[TwoLink].points(arm, (0.7, -0.4))
    assert np.array(found) @ [1.0, 1.0j] == pytest.approx(np.array([0.0, first, first + second]))
    alone = KIND.laws[OneLink].points(OneLink(0.3, 1.2, 0.5, *GRAVITY), (0.7,))
    assert np.array(alone) @ [1.0, 1.0j] == pytest.approx(np.array([0.0, 0.5 * np.exp(0.7j)]))


angles = st.floats(-1.2, 1.2)
speeds = st.floats(-5.0, 5.0)


@given(angles, angles, speeds, speeds)
def test_a_level_arm_is_one_without_gravity(q_1: float, q_2: float, v_1: float, v_2: float) -> None:
    level, weightless = LevelTwoLink(*ARM[:3], LENGTH, LENGTH, ELBOW), ARM._replace(gravity_x=0.0, gravity_y=0.0)
    found, told = (KIND.laws[type(arm)].dynamics(arm, PAYLOAD, (q_1, q_2), (v_1, v_2)) for arm in (level, weightless))
    for one, other in zip(found, told, strict=True):
        assert one == pytest.approx(other, abs=1e-12)


def mass(q: Floats) -> tuple[Any, float]:
    M_11, M_12, M_22, h = two_link_mass(ARM, PAYLOAD, sin(q[1] + ELBOW), cos(q[1] + ELBOW))
    return np.array([[M_11, M_12], [M_12, M_22]]), h


def gravity(q: Floats) -> Floats:
    torques = two_link_gravity(ARM, PAYLOAD, sin(q[0]), cos(q[0]), sin(q[1] + ELBOW), cos(q[1] + ELBOW))
    return np.array(torques)


def potential(q: Floats) -> float:
    """Energy in the gravity field, from where the masses are."""
    at = np.array([cos(q[0]), sin(q[0])])
    on = np.array([cos(q[0] + q[1] + ELBOW), sin(q[0] + q[1] + ELBOW)])
    moment = MASSES[0] * CENTRES[0] * at + MASSES[1] * (LENGTH * at + CENTRES[1] * on) + PAYLOAD * LENGTH * (at + on)
    return -float(moment @ np.array(GRAVITY))


@given(angles, angles)
def test_gravity_is_the_slope_of_the_potential(q_1: float, q_2: float) -> None:
    q, d = np.array([q_1, q_2]), 1e-5
    slope = [(potential(q + d * e) - potential(q - d * e)) / (2 * d) for e in np.eye(2)]
    assert gravity(q) == pytest.approx(-np.array(slope), abs=1e-6)


@given(angles, angles)
def test_mass_matrix_is_positive_definite(q_1: float, q_2: float) -> None:
    assert np.all(np.linalg.eigvalsh(mass(np.array([q_1, q_2]))[0]) > 0.0)


@given(angles, speeds, speeds)
def test_coriolis_terms_keep_the_energy(q_2: float, v_1: float, v_2: float) -> None:
    # d/dt (v M v / 2) = 0 without torques: v . c = -v M' v / 2, M' the rate of the mass matrix.
    d, v = 1e-6, np.array([v_1, v_2])
    rate = (mass(np.array([0.0, q_2 + d]))[0] - mass(np.array([0.0, q_2 - d]))[0]) / (2 * d) * v_2
    torques = np.array(two_link_coriolis(mass(np.array([0.0, q_2]))[1], v_1, v_2))
    assert v @ torques == pytest.approx(-0.5 * v @ rate @ v, abs=1e-7)


@given(angles, angles, speeds, speeds)
def test_torques_agree_with_mujoco(q_1: float, q_2: float, v_1: float, v_2: float) -> None:
    model, data = POSED
    data.qpos[:], data.qvel[:] = (q_1, q_2), (v_1, v_2)
    mujoco.mj_forward(model, data)
    q = np.array([q_1, q_2])
    M, h = mass(q)
    for v in np.eye(2):
        momentum = np.zeros(2)
        mujoco.mj_mulM(model, data, momentum, v)
        assert M @ v == pytest.approx(momentum, rel=1e-6)
    ours = np.array(two_link_coriolis(h, v_1, v_2)) + gravity(q)
    assert ours == pytest.approx(-data.qfrc_bias, abs=1e-5)


def torques(cycle: int) -> Floats:
    t = cycle * CYCLE
    return np.array([8.0 * np.sin(5.0 * t), 3.0 * np.cos(9.0 * t)])


def mujoco_run(cycles: int) -> Floats:
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    path = [data.qpos.copy()]
    for k in range(cycles):
        data.qfrc_applied[:] = torques(k)
        mujoco.mj_step(model, data, round(CYCLE / model.opt.timestep))
        path.append(data.qpos.copy())
    return np.array(path)


@pytest.mark.compiled
def test_the_arm_alone_follows_mujoco() -> None:
    cycles = 200
    loads = np.array([torques(k) for k in range(cycles)])
    joint = PASSIVE._replace(viscous_friction=DAMPING)
    reference = mujoco_run(cycles)
    assert np.ptp(reference, axis=0).min() > 1.0
    errors = []
    for steps in (20, 40):
        ours = run(ARM, (joint, joint), signals(cycles, 2, load=loads, payload=PAYLOAD), Timing(CYCLE, steps, 1))
        errors.append(np.abs(ours.column("angle") - reference).max())
    assert degrees(errors[0]) < 0.001
    # What is left comes from our step, and goes with its square.
    assert errors[1] < 0.3 * errors[0]


@pytest.mark.compiled
def test_a_free_arm_keeps_its_energy() -> None:
    arm = ARM._replace(gravity_x=0.0, gravity_y=0.0)
    kick = np.zeros((400, 2))
    kick[:10] = (20.0, -6.0)
    free = run(arm, (PASSIVE, PASSIVE), signals(400, 2, load=kick, payload=PAYLOAD))
    energy = kinetic_energy(arm, PAYLOAD, free.column("angle"), free.column("velocity"))[11:]
    assert energy == pytest.approx(energy[0], rel=1e-4)


def test_one_link_is_a_pendulum() -> None:
    arm = OneLink(0.3, 1.2, 0.5, 2.0, -9.0)
    assert one_link_mass(arm, 2.0) == pytest.approx(0.3 + 2.0 * 0.25)
    assert one_link_gravity(arm, 2.0, 0.0) == pytest.approx(-9.0 * (1.2 + 2.0 * 0.5))
    # In balance where it points along gravity.
    assert one_link_gravity(arm, 2.0, float(np.arctan2(-9.0, 2.0))) == pytest.approx(0.0, abs=1e-12)
