from math import degrees, radians
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.bridge import PneumaticJoints, arm_spec
from layflat.bridge.brake import Brakes
from layflat.errors import InputError
from layflat.machine import Machine, build, changed, load
from layflat.machine.loader import tables
from layflat.physics.step import STEP
from layflat.sim.plant import SteppedPlant
from tests.physics.arms.chain.chains import random_arm

mujoco: Any = pytest.importorskip("mujoco")
pytestmark = pytest.mark.compiled

ARM, SMALL = load("paper-arm-fast"), load("paper-small-joint-fast")


def machine_with(friction: dict[str, Any]) -> Machine:
    plain, sources = tables("paper-arm-fast")
    for joint in plain["joint"].values():
        joint["friction"] = friction
    return build(plain, sources, "rubbing-arm")


TILTED = changed(changed(ARM, "arm.gravity", 4.0), "arm.gravity_direction", radians(-70.0))
LATE = changed(ARM, "valve.delay", 7e-3)
STRIBECK = {"kind": "stribeck", "static_ratio": 1.4, "velocity": "0.1 rad/s", "drag": "0.2 N m", "load_ratio": 0.02}
RUBBING = machine_with(STRIBECK)
IN_SPACE = random_arm(4, seed=1)
AMBIENT = ARM.supply.ambient_pressure
CYCLE = 0.005
CHAIN = """
<mujoco>
  <option timestep="0.001"/>
  <worldbody>
    <body><joint name="a" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" mass=".3"/>
      <body pos=".2 0 0"><joint name="b" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" mass=".2"/>
        <body pos=".2 0 0"><joint name="c" axis="0 0 1"/><joint name="slide" type="slide" axis="0 0 1"/>
          <geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" mass=".1"/></body></body></body>
  </worldbody>
</mujoco>
"""


def made(machine: Machine, timestep: float, **options: Any) -> tuple[PneumaticJoints, Any, Any]:
    spec = arm_spec(machine)
    spec.option.timestep = timestep
    model = spec.compile()
    return PneumaticJoints(model, machine, **options), model, mujoco.MjData(model)


def lively(cycle: int) -> NDArray[np.float64]:
    t = CYCLE * cycle
    return 5.0 + np.array([1.5 * np.sin(7.0 * t) + np.sin(17.0 * t), 2.0 * np.cos(9.0 * t) * np.sin(2.0 * t)])


def off_by(machine: Machine, timestep: float, cycles: int) -> NDArray[np.float64]:
    """Root mean square of what the angles differ by from our own plant's, deg, and their least range."""
    filled = 0.75 * machine.supply.pressure
    joints, _, data = made(machine, timestep, pressures=(filled, filled))
    own, apart, n = SteppedPlant(machine, noise=False, pressures=(filled, filled)), [], len(machine.joints)
    angles = []
    for k in range(cycles):
        voltages = np.resize(lively(k), n)
        own.drive(voltages)
        joints.drive(voltages)
        own.advance(CYCLE * (k + 1))
        for _ in range(round(CYCLE / timestep)):
            joints.step(data)
        apart.append(joints.angles - own.angles)
        angles.append(own.angles)
    assert np.ptp(angles, axis=0).min() > radians(20.0)
    rms: NDArray[np.float64] = np.degrees(np.sqrt(np.mean(np.square(apart), axis=0)))
    return rms


@pytest.mark.parametrize(
    "machine", [TILTED, LATE, RUBBING, IN_SPACE], ids=["tilted", "late valve", "stribeck", "four joints in space"]
)
def test_with_our_step_it_is_our_own_plant(machine: Machine) -> None:
    assert off_by(machine, STEP, 200).max() < 1e-8


def test_over_four_seconds_too() -> None:
    assert off_by(ARM, STEP, 800).max() < 1e-7


@pytest.mark.parametrize("timestep", [0.1e-3, 1e-3])
def test_with_another_step_it_stays_near(timestep: float) -> None:
    assert off_by(ARM, timestep, 200).max() < 0.05


def test_what_is_asked_before_the_first_step_counts() -> None:
    joints, _, data = made(ARM, 1e-3, pressures=(3e5, 3e5))
    joints.drive(np.array([10.0, 5.0]))
    joints.seize(1, 1.0)
    for _ in range(20):
        joints.step(data)
    assert np.all(joints.pressures[:, 0] > 3.1e5)
    data.qpos[:], data.qvel[:] = (0.2, 0.1), 0.0
    joints.reset(data)
    assert joints.angles.tolist() == [0.2, 0.1]
    assert np.all(joints.pressures == 3e5)


