"""The tracking law on an arm in space, with payloads that it does not know: benchmarks/picking.py, in small."""

import numpy as np
import pytest

from benchmarks.picking import CLOSE, followed, lines, moves, places, settled
from layflat.machine import load, parameters
from layflat.motion.inverse import InverseKinematics
from layflat.motion.kinematics import Kinematics
from layflat.motion.limits import joint_capabilities
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble

PICKING = load("picking-arm")


@pytest.mark.compiled
def test_the_tip_comes_to_places_within_a_second() -> None:
    postures = places(PICKING, 33, seed=11)
    tips = Kinematics(PICKING).tip(postures)
    assert np.all(np.ptp(tips, axis=0) > 0.5 * np.ptp(InverseKinematics(PICKING).tips, axis=0))
    times = settled(PICKING, moves(postures, 1), seed=12)
    assert np.mean(times <= 1.0) >= 0.95
    assert np.median(times) < 0.5


@pytest.mark.compiled
def test_straight_lines_are_followed() -> None:
    along = lines(PICKING, 8, seed=13)
    assert np.all(followed(PICKING, along, seed=14) < CLOSE)
    # With nothing to carry the wrist weighs next to nothing: friction would hold it, and errors would not bring it on.
    assert np.all(followed(PICKING, along, seed=14, heaviest=0.0) < CLOSE)


FAR_AND_FAST = {
    # It folds as its base turns, which spins it up; it unfolds on the way, where it is heaviest; all joints at once.
    "folds": ([43.0, -14.9, 32.4, 53.2], [-51.8, -12.3, -16.3, -34.8]),
    "unfolds": ([-48.6, 33.6, 29.6, 9.5], [52.3, 13.8, -3.0, 4.5]),
    "lifts": ([-32.4, -52.4, 14.8, -18.9], [43.2, 45.9, 43.2, -0.2]),
}


@pytest.mark.compiled
@pytest.mark.parametrize("way", FAR_AND_FAST)
def test_far_moves_of_all_joints_stay_within_their_strokes_whatever_is_carried(way: str) -> None:
    start, end = np.radians(FAR_AND_FAST[way])
    move = Scenario(demand=[(0.0, start.tolist()), (0.3, end.tolist())], duration=1.6)
    carried = {"scenario.payload": np.linspace(0.0, 1.0, 16)}
    runs = ensemble(PICKING, move, carried, tip_band=CLOSE, traces=("angle",))
    assert np.abs(runs["angle"].to_numpy()).max() < np.radians(56.0)
    assert runs["tip_settling"].to_numpy()[:, -1].max() < 1.0


def test_no_joint_is_too_light_for_feedback() -> None:
    """The stiffness of feedback is that of the hoses, about, where inertia gives less; planar arms are heavier."""
    for name, heavy in (("picking-arm", [1, 1, 1, 0]), ("paper-arm-tracking", [1, 1])):
        machine = load(name)
        settings = parameters.control(machine, closed_loop=True)
        inertia, _ = parameters.mass_and_pull(parameters.arm(machine), 0.1, [0.0] * len(machine.joints))
        most = joint_capabilities(machine).stiffness
        for j, feedback in enumerate(settings.feedback):
            assert 0.5 * most[j] < feedback.min_stiffness < 1.2 * most[j]
            assert (feedback.stiffness * inertia[j, j] > feedback.min_stiffness) == bool(heavy[j])
