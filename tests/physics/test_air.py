from math import isclose

from layflat.physics import air


def test_specific_heats_differ_by_the_gas_constant() -> None:
    assert isclose(air.CP - air.CV, air.GAS_CONSTANT)
    assert isclose(air.CP / air.CV, air.GAMMA)


def test_densities_follow_from_the_gas_law() -> None:
    assert isclose(air.NORMAL_DENSITY, 1.293, rel_tol=1e-3)
    dry = 1e5 / (air.GAS_CONSTANT * air.REFERENCE_TEMPERATURE)
    # The reference air of ISO 8778 is moist, hence a little lighter.
    assert 0.99 * dry < air.REFERENCE_DENSITY < dry
