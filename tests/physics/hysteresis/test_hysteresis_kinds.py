"""What holds for every kind of hysteresis, whatever its law."""

from collections.abc import Callable
from math import radians
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import ValidationError

from layflat.lanes import mapped
from layflat.machine import Machine, changed, load
from layflat.machine.parameters import hose
from layflat.motion.scenario import Scenario
from layflat.physics.hysteresis import HYSTERESIS, at_rest, elasto_slip, loaded, stored, torques, turned
from layflat.sim import rollout
from layflat.sim.ensemble.parallel import simulate_traces

Floats = NDArray[np.float64]
LIMIT, P_G = 10.0, 3e5
PRESSURE = {"reference_pressure_gauge": "3 bar", "pressure_free": 0.25}
SLIP: dict[str, Any] = {"kind": "elasto-slip", "deflections": ["1 deg", "6 deg"], "weights": [0.4, 0.6]}
CREEP: dict[str, Any] = {
    "kind": "creep",
    "deflection": "2 deg",
    "per_decade": 0.1,
    "first": "10 ms",
    "last": "10 s",
    "elements": 3,
}
DESCRIBED: dict[str, dict[str, Any]] = {
    "elasto-slip": SLIP,
    "elasto-slip-spectrum": {"first": "0.3 deg", "last": "12 deg", "elements": 6, "slope": 0.5},
    "bouc-wen": {"deflection": "2 deg", "beta": 0.8, "exponent": 1.4},
    "maxwell": {"deflection": "2 deg", "times": ["20 ms", "1 s"], "weights": [0.5, 0.2]},
    "creep": CREEP,
    "parallel": {"parts": {"slip": SLIP, "creep": CREEP, "smooth": {"kind": "bouc-wen", "deflection": "1 deg"}}},
}
RATE_INDEPENDENT = ("elasto-slip", "elasto-slip-spectrum", "bouc-wen")
SMALL = "joint.small.losses"


def described(kind: str, **changes: Any) -> Any:
    return HYSTERESIS.named(kind).description.model_validate({"kind": kind, **PRESSURE, **DESCRIBED[kind], **changes})


def losing(kind: str, **changes: Any) -> Any:
    return HYSTERESIS.parameters(described(kind, **changes), LIMIT)


def walk(loss: Any, path: Floats, h: float = 1e-3, p_g: float = P_G) -> Floats:
    """Torque at every point of a path that starts at an untouched hose."""
    state, found = at_rest(loss), [0.0]
    for turn in np.diff(path):
        state = turned(loss, state, float(turn), p_g, h)
        found.append(float(np.sum(torques(loss, state))))  # `sum` adds other numbers than NumPy's less exactly
    return np.array(found)


each_kind = pytest.mark.parametrize("kind", DESCRIBED)


def test_every_kind_is_tried_here() -> None:
    assert {kind.name for kind in HYSTERESIS} >= set(DESCRIBED)
    assert all(kind.name in DESCRIBED for kind in HYSTERESIS if kind.parameters.__module__.startswith("layflat."))


@each_kind
@given(
    st.lists(st.tuples(st.floats(-0.05, 0.05), st.floats(0.0, 6e5), st.floats(1e-4, 1.0)), min_size=1, max_size=20),
    st.floats(0.0, 1.0),
)
def test_no_energy_is_made(kind: str, steps: list[tuple[float, float, float]], share: float) -> None:
    loss = losing(kind)
    state = loaded(loss, P_G, share)
    for turn, p_g, h in steps:
        before, state = state, turned(loss, state, turn, p_g, h)
        gained = stored(loss, state) - stored(loss, before)
        assert sum(torques(loss, state)) * turn - gained >= -1e-9 * (1.0 + abs(gained))


@each_kind
def test_a_large_slow_motion_meets_the_loss_and_nothing_else(kind: str) -> None:
    away = np.linspace(0.0, 2.0, 4001)
    slowly = walk(losing(kind), away, np.inf)[-1]
    shares = {"maxwell": 0.0, "creep": 0.0, "parallel": 2.0}
    assert slowly == pytest.approx(shares.get(kind, 1.0) * LIMIT, rel=1e-3, abs=1e-6)
    if kind in RATE_INDEPENDENT:
        assert walk(losing(kind), away, p_g=0.0)[-1] == pytest.approx(0.25 * LIMIT, rel=1e-3)
        assert walk(losing(kind), away, p_g=-1e5)[-1] == pytest.approx(0.25 * LIMIT, rel=1e-3)


@each_kind
def test_both_ways_are_alike(kind: str) -> None:
    path = np.cumsum(np.sin(np.linspace(0.0, 9.0, 200)) * 0.004)
    assert walk(losing(kind), -path) == pytest.approx(-walk(losing(kind), path), abs=1e-12)


@pytest.mark.parametrize("slope", [-1.5, 0.0, 0.7])
def test_the_weights_of_a_spectrum_go_with_a_power_of_the_deflection(slope: float) -> None:
    deflections, weights = elasto_slip.spectrum_elements(described("elasto-slip-spectrum", slope=slope))
    assert sum(weights) == pytest.approx(1.0)
    assert deflections[-1] / deflections[0] == pytest.approx(40.0)
    assert np.diff(np.log(deflections)) == pytest.approx(np.log(40.0) / 5)
    assert np.log(weights) - np.log(weights[0]) == pytest.approx(slope * np.log(np.array(deflections) / deflections[0]))


