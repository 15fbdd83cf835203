"""Environments of Gymnasium: its checker, its wrappers, seeds, ends of episodes, what is observed, wrong arguments."""

import logging
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import ClipAction, NormalizeObservation, RecordEpisodeStatistics

import layflat.gym
from layflat.arrays import Array
from layflat.errors import InputError
from layflat.gym.single import ArmEnv
from layflat.gym.vector import ArmVectorEnv
from layflat.machine import load
from layflat.motion.kinematics import tip_position

pytestmark = pytest.mark.compiled

FEW: dict[str, Any] = {"pool": 16, "threads": 1}
TASK = "ReachUnknownPayload"
ANGLE_UNIT = np.radians(75.0)  # half the range of the paper's angle sensors


def make(count: int, task: str = TASK, **options: Any) -> ArmVectorEnv:
    return ArmVectorEnv(task, count, **{**FEW, **options})


def actions(count: int, steps: int, seed: int = 0, joints: int = 2) -> Array:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, count, joints)).astype(np.float32)


@pytest.mark.parametrize("task", layflat.gym.ARM_TASKS)
def test_gymnasium_finds_and_checks_every_environment(task: str) -> None:
    env = gymnasium.make(f"layflat.gym:layflat/{task}-v0", **FEW)
    check_env(env.unwrapped, skip_render_check=True)  # warnings are errors in tests
    env.close()
    envs = gymnasium.make_vec(f"layflat/{task}-v0", 3, **FEW)
    assert isinstance(envs.unwrapped, ArmVectorEnv)
    observations, _ = envs.reset(seed=1)
    assert observations in envs.observation_space
    for action in actions(3, 20, joints=envs.action_space.sample().shape[1]):
        observations, rewards, terminations, truncations, _ = envs.step(action)
        assert observations in envs.observation_space
        assert ((rewards <= 0.0) & (rewards > -5.0)).all()
    assert not terminations.any()
    assert not truncations.any()
    envs.close()


def test_the_same_seed_gives_the_same_everything() -> None:
    def episode(seed: int, threads: int) -> list[Any]:
        envs = make(300, max_episode_steps=8, machines="robust", threads=threads)
        seen: list[Any] = [envs.reset(seed=seed)[0]]
        for action in actions(300, 20):
            observations, rewards, *_ = envs.step(action)
            seen += [observations, rewards]
        envs.close()
        return seen

    first = episode(5, 1)
    assert all(np.array_equal(one, other) for one, other in zip(first, episode(5, 2), strict=True))
    assert not np.array_equal(first[0], episode(6, 1)[0])


def test_one_arm_is_an_arm_of_many() -> None:
    env, envs = ArmEnv(TASK, **FEW), make(1, autoreset_mode="Disabled")
    assert np.array_equal(env.reset(seed=3)[0], envs.reset(seed=3)[0][0])
    for action in actions(1, 30):
        observation, reward, _, _, info = env.step(action[0])
        observations, rewards, _, _, infos = envs.step(action)
        assert np.array_equal(observation, observations[0])
        assert (reward, info["distance"]) == (rewards[0], infos["distance"][0])
    env.close()
    envs.close()


def test_next_step_autoreset_ends_and_begins_as_gymnasium_says() -> None:
    envs = make(5, max_episode_steps=4)
    envs.reset(seed=1)
    ends = []
    for action in actions(5, 11):
        observations, rewards, _, truncations, _ = envs.step(action)
        ends.append(truncations.copy())
        if len(ends) > 1 and ends[-2].any():
            assert (rewards == 0.0).all()
            rows = [i for i, name in enumerate(envs.names) if name.startswith(("action", "rate"))]
            assert (observations[:, rows] == 0.0).all()
    assert np.array_equal(np.array(ends).all(axis=1), [k % 5 == 3 for k in range(11)])
    envs.close()


