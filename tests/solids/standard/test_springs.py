"""Compression springs."""

from math import pi

import numpy as np
import pytest

from layflat.errors import DesignError
from layflat.solids.standard.springs import SHEAR_MODULUS, SPRINGS, CompressionSpring, spring_for, wire_strength

SH_STRENGTHS = {0.5: 2480, 1.0: 2230, 2.0: 1980, 4.0: 1740, 5.0: 1660}  # EN 10270-1, min, MPa by mm


@pytest.mark.parametrize("wire", SH_STRENGTHS)
def test_the_strength_of_wire_is_that_of_the_standard(wire: float) -> None:
    assert wire_strength(wire * 1e-3) * 1e-6 == pytest.approx(SH_STRENGTHS[wire], rel=0.02)


@pytest.mark.parametrize("spring", SPRINGS[::17], ids=lambda spring: spring.designation)
def test_the_rate_is_that_of_the_energy_of_torsion_along_the_wire(spring: CompressionSpring) -> None:
    # Castigliano: U = 1/2 integral T^2/(G J) ds along the active wire, deflection = dU/dF
    radius, polar = spring.mean_diameter / 2, pi * spring.wire**4 / 32
    along = np.linspace(0.0, 2 * pi * spring.coils * radius, 1001)
    compliance = np.trapezoid(np.full_like(along, radius**2 / (SHEAR_MODULUS * polar)), along)
    assert spring.rate == pytest.approx(1 / compliance)


@pytest.mark.parametrize("spring", SPRINGS, ids=lambda spring: spring.designation)
def test_no_spring_can_be_overloaded(spring: CompressionSpring) -> None:
    assert spring.solid_length < spring.shortest < spring.free_length
    assert spring.stress(spring.solid_length) <= 0.56 * wire_strength(spring.wire) * (1 + 1e-9)
    assert spring.force(spring.free_length + 1e-3) == 0.0


@pytest.mark.parametrize(("force", "space", "outer"), [(20, 0.02, 0.015), (50, 0.03, 0.02), (300, 0.04, 0.03)])
def test_the_chosen_spring_gives_the_force_in_its_space(force: float, space: float, outer: float) -> None:
    chosen = spring_for(force, space, outer)
    assert force <= chosen.force(space) < 1.3 * force
    assert chosen.outer <= outer
    assert chosen.shortest <= space


def test_a_force_too_large_for_the_space_is_refused() -> None:
    with pytest.raises(DesignError, match="no spring gives 5000 N in 20 mm below 12 mm wide; the strongest gives"):
        spring_for(5000.0, 0.02, 0.012)
