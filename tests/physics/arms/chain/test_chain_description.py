"""Chains as files describe them."""

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from layflat.description.change import changed_all, value_at
from layflat.errors import InputError, MachineError
from layflat.lanes import leaves
from layflat.machine import Machine, load
from layflat.machine.model import build
from layflat.machine.parameters import arm, mass_and_pull
from layflat.motion.kinematics import tip_position
from layflat.physics.arms.chain import axes_along, axes_from_angles
from layflat.physics.arms.chain.space import Axes
from tests.physics.arms.chain.chains import as_chain, described, metres, random_arm

CHAINED = as_chain()
SIX = (0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)  # an inertia as a file gives it

angles = st.floats(-3.0, 3.0)


def test_a_plane_arm_said_in_space_has_the_same_masses() -> None:
    planar = load("paper-arm-fast")
    for q in ([0.0, 0.0], [0.7, -1.0], [-1.0, 0.4]):
        here, there = mass_and_pull(arm(CHAINED), 1.3, q), mass_and_pull(arm(planar), 1.3, q)
        assert here[0] == pytest.approx(there[0], rel=1e-12)
        assert here[1] == pytest.approx(0.0, abs=1e-12)
        x, y, z = tip_position(CHAINED, np.array(q))
        assert (x, y) == pytest.approx(tip_position(planar, np.array(q)), rel=1e-12)
        assert z == 0.0


def columns(axes: Axes) -> np.ndarray:
    return np.array(axes).T


@given(st.tuples(angles, angles, angles))
def test_turns_are_about_the_axes_of_the_frame_around_one_after_the_other(turn: tuple[float, float, float]) -> None:
    assert columns(axes_from_angles(turn)) == pytest.approx(Rotation.from_euler("xyz", turn).as_matrix(), abs=1e-12)


@given(st.tuples(angles, angles, angles).filter(lambda axis: np.linalg.norm(axis) > 1e-3))
def test_z_is_turned_towards_an_axis(axis: tuple[float, float, float]) -> None:
    found = columns(axes_along(axis))
    assert found.T @ found == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(found) == pytest.approx(1.0)
    assert found[:, 2] == pytest.approx(np.array(axis) / np.linalg.norm(axis), abs=1e-12)


@given(st.tuples(angles, angles, angles))
def test_one_frame_for_a_link_is_as_good_as_another(turn: tuple[float, float, float]) -> None:
    S = Rotation.from_euler("xyz", turn)
    chained = chain_of(CHAINED)
    first, second = chained["link"]["large"], chained["link"]["small"]
    told: Any = CHAINED.arm
    part, after = told.link["large"], told.link["small"]
    J = S.inv().as_matrix() @ np.diag(part.inertia) @ S.as_matrix()
    first |= {
        "rotation": radians_of(S),
        "axis": S.inv().apply(part.axis).tolist(),
        "centre": metres(*S.inv().apply(part.centre).round(9).tolist()),
        "inertia": [
            f"{round(float(J[i, j]), 11)!r} kg m^2" for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        ],
    }
    second |= {
        "position": metres(*S.inv().apply(after.position).round(9).tolist()),
        "rotation": radians_of(S.inv() * Rotation.from_euler("xyz", after.rotation)),
    }
    text, sources = described("paper-arm-fast", arm=chained)
    other = build(text, sources, "turned")
    for q in ([0.0, 0.0], [0.7, -1.0]):
        assert tip_position(other, np.array(q)) == pytest.approx(tip_position(CHAINED, np.array(q)), abs=1e-7)
        mass, _ = mass_and_pull(arm(other), 1.0, q)
        assert mass == pytest.approx(mass_and_pull(arm(CHAINED), 1.0, q)[0], rel=1e-6)


def radians_of(turn: Rotation) -> list[str]:
    return [f"{round(angle, 8)!r} rad" for angle in turn.as_euler("xyz").tolist()]


def chain_of(machine: Machine) -> dict[str, Any]:
    """What the chain's file says, in plain values."""
    part: Any = machine.arm
    found = {
        name: {
            "axis": list(link.axis),
            "position": metres(*link.position),
            "rotation": [f"{angle!r} rad" for angle in link.rotation],
            "mass": f"{link.mass!r} kg",
            "centre": metres(*link.centre),
            "inertia": [f"{moment!r} kg m^2" for moment in link.inertia],
            "rotor_inertia": f"{link.rotor_inertia!r} kg m^2",
        }
        for name, link in part.link.items()
    }
    return {
        "kind": "chain",
        "joints": list(part.joints),
        "link": found,
        "tool": metres(*part.tool),
        "gravity": [f"{g!r} m/s^2" for g in part.gravity],
        "payload": "1 kg",
    }


@pytest.mark.parametrize(
    ("link", "key", "value", "said"),
    [
        ("large", "axis", None, "arm.link.large.axis: "),
        ("large", "axis", [0.0, 0.0, 0.0], "axis has no direction"),
        ("small", "inertia", ["0 kg m^2"] * 3, "principal moment 0 kg m2; those of a body are positive"),
        ("small", "inertia", ["1 kg m^2", "1 kg m^2", "-1 kg m^2"], "principal moment -1 kg m2"),
        ("small", "inertia", ["1 kg m^2", "1 kg m^2", "3 kg m^2"], "none can be greater than the other two together"),
        ("small", "inertia", ["1 kg m^2"] * 4, "inertia has 4 values"),
        ("small", "mass", "0 kg", "arm.link.small.mass: "),
        ("gone", "mass", "1 kg", "link names 'gone', which is not in joints"),
    ],
)
def test_links_that_can_not_be_are_told(link: str, key: str, value: Any, said: str) -> None:
    chained = chain_of(CHAINED)
    part = chained["link"].setdefault(link, dict(chained["link"]["large"]))
    part.pop(key)
    if value is not None:
        part[key] = value
    text, sources = described("paper-arm-fast", arm=chained)
    with pytest.raises(MachineError, match=re.escape(said)):
        build(text, sources, "bad")


def test_more_joints_than_there_are_laws_for() -> None:
    with pytest.raises(MachineError, match="at most 7"):
        random_arm(8, 0)


def test_a_link_that_is_missing_is_told() -> None:
    chained = chain_of(CHAINED)
    del chained["link"]["small"]
    text, sources = described("paper-arm-fast", arm=chained)
    with pytest.raises(MachineError, match=r"describe it as \[arm.link.small\]"):
        build(text, sources, "bad")


def test_a_plane_arm_needs_the_links_of_its_joints() -> None:
    text, sources = described("paper-small-joint")
    del text["joint"]["small"]["link"]
    with pytest.raises(MachineError, match=r"has no link, which a planar arm needs; add \[joint.small.link\]"):
        build(text, sources, "bad")


def test_runs_of_an_ensemble_may_have_other_links() -> None:
    keys = "small.mass", "large.centre.0", "small.inertia.1", "small.inertia.2"
    names, some = [f"arm.link.{key}" for key in keys], np.array([1.0, 1.1])
    many = changed_all(CHAINED, {name: value_at(CHAINED, name) * some for name in names})
    one = changed_all(CHAINED, {name: value_at(CHAINED, name) * 1.1 for name in names})
    pairs = zip(leaves(arm(many)), leaves(arm(one)), strict=True)
    assert all(np.broadcast_to(found, 2)[1] == pytest.approx(float(alone), abs=1e-15) for found, alone in pairs)
    with pytest.raises(InputError, match="principal moment"):
        changed_all(CHAINED, {"arm.link.small.inertia.2": np.array([1e-3, -1.0])})
