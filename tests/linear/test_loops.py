"""Loops of control laws with linear models: against the laws' own formulas, and against what the whole plant does."""

import numpy as np
import pytest

import layflat as lf
from layflat.linear import linearize, loop_margins, measure_loops
from layflat.machine import parameters

control = pytest.importorskip("control")


def test_the_loop_of_a_held_joint_is_its_pressure_feedback() -> None:
    model = linearize("paper-small-joint", joints="held")
    loops, machine = measure_loops(model), model.operating_point.machine
    z = np.exp(1j * loops.omega * machine.cycle)
    mean_of_four = (1.0 + 1.0 / z + 1.0 / z**2 + 1.0 / z**3) / 4.0
    plant = control.sample_system(model, machine.cycle, "zoh")["small_differential_pressure", "small_voltage"](z)
    expected = parameters.control(machine).joints[0].close.pressure_gain * mean_of_four * plant
    assert loops.frdata[0, 0] == pytest.approx(expected, rel=0.02, abs=1e-6)


def test_margins_are_where_the_loop_is_one_and_where_it_turns() -> None:
    loops = measure_loops(linearize("paper-arm-tracking", speed="5 deg/s"))
    for j, margins in enumerate(loop_margins(loops).values()):
        assert margins is not None
        f, loop = loops.omega / (2.0 * np.pi), loops.frdata[j, j]
        assert 10 ** np.interp(np.log(margins.crossover), np.log(f), np.log10(abs(loop))) == pytest.approx(
            1.0, rel=0.05
        )
        turned = np.angle(-loop[np.argmin(abs(f - margins.crossover))], deg=True)
        assert turned == pytest.approx(margins.phase, abs=15.0)
        assert margins.phase > 30.0
        assert margins.gain > 2.0


def test_a_loop_without_margins_lets_the_arm_stick_and_slip() -> None:
    assert set(loop_margins(measure_loops(linearize("paper-arm", speed="5 deg/s"))).values()) == {None}
    ramp = np.radians(-10.0 + 5.0 * 5e-3 * np.arange(800))
    run = lf.rollout("paper-arm", np.stack([ramp, ramp], axis=1), start="-10 deg", duration="4 s")
    assert (run["velocity"].isel(time=slice(-200, None)) == 0.0).mean() > 0.2


def test_a_machine_without_a_controller_is_told_so() -> None:
    bare = lf.load("paper-arm").model_copy(update={"controller": None})
    with pytest.raises(lf.MachineError, match="has no controller"):
        measure_loops(linearize(bare, joints="held"))


def test_a_law_that_leaves_a_joint_to_friction_closes_no_loop() -> None:
    assert not measure_loops(linearize("single-joint-lift", joints="held")).frdata.any()