def resting(timestep: float = 5e-3) -> tuple[PneumaticJoints, Any, Any]:
    """Under load, just below what the brakes hold."""
    joints, model, data = made(ARM, timestep, pressures=(AMBIENT, AMBIENT))
    joints.supply = AMBIENT
    data.qpos[:] = 0.3, -0.4
    joints.load[:] = 6.6, -2.1
    return joints, model, data


def test_at_rest_below_the_brakes_torque_nothing_moves() -> None:
    joints, _, data = resting()
    for _ in range(6_000):
        joints.step(data)
    assert data.qpos.tolist() == [0.3, -0.4]
    assert joints.angles.tolist() == [0.3, -0.4]
    assert data.qvel.tolist() == [0.0, 0.0]


def test_above_it_slides_and_comes_to_rest_exactly() -> None:
    joints, _, data = resting(1e-3)
    joints.load[0] = 14.0
    for _ in range(200):
        joints.step(data)
    assert data.qvel[0] > 0.01
    joints.load[0] = 0.0
    for _ in range(200):
        joints.step(data)
    rest = data.qpos.copy()
    for _ in range(200):
        joints.step(data)
    assert np.array_equal(data.qpos, rest)


def test_three_hinges_hold_their_own_weight_and_let_the_rest_move() -> None:
    model = mujoco.MjModel.from_xml_string(CHAIN)
    model.dof_damping[3] = 5.0
    joints = PneumaticJoints(model, SMALL, dict.fromkeys("abc", "small"), pressures=(AMBIENT, AMBIENT))
    joints.supply, data = AMBIENT, mujoco.MjData(model)
    data.qpos[:3] = 0.1, 0.2, -0.3
    for _ in range(500):
        joints.step(data)
    assert joints.hinges == ("a", "b", "c")
    assert data.qpos[:3].tolist() == [0.1, 0.2, -0.3]
    assert data.qpos[3] < -0.05
    joints.brakes[1] = 0.0
    for _ in range(100):
        joints.step(data)
    assert data.qpos[1] > 0.25
    assert data.qpos[0] == 0.1


def test_four_joints_in_space_hold_their_own_weight() -> None:
    joints, _, data = made(random_arm(4, seed=1, gravity=2.0), 5e-3, pressures=(AMBIENT, AMBIENT))
    joints.supply = AMBIENT
    data.qpos[:] = pose = [0.3, -0.4, 0.2, 0.5]
    for _ in range(1000):
        joints.step(data)
    assert data.qpos.tolist() == joints.angles.tolist() == pose
    assert np.abs(data.qfrc_bias).max() > 0.1


def test_energy_is_accounted_for() -> None:
    joints, model, data = made(ARM, 0.25e-3)
    stored, turned = [], np.zeros((model.nv, model.nv))
    for k in range(200):
        joints.drive(5.0 + 0.4 * (lively(k) - 5.0))
        for _ in range(20):
            joints.step(data)
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, turned)
        works = joints.ledgers
        lost = sum(one.hose_work + one.brake_heat + one.damping_heat for one in works)
        moving = 0.5 * data.qvel @ turned @ data.qvel
        stored.append((sum(one.gas_work for one in works) - lost - moving, lost, moving))
    assert np.abs(joints.angles).max() < radians(60.0)
    left, lost, moving = np.array(stored).T
    assert moving.max() > 0.5
    assert lost[-1] > 5.0
    assert np.abs(left).max() < 0.01 * lost[-1]


def scene(with_arm: bool) -> Any:
    spec = arm_spec(ARM) if with_arm else mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = 1e-3, (0.0, 0.0, -9.80665)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(2.0, 2.0, 0.1), pos=(0.0, 0.0, -0.1))
    box = spec.worldbody.add_body(name="box", pos=(-0.5, 0.0, 0.3))
    box.add_freejoint()
    box.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=(0.03, 0.04, 0.05), density=500.0)
    return spec