def test_same_step_autoreset_keeps_the_last_observation() -> None:
    envs, others = make(3, max_episode_steps=4, autoreset_mode="SameStep"), make(3, autoreset_mode="Disabled")
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    envs.reset(seed=1)
    others.reset(seed=1)
    for action in actions(3, 4):
        observations, rewards, _, truncations, infos = envs.step(action)
        expected, expected_rewards, *_, expected_infos = others.step(action)
        assert np.array_equal(rewards, expected_rewards)
    assert truncations.all()
    assert np.array_equal(np.stack(infos["final_obs"]), expected)
    assert np.array_equal(infos["final_info"]["distance"], expected_infos["distance"])
    assert infos["_final_obs"].all()
    assert not np.array_equal(observations, expected)
    assert not envs.step(actions(3, 1)[0])[3].any()
    envs.close()
    others.close()


def test_a_mask_resets_some_arms_and_leaves_the_others() -> None:
    envs, others = make(4, autoreset_mode="Disabled"), make(4, autoreset_mode="Disabled")
    for one in (envs, others):
        one.reset(seed=1)
        one.step(actions(4, 1)[0])
    mask = np.array([True, False, False, True])
    observations, _ = envs.reset(options={"reset_mask": mask})
    moved, *_ = envs.step(actions(4, 1, seed=2)[0])
    expected, *_ = others.step(actions(4, 1, seed=2)[0])
    assert np.array_equal(moved[~mask], expected[~mask])
    assert (observations[mask][:, [envs.names.index("rate large")]] == 0.0).all()
    envs.close()
    others.close()


