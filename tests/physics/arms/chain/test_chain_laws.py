"""Chains in space: random ones against MuJoCo, and what holds of any of them."""

from copy import copy
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from layflat.jit import kernel
from layflat.lanes import gather, join, slots
from layflat.physics.arms.chain import AlignedLink
from layflat.physics.arms.chain import build_chain as chain_of
from layflat.physics.arms.chain.laws import ChainParameters, dynamics, points
from layflat.physics.arms.chain.space import Axes, RigidBody, Symmetric, Vector, add_point_mass, scale_vector

mujoco: Any = pytest.importorskip("mujoco")

SIZES = range(1, 8)


def vector(x: np.ndarray) -> Vector:
    return Vector(*x.tolist())


@cache
def jointed(n: int, seed: int) -> tuple[list[AlignedLink], tuple[float, ...], Vector, Vector]:
    """A random arm: every link a few points of mass; armatures, tool and gravity."""
    draw = np.random.default_rng(seed)
    links = []
    for _ in range(n):
        axes = Axes(*(vector(column) for column in Rotation.random(random_state=draw).as_matrix().T))
        body = RigidBody(0.0, Vector(0.0, 0.0, 0.0), Symmetric(0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        for _ in range(5):
            body = add_point_mass(body, draw.uniform(0.05, 0.6), vector(draw.normal(0.0, 0.15, 3)))
        links.append(AlignedLink(axes, vector(draw.normal(0.0, 0.3, 3)), body))
    armatures = np.diag(draw.uniform(0.0, 0.05, n))[np.triu_indices(n)]
    return links, tuple(armatures.tolist()), vector(draw.normal(0.0, 0.2, 3)), vector(draw.normal(0.0, 6.0, 3))


def chain(n: int, seed: int) -> ChainParameters:
    return chain_of(*jointed(n, seed))


def about_centre(body: RigidBody) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass, and inertia about it."""
    J, c = body.J, np.array(body.h) / body.m
    about_origin = np.array([[J.xx, J.xy, J.xz], [J.xy, J.yy, J.yz], [J.xz, J.yz, J.zz]])
    return c, about_origin - body.m * (c @ c * np.eye(3) - np.outer(c, c))


@cache
def in_mujoco(n: int, seed: int, payload: float) -> Any:
    (links, armatures, tool, gravity), spec = jointed(n, seed), mujoco.MjSpec()
    spec.option.gravity = list(gravity)
    spec.compiler.balanceinertia = False
    parent, at = spec.worldbody, 0
    for i, link in enumerate(links):
        body = link.body if i < n - 1 else add_point_mass(link.body, payload, tool)
        centre, J = about_centre(body)
        quat = Rotation.from_matrix(np.array(link.axes).T).as_quat(scalar_first=True)
        parent = parent.add_body(pos=list(link.place), quat=quat, mass=body.m, ipos=centre, explicitinertial=True)
        parent.fullinertia = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
        parent.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0], armature=armatures[at])
        at += n - i
    parent.add_site(name="tool", pos=list(tool))
    return spec.compile()


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(SIZES), st.integers(0, 3), st.integers(0, 10_000), st.sampled_from([0.0, 1.3]))
def test_mass_matrix_and_torques_are_those_of_mujoco(n: int, seed: int, drawn: int, payload: float) -> None:
    draw = np.random.default_rng(drawn)
    q, v = draw.uniform(-3.0, 3.0, n), draw.normal(0.0, 4.0, n)
    upper, moving, pulled = dynamics(chain(n, seed), payload, tuple(q.tolist()), tuple(v.tolist()))
    model = in_mujoco(n, seed, payload)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = q, v
    mujoco.mj_forward(model, data)
    full = np.zeros((n, n))
    mujoco.mj_fullM(model, data, full)
    assert np.abs(np.array(upper) - full[np.triu_indices(n)]).max() < 1e-10 * np.abs(full).max()
    bias = np.array(moving) + np.array(pulled)
    assert np.abs(bias + data.qfrc_bias).max() < 1e-10 * np.abs(data.qfrc_bias).max()
    *places, tip = points(chain(n, seed), tuple(q.tolist()))
    assert np.abs(np.array(places) - data.xanchor).max() < 1e-10
    assert np.abs(np.array(tip) - data.site("tool").xpos).max() < 1e-10


@pytest.mark.parametrize("tilt", [0.0, 1e-13, 1e-9, 1e-5, np.pi])
def test_axes_that_are_almost_parallel_are_as_good_as_others(tilt: float) -> None:
    links, _, tool, gravity = jointed(3, 5)
    first = links[0]._replace(axes=Axes(Vector(1.0, 0.0, 0.0), Vector(0.0, 1.0, 0.0), Vector(0.0, 0.0, 1.0)))
    s, c = float(np.sin(tilt)), float(np.cos(tilt))
    leaning = Axes(Vector(c, 0.0, -s), Vector(0.0, 1.0, 0.0), Vector(s, 0.0, c))
    arm = chain_of([first, links[1]._replace(axes=leaning), links[2]], (0.0,) * 6, tool, gravity)
    q = (0.3, -0.8, 0.5)
    spun = [Rotation.from_rotvec([0.0, 0.0, angle]) for angle in q]
    frames = [Rotation.from_matrix(np.array(axes).T) for axes in (first.axes, leaning, links[2].axes)]
    hand = frames[0] * spun[0] * frames[1] * spun[1] * frames[2] * spun[2]
    lower = frames[0] * spun[0]
    elbow = first.place + lower.apply(links[1].place)
    wrist = elbow + (lower * frames[1] * spun[1]).apply(links[2].place)
    found = np.array(points(arm, q))
    assert found == pytest.approx(np.array([first.place, elbow, wrist, wrist + hand.apply(tool)]), abs=1e-12)


@kernel
def compiled(arm: Any, payload: float, q: Any, v: Any) -> Any:
    return dynamics(arm, payload, q, v)


@pytest.mark.compiled
@pytest.mark.parametrize("n", [1, 3, 4, 7])
def test_compiled_it_has_the_same_bits(n: int) -> None:
    draw = np.random.default_rng(n)
    q, v = tuple(draw.uniform(-3.0, 3.0, n).tolist()), tuple(draw.normal(0.0, 4.0, n).tolist())
    assert compiled(chain(n, 2), 0.7, q, v) == dynamics(chain(n, 2), 0.7, q, v)


def test_arms_side_by_side_are_as_each_alone() -> None:
    arms, payloads = (chain(3, 0), chain(3, 1)), (0.4, 1.1)
    q, v = ((0.1, -0.4, 1.0), (0.7, 0.2, -2.0)), ((1.0, 3.0, -2.0), (-0.5, 0.1, 4.0))
    both = dynamics(join(*arms), join(*payloads), join(*q), join(*v))
    alone = [dynamics(arm, *of) for arm, *of in zip(arms, payloads, q, v, strict=True)]
    assert both == join(*alone)


@given(st.sampled_from([1, 2, 4]), st.integers(0, 10_000))
def test_a_payload_moves_as_the_tip_does(n: int, seed: int) -> None:
    """The payload's share of the mass matrix is m_p J J^T, with the tip's velocity J."""
    draw = np.random.default_rng(seed)
    arm, q, v = chain(n, seed), draw.uniform(-3.0, 3.0, n), draw.normal(0.0, 2.0, n)

    def tip(angles: np.ndarray) -> np.ndarray:
        return np.array(points(arm, tuple(angles.tolist()))[-1])

    def energy(payload: float) -> float:
        M = np.zeros((n, n))
        M[np.triu_indices(n)] = dynamics(arm, payload, tuple(q.tolist()), tuple(v.tolist()))[0]
        return float(0.5 * v @ (M + np.triu(M, 1).T) @ v)

    speed = (tip(q + 1e-6 * v) - tip(q - 1e-6 * v)) / 2e-6
    assert energy(2.0) - energy(0.0) == pytest.approx(speed @ speed, rel=1e-6, abs=1e-9)


@kernel
def accelerations(arm, payload, q, v, like):  # type: ignore[no-untyped-def]
    """Of a free arm, as numpy solves for them."""
    n = len(like)
    upper, moving, pulled = dynamics(arm, payload, gather(like, q), gather(like, v))
    M, push, at = np.empty((n, n)), np.empty(n), 0
    entries, first, second = slots(upper), slots(moving), slots(pulled)
    for i in range(n):
        push[i] = first[i] + second[i]
        for j in range(i, n):
            M[i, j] = M[j, i] = entries[at]
            at += 1
    return np.linalg.solve(M, push)


@pytest.mark.compiled
@pytest.mark.parametrize("n", [1, 4, 7])
def test_an_arm_that_is_let_go_falls_as_in_mujoco(n: int) -> None:
    # On a small planet: motions that are wilder than any arm's are chaotic.
    arm, model = chain(n, 2), copy(in_mujoco(n, 2, 0.7))
    arm, model.opt.gravity = arm._replace(gravity=scale_vector(0.1, arm.gravity)), 0.1 * model.opt.gravity
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 1e-4
    data, like = mujoco.MjData(model), (0.0,) * n
    start = np.concatenate([np.zeros(n), np.linspace(-0.5, 0.5, n)])
    data.qpos[:], data.qvel[:] = start[:n], start[n:]

    def slope(_: float, state: np.ndarray) -> np.ndarray:
        q, v = state[:n].copy(), state[n:].copy()
        return np.concatenate([v, accelerations(arm, 0.7, q, v, like)])

    times = np.linspace(0.0, 2.0, 21)
    ours = solve_ivp(slope, (0.0, 2.0), start, "DOP853", times, rtol=1e-11, atol=1e-12).y[:n].T
    theirs = [data.qpos.copy()]
    for _ in times[1:]:
        mujoco.mj_step(model, data, 1000)
        theirs.append(data.qpos.copy())
    assert np.ptp(ours, axis=0).max() > 1.0
    assert np.degrees(np.abs(ours - np.array(theirs)).max()) < 1e-4
