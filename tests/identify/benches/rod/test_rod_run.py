import numpy as np
import pytest

from layflat.identify.benches.rod.laws import Rod
from layflat.identify.benches.rod.run import RodLog, rod_forces

ROD = Rod(area=5e-4, area_slope=1e-3, spring=20.0, offset=3.0, base=6.0, slope=1e-5, viscous=0.0)
WEIGHTS = np.array([0.5, 0.3, 0.2])
STIFFNESS = WEIGHTS * 10.0 / np.array([1e-4, 5e-4, 2e-3])
X = 0.02 * np.sin(np.linspace(0.0, 4 * np.pi, 2000))


def rod_log(first: float = 206.0) -> RodLog:
    return RodLog(X, np.zeros_like(X), np.full_like(X, 4e5), first)


def test_a_rod_that_slips_asks_for_gas_spring_and_all_of_the_friction() -> None:
    force = rod_forces([ROD], WEIGHTS[None], STIFFNESS[None], rod_log())[0]
    for i, way in ((500, -1.0), (1000, 1.0), (1500, -1.0)):
        expected = (5e-4 + 1e-3 * X[i]) * 4e5 + 3.0 + 20.0 * X[i] + way * 10.0
        assert force[i] == pytest.approx(expected, abs=1e-9)


def test_the_first_sample_is_met_as_far_as_the_friction_allows() -> None:
    for first, expected in ((206.0, 206.0), (150.0, 193.0), (300.0, 213.0)):
        force = rod_forces([ROD], WEIGHTS[None], STIFFNESS[None], rod_log(first))[0]
        assert force[0] == pytest.approx(expected, abs=1e-9)


def test_candidates_do_not_depend_on_each_other() -> None:
    rods = [ROD._replace(base=float(base)) for base in np.linspace(0.0, 9.0, 7)]
    many = rod_forces(rods, np.tile(WEIGHTS, (7, 1)), np.tile(STIFFNESS, (7, 1)), rod_log())
    for rod, found in zip(rods, many, strict=True):
        np.testing.assert_array_equal(found, rod_forces([rod], WEIGHTS[None], STIFFNESS[None], rod_log())[0])
