"""Screws, nuts, washers and rods."""

from itertools import pairwise

import pytest

from layflat.errors import DesignError
from layflat.solids.standard.screws import (
    Screw,
    nut,
    nut_engagement,
    screw,
    screw_for,
    screw_lengths,
    threaded_rod,
    washer,
)
from layflat.solids.standard.threads import THREADS, thread

MM = 1e-3
STRESS_AREAS = {
    "M2.5": 3.39,
    "M3": 5.03,
    "M4": 8.78,
    "M5": 14.2,
    "M6": 20.1,
    "M8": 36.6,
    "M10": 58.0,
    "M12": 84.3,
}  # ISO 898-1, mm2
TABLE_MASSES = {("M4", 12): 2.1, ("M5", 16): 4.0, ("M6", 20): 7.0, ("M8", 30): 17.1}  # makers' lists of ISO 4762, g


@pytest.mark.parametrize("name", THREADS)
def test_holes_and_heads_enclose_their_thread(name: str) -> None:
    size = thread(name)
    assert size.tapping_hole < size.pitch_diameter < size.diameter < size.washer_hole <= size.clearance_hole
    assert size.clearance_hole < size.head_diameter <= size.washer_diameter
    assert size.socket < size.head_diameter
    assert size.socket_depth < size.head_height
    assert size.diameter < size.nut_flats < size.washer_diameter


@pytest.mark.parametrize("name", THREADS)
def test_a_tapping_drill_is_the_diameter_less_the_pitch(name: str) -> None:
    size = thread(name)
    assert size.tapping_hole == pytest.approx(size.diameter - size.pitch, abs=0.06 * MM)


@pytest.mark.parametrize("name", THREADS)
def test_stress_areas_are_those_of_the_standard(name: str) -> None:
    assert thread(name).stress_area * 1e6 == pytest.approx(STRESS_AREAS[name], rel=0.004)


def test_sizes_grow_with_the_thread() -> None:
    keys = ("pitch", "tapping_hole", "clearance_hole", "head_diameter", "socket", "nut_flats", "washer_diameter")
    for smaller, larger in pairwise(THREADS.values()):
        assert all(getattr(smaller, key) < getattr(larger, key) for key in keys)


def test_an_m5_is_the_one_of_the_standards() -> None:
    size = thread("M5")
    sizes = (size.head_diameter, size.head_height, size.socket, size.tapping_hole, size.clearance_hole)
    assert sizes == pytest.approx((8.5 * MM, 5 * MM, 4 * MM, 4.2 * MM, 5.5 * MM))
    assert screw("M5", 0.016).designation == "ISO 4762 M5 x 16 - A2-70"
    assert nut("M5").designation == "ISO 4032 M5 - A2-70"
    assert washer("M5").designation == "ISO 7089 5 - 200 HV - A2"
    assert threaded_rod("M6", 0.15).designation == "DIN 976-1 M6 x 150 - A2-70"
    assert threaded_rod("M6", 0.0333503).designation == "DIN 976-1 M6 x 33.4 - A2-70"


@pytest.mark.parametrize(("size", "length"), TABLE_MASSES)
def test_masses_agree_with_makers_lists(size: str, length: int) -> None:
    assert screw(size, length * MM).mass * 1e3 == pytest.approx(TABLE_MASSES[size, length], rel=0.06)


def test_a_longer_screw_weighs_more_by_its_shank() -> None:
    masses = [screw("M6", length).mass for length in screw_lengths("M6")]
    assert all(lighter < heavier for lighter, heavier in pairwise(masses))


def test_a_screw_that_does_not_exist_is_refused_with_those_that_do() -> None:
    with pytest.raises(DesignError, match=r"unknown size 'M7'; known sizes are M2\.5, M3, M4, M5, M6, M8, M10, M12"):
        screw("M7", 0.02)
    with pytest.raises(DesignError, match=r"there is no ISO 4762 M5 x 17; lengths of M5 are 8, 10, .* 45, 50 mm"):
        screw("M5", 0.017)


@pytest.mark.parametrize("name", THREADS)
@pytest.mark.parametrize("grip", [0.002, 0.0055, 0.011])
def test_the_chosen_screw_is_the_shortest_that_engages(name: str, grip: float) -> None:
    chosen = screw_for(grip, name)
    assert chosen.length >= grip + 1.5 * thread(name).diameter - 1e-6
    shorter = [length for length in screw_lengths(name) if length < chosen.length]
    assert all(length < grip + 1.5 * thread(name).diameter for length in shorter)


def test_a_screw_stands_out_of_its_nut() -> None:
    chosen = screw_for(0.010, "M5", nut_engagement("M5"))
    assert chosen == Screw(thread("M5"), 0.020)  # 10 + 4.7 + 1.6 = 16.3 mm


def test_too_thick_parts_are_refused() -> None:
    with pytest.raises(DesignError, match="no ISO 4762 M4 is 56 mm long; the longest is 40 mm"):
        screw_for(0.050, "M4")
    with pytest.raises(DesignError, match="a threaded rod of 3 m; rods are sold in 1 and 2 m"):
        threaded_rod("M6", 3.0)


@pytest.mark.parametrize("name", THREADS)
def test_a_thin_nut_is_as_light_as_it_is_low(name: str) -> None:
    low, high = nut(name, thin=True), nut(name)
    assert 0.5 * low.thread.diameter <= low.height < high.height
    assert low.mass / high.mass == pytest.approx(low.height / high.height)
    assert low.designation == f"ISO 4035 {name} - A2-025"