def test_wrappers_of_gymnasium_run_as_they_are(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        envs = ClipAction(NormalizeObservation(RecordEpisodeStatistics(make(6, max_episode_steps=5))))
        envs.reset(seed=1)
        returns = []
        for action in actions(6, 12):
            observations, rewards, _, _, infos = envs.step(3.0 * action)
            returns.append(rewards)
            if "episode" in infos:
                assert np.allclose(infos["episode"]["r"], np.sum(returns[-5:], axis=0), rtol=1e-5)
    assert np.isfinite(observations).all()
    envs.close()


def test_a_masked_reset_keeps_the_statistics_of_the_others() -> None:
    """Gymnasium's own vector environments lose them, as they take the mask out of the caller's options."""
    envs = RecordEpisodeStatistics(make(2, autoreset_mode="Disabled"))
    envs.reset(seed=1)
    for action in actions(2, 5):
        envs.step(action)
    envs.reset(options={"reset_mask": np.array([True, False])})
    assert envs.episode_lengths.tolist() == [0, 5]
    envs.close()


def test_episodes_have_the_arms_that_are_asked_for() -> None:
    envs, others = make(3), make(2, action="demand")
    first, _ = envs.reset(seed=1, options={"arms": [4, 2, 4]})
    other, _ = others.reset(seed=2, options={"arms": [2, 4]})
    goals = envs.names.index("error large"), envs.names.index("angle large")
    assert np.allclose(first[:, goals].sum(axis=1)[[1, 0, 2]], other[:, goals].sum(axis=1)[[0, 1, 1]], atol=1e-6)
    payloads = envs.batch.inputs["payload"]
    assert np.array_equal(payloads, others.batch.inputs["payload"][[1, 0, 1]])
    assert np.allclose(first[0, :2], first[2, :2], atol=2e-3)  # noise alone differs
    envs.close()
    others.close()


def test_readings_are_those_of_converters_a_cycle_old() -> None:
    envs, others = make(2, cycles=3, delay=1), make(2, cycles=1, delay=0)
    envs.reset(seed=4)
    others.reset(seed=4)
    count = np.degrees(150.0 / 2**12) / np.degrees(75.0)
    for action in actions(2, 10):
        late = envs.step(action)[0][:, :2]
        steps = [others.step(action)[0][:, :2] for _ in range(3)]
        assert np.array_equal(late, steps[1])
        assert np.allclose((late + 1.0) / count, np.round((late + 1.0) / count), atol=2e-3)
    assert not np.array_equal(late, steps[2])
    envs.close()
    others.close()


def test_the_state_is_observed_where_it_is_asked_for() -> None:
    envs = make(3, observe="state")
    envs.reset(seed=2)
    observations, *_ = envs.step(actions(3, 1)[0])
    named = dict(zip(envs.names, observations.T, strict=True))
    assert np.array_equal(named["angle large"], (envs.batch.angle[:, 0] / ANGLE_UNIT).astype(np.float32))
    assert np.allclose(named["payload"], envs.batch.inputs["payload"])
    assert len(np.unique(named["payload"])) > 1
    envs.close()


def test_goals_are_where_the_tip_is_at_their_angles() -> None:
    envs = make(7, "TrackBelt", machines="nominal")
    machine = load("paper-arm-fast")
    observations, _ = envs.reset(seed=2)
    rows = [envs.names.index(f"{block} {joint}") for block in ("angle", "error") for joint in ("large", "small")]
    before = None
    for action in actions(7, 30):
        observations, _, _, _, infos = envs.step(action)
        angle, error = observations[:, rows[:2]], observations[:, rows[2:]]
        goal = tip_position(machine, ANGLE_UNIT * (angle + error).astype(float))
        distance = np.linalg.norm(envs.batch.tip[:, :2] - goal, axis=1)
        assert np.allclose(distance, infos["distance"], atol=2e-5)
        if before is not None:  # points move along straight lines
            assert (np.linalg.norm(goal - before, axis=1) < 0.3 * 0.0201).all()
        before = goal
    envs.close()


@pytest.mark.parametrize(("precision", "number"), [("single", np.float32), ("double", np.float64)])
def test_rewards_follow_their_formula_in_the_precision_of_the_arms(precision: str, number: type) -> None:
    envs = make(5, precision=precision)
    envs.reset(seed=1)
    for action in actions(5, 10):
        _, rewards, _, _, infos = envs.step(action)
        d = infos["distance"]
        assert rewards.dtype == d.dtype == number
        assert np.array_equal(rewards, -(d / (d + number(0.01)) + d / number(0.5)))
        assert np.array_equal(infos["is_success"], d < number(0.002))
    envs.close()


@pytest.mark.parametrize("kind", ["opening", "voltage", "demand", "pressure"])
def test_actions_of_every_kind_cover_its_range_and_are_clipped(kind: str) -> None:
    pair = make(2, action=kind, machines="nominal"), make(2, action=kind, machines="nominal")
    for envs, action in zip(pair, ([[-7.0, 0.5], [3.0, -0.25]], [[-1.0, 0.5], [1.0, -0.25]]), strict=True):
        envs.reset(seed=1)
        envs.step(np.array(action))
    low, high = pair[0].batch.action_limits
    expected = low + (high - low) * (np.array(action) + 1.0) / 2.0
    pair[1].batch.step(expected, 4)
    pair[0].step(np.array([[-7.0, 0.5], [3.0, -0.25]]))
    assert np.array_equal(pair[0].batch.angle, pair[1].batch.angle)
    for envs in pair:
        envs.close()


def test_unknown_torques_push_an_arm_that_holds() -> None:
    envs = make(6, "HoldStiffness", machines="nominal", action="demand")
    observations, infos = envs.reset(seed=1)
    assert (infos["distance"] < 1e-6).all()
    index = [envs.names.index("error large"), envs.names.index("angle large")]
    hold = np.stack([observations[:, index].sum(axis=1), np.zeros(6)], axis=1) * 75.0 / 60.0
    hold[:, 1] = observations[:, envs.names.index("angle small")] * 75.0 / 60.0
    far = np.array([envs.step(hold)[4]["distance"] for _ in range(150)])
    assert (far[:8] < 0.01).all()
    assert (far.max(axis=0) > 0.005).all()
    assert far[-1].mean() < 0.9 * far.max(axis=0).mean()
    envs.close()


def test_demands_reach_goals_by_the_machines_own_law() -> None:
    """The paper's law, which observes nothing of the environment, brings nearly all arms to their goals."""
    envs = make(40, "Reach", machines="nominal", action="demand", pool=64)
    observations, _ = envs.reset(seed=1)
    named = dict(zip(envs.names, observations.T, strict=True))
    goal = np.stack([named[f"angle {j}"] + named[f"error {j}"] for j in ("large", "small")], axis=1) * 75.0 / 60.0
    for _ in range(100):
        *_, infos = envs.step(goal)
    assert infos["is_success"].mean() > 0.9
    envs.close()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"task": "Fly"}, "task: 'Fly' is no task; use Reach"),
        ({"speed": 3}, "speed: is no option of an environment; use machine"),
        ({"machines": "all"}, "machines: 'all' is no set of machines"),
        ({"task": "TrackBelt", "machine": "paper-arm", "machines": "cloud"}, "other geometry"),
        ({"observe": "all"}, "observe: 'all' is unknown; use sensors or state"),
        ({"delay": 5}, "delay: 5 is out of range; give 0 to 4"),
        ({"cycles": 0}, "cycles: 0 is out of range"),
        ({"num_envs": 0}, "num_envs: 0 is out of range"),
        ({"pool": 0.5}, "pool: 0.5 is not a whole number"),
        ({"action": "torque"}, "action: 'torque' is no kind of action"),
        ({"render_mode": "ascii"}, "render_mode: 'ascii' is unknown; use rgb_array or human"),
        ({"autoreset_mode": "never"}, "autoreset_mode: 'never' is unknown; use NextStep"),
        ({"max_episode_steps": -1}, "max_episode_steps: -1 is out of range"),
    ],
)
def test_wrong_options_are_named(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        ArmVectorEnv(**{"task": TASK, **FEW, **options})
    assert message in str(caught.value)


def test_wrong_calls_are_named() -> None:
    envs = make(2, autoreset_mode="Disabled")
    zeros = np.zeros((2, 2))
    for call, message in (
        (lambda: envs.step(zeros), "has not begun; call reset first"),
        (lambda: envs.reset(seed=-1), "seed: -1 is out of range"),
        (lambda: envs.reset(options={"goal": 1}), "goal: is no option of reset"),
        (lambda: envs.reset(options={"reset_mask": [True]}), "reset_mask: has shape (1,)"),
        (lambda: envs.reset(options={"arms": [0, 16]}), "arms: 16 is no arm"),
        (lambda: envs.reset(options={"arms": [0]}), "arms: holds 1 arms for 2 episodes"),
        (lambda: envs.reset(options={"reset_mask": np.array([True, False])}), "reset all first"),
    ):
        with pytest.raises(InputError) as caught:
            call()
        assert message in str(caught.value)
    envs.reset(seed=1)
    bad = np.array([[0.0, np.nan], [0.0, 0.0]])
    for action, message in (
        (np.zeros((2, 3)), "action: has shape (2, 3); give numbers of shape (2, 2)"),
        ([["a", "b"], ["c", "d"]], "holds no numbers"),
        (bad, "nan of arm 0, joint 'small', is no number"),
    ):
        with pytest.raises(InputError) as caught:
            envs.step(action)
        assert message in str(caught.value)
    assert np.array_equal(envs.step(9.0 * np.ones((2, 2)))[0][:, 6:8], np.ones((2, 2)))
    envs.close()
    envs.close()
    for closed in (lambda: envs.step(zeros), envs.reset):
        with pytest.raises(InputError, match="environment: is closed; make a new one"):
            closed()


def test_an_arm_that_diverges_is_terminated() -> None:
    envs = make(3, machines="nominal")
    envs.reset(seed=1)
    envs.batch.inputs["load"][1] = 1e12
    terminated = np.array([envs.step(np.zeros((3, 2)))[2] for _ in range(3)])
    assert terminated.any(axis=0).tolist() == [False, True, False]
    envs.close()
