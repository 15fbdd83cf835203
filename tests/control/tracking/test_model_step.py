"""Steps of the law's model, by how light the arm is."""

import numpy as np
import pytest
from scipy.linalg import eigh

from layflat.control.tracking.model import MAX_PHASE, step_count
from layflat.description.change import changed_all
from layflat.machine import Machine, load, parameters
from layflat.physics.natural_rates import natural_rates
from layflat.sim import rollout

LINK = "joint.small.link"


def lighter(times: float) -> Machine:
    """The paper's small joint with the tracking law, and so many times less to turn."""
    machine = load("paper-small-joint-fast")
    link = machine.joints["small"].planar_link
    law = load("paper-arm-tracking").controller
    light = {f"{LINK}.{key}": getattr(link, key) / times for key in ("mass", "inertia", "rotor_inertia")}
    return changed_all(machine, light | {"arm.payload": 0.0, "controller": law})


def steps(machine: Machine) -> int:
    return step_count(*parameters.plant(machine), machine.cycle)


@pytest.mark.parametrize("name", ["paper-arm-tracking", "picking-arm"])
def test_built_in_arms_have_the_usual_steps(name: str) -> None:
    assert steps(load(name)) == 2


def test_what_is_lighter_has_more_steps_and_stays_stable() -> None:
    counts = [steps(lighter(times)) for times in (1.0, 100.0, 1e3, 1e4)]
    assert counts == sorted(counts)
    assert counts[0] == 2
    for times in (100.0, 1e3):
        machine = lighter(times)
        frequency, _ = natural_rates(*parameters.plant(machine))
        assert frequency * machine.cycle / steps(machine) <= MAX_PHASE


def test_frequencies_are_those_of_masses_on_springs() -> None:
    """By SciPy's generalised eigenvalues, the elbow being where that is highest."""
    machine = load("paper-arm-tracking")
    arm, joints, around = parameters.plant(machine)
    frequency, _ = natural_rates(arm, joints, around)
    single = [natural_rates(*parameters.plant(lighter(times)))[0] for times in (1.0, 100.0)]
    assert single[1] == pytest.approx(10.0 * single[0])
    law = parameters.control(machine)
    stiffness = np.diag(
        [feedback.min_stiffness / 0.7 for feedback in law.feedback]
    )  # at three quarters of the pressure
    bends = np.radians(np.linspace(-60.0, 60.0, 31))
    masses = [parameters.mass_and_pull(arm, 0.0, [0.0, bend])[0] for bend in bends]
    highest = max(eigh(stiffness, mass, eigvals_only=True)[-1] for mass in masses) ** 0.5
    assert highest < frequency < 1.35 * highest


@pytest.mark.compiled
def test_a_joint_with_next_to_nothing_to_turn_settles() -> None:
    machine = lighter(300.0)
    assert steps(machine) > 2
    for degrees in (3.0, -40.0):
        run = rollout(machine, demand=[(0.0, (0.0,)), (0.1, (float(np.radians(degrees)),))], duration="1 s", seed=1)
        late = run.sel(time=slice(0.6, None))
        assert np.degrees(np.abs(late["angle"] - late["demand"])).max() < 0.3