@pytest.mark.parametrize("kind", RATE_INDEPENDENT)
def test_speed_does_not_matter_where_the_law_has_no_time(kind: str) -> None:
    path = np.cumsum(np.sin(np.linspace(0.0, 9.0, 50)) * 0.01)
    assert np.array_equal(walk(losing(kind), path, 1e-4), walk(losing(kind), path, 10.0))


@each_kind
def test_a_hose_without_losses_has_parameters_that_are_zero(kind: str) -> None:
    loss = mapped(losing(kind), lambda _: 0.0)
    assert not walk(loss, np.array([0.0, 0.1, -0.2, 0.3])).any()
    assert stored(loss, at_rest(loss)) == 0.0


@each_kind
def test_what_is_loaded_carries_a_share_of_what_it_can(kind: str) -> None:
    loss = losing(kind)
    carried = sum(torques(loss, loaded(loss, P_G, -0.5)))
    assert carried == pytest.approx({"maxwell": 0.0, "creep": 0.0, "parallel": -LIMIT}.get(kind, -0.5 * LIMIT))


def convergence(turning: Callable[[Any, int], float], loss: Any) -> float:
    """Order at which the torque at the end of a smooth turn converges."""
    errors = [abs(turning(loss, n) - turning(loss, 64 * 40)) for n in (40, 80)]
    return float(np.log2(errors[0] / errors[1]))


def test_elements_have_their_weights_after_a_sudden_turn_and_relax_in_their_times() -> None:
    turned_by, steps = radians(1.0), 400  # half of the deflection
    loss = losing("maxwell", times=["20 ms", "100 ms"])
    for p_g, share in ((P_G, 1.0), (0.0, 0.25)):
        state = turned(loss, at_rest(loss), turned_by, p_g, 1e-9)
        sudden = np.array(torques(loss, state))
        assert sudden == pytest.approx(0.5 * LIMIT * np.array([0.5, 0.2]), rel=1e-6)
        for _ in range(steps):
            state = turned(loss, state, 0.0, p_g, 0.04 * share / steps)
        assert np.array(torques(loss, state)) == pytest.approx(sudden * np.exp([-2.0, -0.4]), rel=1e-3)


def test_creep_takes_as_much_off_in_each_decade_of_time() -> None:
    loss = losing("creep", per_decade=0.1, first="1 ms", last="1000 s", elements=13)
    state, carried = turned(loss, at_rest(loss), radians(2.0), P_G, 1e-9), []
    for h in np.diff([0.0, *np.logspace(-4, 1, 2001)]):
        state = turned(loss, state, 0.0, P_G, float(h))
        carried.append(sum(torques(loss, state)))
    # At 0.1, 1 and 10 s: far from the first time and from the last.
    assert -np.diff(carried[1200::400]) == pytest.approx(0.1 * LIMIT, rel=0.02)


@pytest.mark.parametrize("h", [1e-3, 0.03, 0.5])
def test_a_steady_turn_meets_dashpots(h: float) -> None:
    rate, loss, steps = radians(3.0), losing("maxwell", times=["20 ms"], weights=[0.5]), 20 + round(0.5 / h)
    steadily = walk(loss, np.linspace(0.0, rate * h * steps, steps + 1), h)[-1]
    # Half of the limit after 2 degrees is what the spring carries, for the time that it takes to relax.
    assert steadily == pytest.approx(0.5 * LIMIT / radians(2.0) * 0.02 * rate)


@given(st.floats(1e-6, 1e3))
def test_what_relaxes_does_not_swing(h: float) -> None:
    loss = losing("maxwell", times=["20 ms"], weights=[0.5])
    stretched = turned(loss, at_rest(loss), 0.02, P_G, 1e-9)
    (before,), (after,) = torques(loss, stretched), torques(loss, turned(loss, stretched, 0.0, P_G, h))
    assert 0.0 <= after <= before


@pytest.mark.parametrize("kind", ["bouc-wen", "maxwell", "creep"])
def test_a_step_is_of_second_order(kind: str) -> None:
    def turning(loss: Any, n: int) -> float:
        q = 0.1 * np.linspace(0.0, 1.0, n + 1) ** 2
        return float(walk(loss, q, 1.0 / n)[-1])

    assert convergence(turning, losing(kind)) > 1.7


CASE = Scenario(demand=[(0.0, -0.3), (0.1, 0.3)], duration=0.6, seed=3, brake=0.1)


def machine(kind: str, **changes: Any) -> Machine:
    return changed(load("paper-small-joint"), SMALL, described(kind, damping_time="5 ms", **changes))


