"""Fittings of air and the sensor of the angle."""

from itertools import pairwise

import pytest

from layflat.errors import DesignError
from layflat.solids.standard.fittings import AIR_PORTS, ANGLE_SENSOR, TUBE_SIZES, HollowScrew, port, push_in_fitting


@pytest.mark.parametrize("name", AIR_PORTS)
def test_a_bore_leaves_a_wall_below_the_thread(name: str) -> None:
    size = port(name)
    assert size.bore < size.tapping_hole < size.diameter < size.flange
    assert size.bore + 1e-3 < size.diameter - 1.3 * size.pitch
    assert size.tapping_hole == pytest.approx(size.diameter - size.pitch, abs=0.06e-3)


def test_pipe_threads_are_those_of_iso_228() -> None:
    assert port("G1/8").pitch == pytest.approx(25.4e-3 / 28, abs=1e-6)
    assert port("G1/4").pitch == pytest.approx(25.4e-3 / 19, abs=1e-6)


@pytest.mark.parametrize("name", AIR_PORTS)
def test_fittings_grow_with_their_tubing_and_weigh_what_brass_does(name: str) -> None:
    fittings = [push_in_fitting(name, outer) for outer, _ in TUBE_SIZES[name]]
    assert all(0.003 < fitting.mass < 0.03 for fitting in fittings)
    for smaller, larger in pairwise(fittings):
        assert smaller.mass < larger.mass
        assert smaller.tube_inner < larger.tube_inner
    assert fittings[0].designation == f"push-in fitting {name} - {TUBE_SIZES[name][0][0] * 1e3:g}"


def test_a_hollow_screw_is_longer_by_its_grip() -> None:
    thin, thick = HollowScrew(port("G1/8"), 0.004), HollowScrew(port("G1/8"), 0.009)
    assert thick.length - thin.length == pytest.approx(0.005)
    assert thick.mass > thin.mass
    assert thin.designation == "hollow screw G1/8 x 11.5 - brass"


def test_unknown_ports_and_tubing_are_refused() -> None:
    with pytest.raises(DesignError, match="unknown port 'G1/2'; known are M5, G1/8, G1/4"):
        port("G1/2")
    with pytest.raises(DesignError, match="no fitting M5 takes tubing of 8 mm; tubing of M5 is 4, 6 mm"):
        push_in_fitting("M5", 0.008)


def test_the_sensor_fits_its_pilot() -> None:
    assert ANGLE_SENSOR.shaft_diameter < ANGLE_SENSOR.pilot_diameter < ANGLE_SENSOR.body_diameter
