from math import radians

import numpy as np
import pytest

from layflat.bridge.view.scenery import scenery, stroke_arcs
from layflat.machine import changed, load
from tests.physics.arms.chain.chains import as_chain, random_arm


def test_gravity_pulls_downwards_however_the_base_lies() -> None:
    for seed in range(5):
        machine = random_arm(3, seed)
        shown = scenery(machine, [0.0] * 3)
        assert shown.level @ shown.arm.gravity == pytest.approx([0.0, 0.0, -9.81], abs=1e-9)
        assert shown.level.T @ shown.level == pytest.approx(np.eye(3), abs=1e-12)


def test_hanging_upside_down_and_without_gravity() -> None:
    up = changed(as_chain(), "arm.gravity", (0.0, 0.0, 9.81))
    none = changed(as_chain(), "arm.gravity", (0.0, 0.0, 0.0))
    assert np.linalg.det(scenery(up, [0.0, 0.0]).level) == pytest.approx(1.0)
    assert scenery(up, [0.0, 0.0]).level[2, 2] == -1.0
    assert np.array_equal(scenery(none, [0.0, 0.0]).level, np.eye(3))


def test_the_floor_is_below_everything_and_the_arm_stands_on_it() -> None:
    shown = scenery(load("paper-arm"), [0.3, -0.4])
    bodies = [piece for piece in shown.placed([0.3, -0.4]) if piece.of == "joint"]
    lowest = min(float(piece.position[2]) - 0.5 * piece.size[1] for piece in bodies)
    assert shown.floor == pytest.approx(lowest - 0.02)
    frame, post = shown.pieces[0]
    assert frame == 0
    assert post.position[2] - 0.5 * post.size[1] == pytest.approx(shown.floor)


def test_frames_follow_the_angles_and_the_last_is_the_tool() -> None:
    machine = as_chain()
    shown, planar = scenery(machine, [0.0, 0.0]), load("paper-arm-fast")
    first, second = (joint.planar_link.length for joint in planar.joints.values())
    angles = [0.4, 0.3]
    turned = angles[0] + angles[1] + planar.arm.elbow
    wanted = [first * np.cos(0.4) + second * np.cos(turned), first * np.sin(0.4) + second * np.sin(turned), 0.0]
    assert shown.tip(angles) == pytest.approx(wanted)
    assert len(shown.frames(angles)) == 4


def test_arcs_show_the_strokes_about_the_joint() -> None:
    machine = load("paper-arm")
    shown = scenery(machine, [0.0, 0.0])
    works, stops = stroke_arcs(shown, 1)
    link, joint = shown.arm.links[1], list(machine.joints.values())[1]
    radii = np.linalg.norm(works - link.place, axis=2)
    assert radii == pytest.approx(np.full(radii.shape, radii[0, 0]))
    local = (np.array([works[0, 0], works[-1, 1]]) - link.place) @ link.axes
    turns = np.degrees(np.arctan2(local[:, 1], local[:, 0]))
    assert turns == pytest.approx(np.degrees(joint.stops.working_stroke / 2) * np.array([-1.0, 1.0]))
    assert len(stops) > 2
    assert joint.stops.mechanical_stroke > radians(10.0)
