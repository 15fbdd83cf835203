import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.identify.benches.vessel.gas import GASES_BY_NAME
from layflat.identify.benches.vessel.laws import film_properties, forced_convection, jet_diameter, natural_convection

AIR, CP_AIR = GASES_BY_NAME["air"], 1005.0
densities = st.floats(0.05, 200.0)
temperatures = st.floats(200.0, 400.0)


def test_natural_convection_is_that_of_the_nusselt_number() -> None:
    # By hand, for a vessel 0.3 m across: Ra = g beta dT L^3 rho^2 c_p/(mu k) and h = 0.13 k/L Ra^(1/3).
    T, T_w, rho, L = 280.0, 300.0, 2.0, 0.3
    T_f, mu, k = film_properties(AIR, T, T_w)
    assert T_f == 290.0
    assert (mu, k) == pytest.approx((1.81e-5, 0.0256), rel=0.01)
    Ra = 9.81 / T_f * 20.0 * L**3 * (rho * T / T_f) ** 2 * CP_AIR / (mu * k)
    assert natural_convection(0.13, AIR, rho, CP_AIR, T, T_w) == pytest.approx(0.13 * k / L * Ra ** (1 / 3), rel=1e-12)


@given(densities, st.floats(1.0, 30.0))
def test_it_grows_as_pressure_to_two_thirds_and_temperature_to_one_third(rho: float, dT: float) -> None:
    h = natural_convection(0.13, AIR, rho, CP_AIR, 290.0 + dT, 290.0 - dT)
    denser = natural_convection(0.13, AIR, 8.0 * rho, CP_AIR, 290.0 + dT, 290.0 - dT)
    assert denser == pytest.approx(4.0 * h, rel=1e-9)
    # The film keeps its temperature, but the gas at it is as dense as rho T / T_f.
    nearer = natural_convection(
        0.13, AIR, rho * (290.0 + dT) / (290.0 + dT / 8), CP_AIR, 290.0 + dT / 8, 290.0 - dT / 8
    )
    assert nearer == pytest.approx(0.5 * h, rel=1e-9)


@given(densities, temperatures)
def test_it_ends_with_the_difference(rho: float, T: float) -> None:
    assert natural_convection(0.13, AIR, rho, CP_AIR, T, T) == 0.0


def test_a_jet_carries_heat_only_on_its_way_in() -> None:
    d = jet_diameter(3.14159e-6)
    assert d == pytest.approx(2e-3, rel=1e-3)
    h = forced_convection(0.56, AIR, 1e-3, d, 0.2, 293.15, 293.15)
    Re = 4e-3 / (3.14159 * AIR.viscosity * d)
    assert h == pytest.approx(0.56 * AIR.conductivity / 0.2 * Re**0.67, rel=1e-5)
    assert forced_convection(0.56, AIR, -1e-3, d, 0.2, 293.15, 293.15) == 0.0
