import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.identify.benches.rod.laws import Rod, slip_force, smooth_force

ROD = Rod(
    area=5e-4,
    area_slope=1e-3,
    spring=20.0,
    offset=3.0,
    base=6.0,
    slope=1e-5,
    viscous=80.0,
    weights=(1.0,),
    stiffness=(1e5,),
)


def test_force_by_hand() -> None:
    # 5e-4 * 4e5 + 1e-3 * 0.01 * 4e5 + 3 + 20 * 0.01 + 80 * 0.05
    assert smooth_force(ROD, 0.01, 0.05, 4e5) == pytest.approx(200.0 + 4.0 + 3.0 + 0.2 + 4.0)


@given(st.floats(-0.05, 0.05), st.floats(0.0, 8e5))
def test_gas_gives_back_the_work_that_was_done_on_it(x: float, p: float) -> None:
    """At constant pressure the force depends on where the rod is alone, whichever way it goes."""
    still = ROD._replace(viscous=0.0)
    assert smooth_force(still, x, 0.1, p) == smooth_force(still, x, -0.1, p)


def test_friction_grows_with_pressure_above_that_outside() -> None:
    assert slip_force(ROD, 2e5) == pytest.approx(8.0)
    assert slip_force(ROD, -0.5e5) == pytest.approx(6.0)
