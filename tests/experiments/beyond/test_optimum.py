from math import radians, sqrt

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.experiments.beyond import Optimum, settling_bound, simulate_tracking_law
from layflat.experiments.beyond.search import Shooting
from layflat.machine import Machine, changed, load, parameters
from layflat.sim import rollout
from layflat.sim.metrics import TIP_BAND, tip_settling
from research.settling_floor import mass_matrix, settling_floor

JOINT = load("paper-small-joint-fast")
START, END = radians(-20), radians(20)


@pytest.fixture(scope="module")
def optimum() -> Optimum:
    return settling_bound(JOINT, START, "20 deg")


def test_it_lies_between_the_floor_and_the_tracking_law(optimum: Optimum) -> None:
    step = Shooting(JOINT, (START,), (END,))
    law = simulate_tracking_law(step, TIP_BAND)
    assert law is not None
    assert settling_floor(step, TIP_BAND) <= optimum.settling < 0.95 * law.cycles * JOINT.cycle


def test_its_openings_bring_the_tip_there_in_a_rollout(optimum: Optimum) -> None:
    rest = round(optimum.step_time / JOINT.cycle)
    openings = np.zeros((round(1.5 / JOINT.cycle), 1))
    openings[rest : rest + len(optimum.openings)] = optimum.openings
    assert np.abs(openings).max() <= 1.0
    run = rollout(JOINT, duration=1.5, start=START, opening=openings, noise=False)
    run["demand"] = run["demand"].copy(
        data=np.where(run["time"].to_numpy()[:, None] < optimum.step_time - 1e-9, START, END)
    )
    assert tip_settling(run, optimum.step_time, 1.5, TIP_BAND) == pytest.approx(optimum.settling)
    assert tip_settling(optimum.run, optimum.step_time, np.inf, TIP_BAND) == pytest.approx(optimum.settling)
    assert float(optimum.run["time"][-1]) >= optimum.step_time + optimum.settling + 0.95


def test_it_is_the_same_every_time(optimum: Optimum) -> None:
    again = settling_bound(JOINT, START, END)
    assert again.settling == optimum.settling
    assert np.array_equal(again.openings, optimum.openings)


def ideal() -> Machine:
    """A joint that is a double integrator with dry friction: its air follows the valve at once."""
    values = {
        "valve.conductance": 4.6e-7,
        "valve.dither.amplitude": 0.0,
        "valve.friction": 0.0,
        "valve.natural_frequency": 800.0,
        "joint.small.losses.damping_time": 0.0,
        "joint.small.hose.loss_fraction": 0.0,
        "joint.small.brake.viscous": 0.0,
    }
    machine = load("paper-small-joint")
    for path, value in values.items():
        machine = changed(machine, path, value)
    return machine


def test_a_double_integrator_takes_its_known_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "layflat.experiments.beyond.simulate_tracking_law", lambda *_: None
    )  # slow with so fast a valve
    machine = ideal()
    torque = parameters.torque_constant(machine.joint["small"]) * machine.supply.pressure_gauge
    inertia, friction = mass_matrix(machine, 0.0)[0, 0], machine.joint["small"].brake.torque
    faster, slower = (torque - friction) / inertia, (torque + friction) / inertia
    band = TIP_BAND / machine.joint["small"].planar_link.length
    # Speed up, brake, and be within the band from its near side on, coming to rest at its far side.
    whole = sqrt(2.0 * (END - START + band) * (faster + slower) / (faster * slower))
    known = whole - sqrt(4.0 * band / slower)
    assert known - 2 * machine.cycle < settling_floor(Shooting(machine, (START,), (END,)), TIP_BAND) < known
    bound = settling_bound(machine, START, END).settling
    assert known < bound < known + 3.5 * machine.cycle  # spools and air take some time all the same


def test_a_heavier_payload_takes_longer(optimum: Optimum) -> None:
    assert settling_bound(JOINT, START, END, payload="4 kg").settling > 1.1 * optimum.settling


def test_a_goal_outside_the_stroke_is_refused() -> None:
    with pytest.raises(InputError, match="start"):
        settling_bound(JOINT, START, "80 deg")