@pytest.mark.compiled
@each_kind
def test_a_run_closes_its_ledger(kind: str) -> None:
    run = rollout(machine(kind), scenario=CASE).isel(joint=0)
    works = run["gas_work"] + run["load_work"] - run["hose_work"] - run["brake_heat"] - run["damping_heat"]
    inertia = load("paper-small-joint").arm.payload * 0.4**2 + 0.001 + 0.0053 + 0.4 * 0.2**2
    assert float(abs(works - 0.5 * inertia * run["velocity"] ** 2).max()) < 1e-3
    assert float((run["hose_work"] - run["hose_stored"]).min()) >= -1e-4
    assert float(run["damping_heat"][-1]) > 0.0


@pytest.mark.compiled
def test_an_ensemble_with_every_kind_in_parallel_repeats_a_run_bit_for_bit() -> None:
    parts = {kind: {"kind": kind, **DESCRIBED[kind]} for kind in DESCRIBED if kind != "parallel"}
    every = machine("parallel", parts=parts)
    run = rollout(every, scenario=CASE).isel(joint=0)
    angles = simulate_traces(every, CASE, {"seed": np.array([3.0, 3.0])}, ("angle",))[:, :, 0, 0]
    assert np.array_equal(angles[1], run["angle"].to_numpy()[: angles.shape[1]])
    assert np.ptp(angles) > 0.1


def test_what_varies_from_run_to_run_may_be_any_number_of_any_kind() -> None:
    base = changed(load("paper-small-joint"), SMALL, described("parallel"))
    path = f"{SMALL}.parts.creep.per_decade"
    alone = [
        walk(HYSTERESIS.parameters(changed(base, path, one).joint["small"].losses, LIMIT), np.array([0.0, 0.1]))[-1]
        for one in (0.05, 0.1)
    ]
    together = HYSTERESIS.parameters(changed(base, path, np.array([0.05, 0.1])).joint["small"].losses, LIMIT)
    for i, torque in enumerate(alone):
        one = mapped(together, lambda leaf: float(np.broadcast_to(leaf, 2)[i]))  # noqa: B023
        assert walk(one, np.array([0.0, 0.1]))[-1] == torque


@pytest.mark.parametrize(
    ("kind", "changes", "said"),
    [
        ("elasto-slip", {"weights": [0.5, 0.6]}, "add up to 1"),
        ("elasto-slip", {"weights": [1.0]}, "as many as deflections"),
        ("elasto-slip-spectrum", {"last": "0.2 deg"}, "greater than first"),
        ("bouc-wen", {"beta": 0.4}, "greater than or equal to 0.5"),
        ("bouc-wen", {"exponent": 2.5}, "less than or equal to 2"),
        ("maxwell", {"weights": [0.5]}, "as many as times"),
        ("maxwell", {"weights": [0.5, -0.1]}, "greater than or equal to 0"),
        ("creep", {"last": "1 ms"}, "greater than first"),
        ("parallel", {"fractions": {"other": 0.5}}, "no part 'other'"),
        ("parallel", {"parts": {"slip": SLIP}}, "at least 2"),
        ("parallel", {"parts": {"slip": SLIP, "creep": CREEP | {"damping_time": "1 ms"}}}, "give it to the whole"),
        ("parallel", {"parts": {"slip": SLIP, "more": {"kind": "parallel", "parts": {}}}}, "parallel"),
        ("bouc-wen", {"damping_time": "-1 ms"}, "0"),
    ],
)
def test_impossible_parameters_are_refused(kind: str, changes: dict[str, Any], said: str) -> None:
    with pytest.raises(ValidationError) as error:
        described(kind, **changes)
    assert said in str(error.value)


def test_a_part_has_the_pressure_of_the_whole_unless_it_says_otherwise() -> None:
    own = {"parts": {"slip": SLIP, "creep": CREEP | {"pressure_free": 1.0}}}
    parts = described("parallel", **own).parts
    assert [part.pressure_free for part in parts.values()] == [0.25, 1.0]


@pytest.mark.parametrize("count", [2, 3, 4])
def test_parts_in_parallel_add_up_whatever_their_number(count: int) -> None:
    kinds = ("elasto-slip", "creep", "bouc-wen", "maxwell")[:count]
    parts = {kind: {"kind": kind, **DESCRIBED[kind]} for kind in kinds}
    whole = described("parallel", parts=parts, fractions={"creep": 0.3})
    path = np.cumsum(np.random.default_rng(count).normal(0.0, 0.01, 60))
    alone = [HYSTERESIS.parameters(whole.parts[kind], (0.3 if kind == "creep" else 1.0) * LIMIT) for kind in kinds]
    assert walk(HYSTERESIS.parameters(whole, LIMIT), path) == pytest.approx(sum(walk(one, path) for one in alone))


def test_a_kelvin_voigt_element_damps_by_the_loss() -> None:
    plain = hose(changed(load("paper-small-joint"), f"{SMALL}.damping_time", 0.0).joint["small"])
    assert plain.damping == (0.0, 0.0)
    damped = hose(changed(load("paper-small-joint"), f"{SMALL}.damping_time", 0.01).joint["small"]).damping
    slow = sum(torques(plain.loss, loaded(plain.loss, P_G, 1.0)))
    assert damped.base + damped.slope * P_G == pytest.approx(0.01 * slow)