def test_what_does_not_touch_the_arm_moves_as_without_it() -> None:
    alone, model = scene(False).compile(), scene(True).compile()
    joints, data, other = PneumaticJoints(model, ARM), mujoco.MjData(model), mujoco.MjData(alone)
    for k in range(600):
        if k % 5 == 0:
            joints.drive(lively(k // 5))
        data.qfrc_applied[-3:] = other.qfrc_applied[-3:] = 0.0, 0.01, 0.0
        joints.step(data)
        mujoco.mj_step(alone, other)
    assert other.ncon > 0
    assert data.body("box").xpos == pytest.approx(other.body("box").xpos, abs=1e-6)
    # What was asked for from outside stands as it was.
    assert data.qfrc_applied.tolist() == [0.0] * 5 + [0.0, 0.01, 0.0]


def pushing(disabled: int = 0) -> tuple[PneumaticJoints, Any]:
    """The large joint can push the tip against a wall, at x = 0.22."""
    spec = scene(True)
    spec.body("small-link").add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(0.03, 0.0, 0.0), pos=(0.4, 0.0, 0.0))
    wall = {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": (0.02, 0.2, 0.2), "pos": (0.2, 0.5, 0.0)}
    spec.worldbody.add_geom(**wall)
    model = spec.compile()
    model.opt.disableflags |= disabled
    joints = PneumaticJoints(model, ARM, pressures=(AMBIENT, AMBIENT))
    joints.supply = AMBIENT
    return joints, mujoco.MjData(model)


def test_pressed_against_a_wall_it_rests_and_the_wall_bears_what_the_brake_does_not() -> None:
    joints, data = pushing()
    joints.load[0], joints.brakes[1] = 20.0, 50.0
    for _ in range(1000):
        joints.step(data)
    rest = data.qpos[:2].copy()
    for _ in range(200):
        joints.step(data)
    assert degrees(rest[0]) > 5.0
    assert np.array_equal(data.qpos[:2], rest)
    borne = -data.qfrc_constraint[0]
    # The brake bears the rest, at most what it can.
    assert abs(20.0 + float(joints.torques[0]) - borne) < 6.7 + 1e-6
    assert borne > 10.0


def test_contacts_that_do_not_touch_the_arm_need_no_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    def moved() -> tuple[NDArray[np.float64], int]:
        model = scene(True).compile()
        joints, data = PneumaticJoints(model, ARM), mujoco.MjData(model)
        for k in range(400):
            joints.drive(lively(k // 5))
            joints.step(data)
        return data.qpos.copy(), data.ncon

    alone, contacts = moved()
    monkeypatch.setattr(Brakes, "_is_constrained", lambda _, data: data.nefc > 0)
    in_rounds, _ = moved()
    assert contacts > 0
    assert alone == pytest.approx(in_rounds, abs=1e-12)


def test_the_wall_is_felt_without_islands_too() -> None:
    rests = []
    for flags in (0, int(mujoco.mjtDisableBit.mjDSBL_ISLAND)):
        joints, data = pushing(flags)
        joints.load[0], joints.brakes[1] = 20.0, 50.0
        for _ in range(600):
            joints.step(data)
        rests.append(data.qpos[:2].copy())
        assert (data.nisland == 0) == bool(flags)
    assert degrees(rests[0][0]) > 5.0
    assert rests[1] == pytest.approx(rests[0], abs=1e-6)


@pytest.mark.parametrize(
    ("joints", "expected"),
    [
        ({"elbow": "small"}, "joints: 'elbow' is not a hinge of the model; hinges are a, b, c"),
        ({"slide": "small"}, "joints: 'slide' is not a hinge of the model; hinges are a, b, c"),
        ({"a": "large"}, "joints: 'large' is not a joint of paper-small-joint-fast; joints are small"),
        (None, "joints: 'small' is not a hinge of the model; hinges are a, b, c"),
    ],
)
def test_wrong_names(joints: dict[str, str] | None, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        PneumaticJoints(mujoco.MjModel.from_xml_string(CHAIN), SMALL, joints)
    assert str(caught.value) == expected


@pytest.mark.parametrize("timestep", [0.0, 1e-8, 0.0051, float("nan")])
def test_wrong_timesteps(timestep: float) -> None:
    model = arm_spec(ARM).compile()
    model.opt.timestep = timestep
    with pytest.raises(InputError, match=r"option.timestep of the model: .* is out of range; give 1 us to 0.005 s"):
        PneumaticJoints(model, ARM)


def test_a_scheme_of_several_stages_is_refused() -> None:
    model = arm_spec(ARM).compile()
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with pytest.raises(InputError, match="RK4 steps several times"):
        PneumaticJoints(model, ARM)


def test_a_machine_without_valve_is_refused() -> None:
    with pytest.raises(InputError, match="has no valve or sensors"):
        PneumaticJoints(arm_spec(ARM).compile(), load("rig-kevlar"))


def test_without_mujoco_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "mujoco", None)
    with pytest.raises(InputError) as caught:
        arm_spec(ARM)
    assert str(caught.value) == "needs mujoco-core, not installed; install it: pip install 'layflat[cell]'"
