"""Chains in space: random ones against MuJoCo, and what holds of any of them."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from layflat.jit import kernel
from layflat.lanes import join
from layflat.physics.arms.chain import Chain, Link, dynamics, frames
from layflat.physics.arms.space import Axes, Mass, Symmetric, Vector, outward, plus, with_point

mujoco: Any = pytest.importorskip("mujoco")

SIZES = range(1, 8)


def vector(x: np.ndarray) -> Vector:
    return Vector(*x.tolist())


def chain(n: int, seed: int) -> Chain:
    """A random arm: every link a few points of mass."""
    draw = np.random.default_rng(seed)
    links = []
    for _ in range(n):
        axes = Axes(*(vector(column) for column in Rotation.random(random_state=draw).as_matrix().T))
        body = Mass(0.0, Vector(0.0, 0.0, 0.0), Symmetric(0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        for _ in range(5):
            body = with_point(body, draw.uniform(0.05, 0.6), vector(draw.normal(0.0, 0.15, 3)))
        links.append(Link(axes, vector(draw.normal(0.0, 0.3, 3)), body))
    rotors = np.zeros((n, n))
    np.fill_diagonal(rotors, draw.uniform(0.0, 0.05, n))
    upper = rotors[np.triu_indices(n)].tolist()
    return Chain(tuple(links), tuple(upper), vector(draw.normal(0.0, 0.2, 3)), vector(draw.normal(0.0, 6.0, 3)))


def about_centre(body: Mass) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass, and inertia about it."""
    J, c = body.J, np.array(body.h) / body.m
    about_origin = np.array([[J.xx, J.xy, J.xz], [J.xy, J.yy, J.yz], [J.xz, J.yz, J.zz]])
    return c, about_origin - body.m * (c @ c * np.eye(3) - np.outer(c, c))


@cache
def in_mujoco(n: int, seed: int, payload: float) -> Any:
    arm, spec = chain(n, seed), mujoco.MjSpec()
    spec.option.gravity = list(arm.gravity)
    spec.compiler.balanceinertia = False
    parent, at = spec.worldbody, 0
    for i, link in enumerate(arm.links):
        body = link.body if i < n - 1 else with_point(link.body, payload, arm.tool)
        centre, J = about_centre(body)
        quat = Rotation.from_matrix(np.array(link.axes).T).as_quat(scalar_first=True)
        parent = parent.add_body(pos=list(link.place), quat=quat, mass=body.m, ipos=centre, explicitinertial=True)
        parent.fullinertia = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
        parent.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0], armature=arm.rotors[at])
        at += n - i
    parent.add_site(name="tool", pos=list(arm.tool))
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
    last = frames(chain(n, seed), tuple(q.tolist()))[-1]
    tip = plus(last.origin, outward(last.axes, chain(n, seed).tool))
    assert np.abs(np.array(tip) - data.site("tool").xpos).max() < 1e-10


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
        last = frames(arm, tuple(angles.tolist()))[-1]
        return np.array(plus(last.origin, outward(last.axes, arm.tool)))

    def energy(payload: float) -> float:
        M = np.zeros((n, n))
        M[np.triu_indices(n)] = dynamics(arm, payload, tuple(q.tolist()), tuple(v.tolist()))[0]
        return float(0.5 * v @ (M + np.triu(M, 1).T) @ v)

    speed = (tip(q + 1e-6 * v) - tip(q - 1e-6 * v)) / 2e-6
    assert energy(2.0) - energy(0.0) == pytest.approx(speed @ speed, rel=1e-6, abs=1e-9)
