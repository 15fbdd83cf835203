import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from layflat.physics.friction import slip_torque, slip_torques, solve_friction
from layflat.physics.friction.coulomb import Coulomb
from layflat.physics.friction.stribeck import KIND, Stribeck, StribeckPart, parameters
from layflat.physics.step import STEP

Floats = NDArray[np.floating]
FALLING = Stribeck(0.4, 1.0 / 0.05**2, 0.3, 0.01)
speeds = st.floats(0.0, 50.0)


@given(speeds, speeds, st.floats(0.0, 10.0), st.floats(0.0, 100.0))
def test_friction_falls_with_speed_and_grows_with_load(v: float, more: float, brake: float, pull: float) -> None:
    slow, fast = slip_torque(FALLING, brake, v, pull), slip_torque(FALLING, brake, v + more, pull)
    kinetic = brake + 0.3 + 0.01 * pull
    assert kinetic <= fast <= slow <= 1.4 * kinetic * (1.0 + 1e-12)
    assert slip_torque(FALLING, brake, v, pull + 1.0) >= slow + 0.01 * (1.0 - 1e-6)


def test_half_of_the_difference_is_gone_at_the_stribeck_velocity() -> None:
    assert slip_torque(FALLING, 2.0, 0.0, 0.0) == pytest.approx(1.4 * 2.3)
    assert slip_torque(FALLING, 2.0, 0.05, 0.0) == pytest.approx(1.2 * 2.3)
    assert slip_torque(FALLING, 2.0, 1e6, 0.0) == pytest.approx(2.3)


def test_friction_is_what_its_description_says() -> None:
    said = {"kind": "stribeck", "static_ratio": 1.4, "velocity": "0.05 rad/s", "drag": "0.3 N m", "load_ratio": 0.01}
    assert parameters(StribeckPart.model_validate(said)) == pytest.approx(FALLING)
    unloaded = StribeckPart.model_validate({key: said[key] for key in ("kind", "static_ratio", "velocity")})
    assert parameters(unloaded) == pytest.approx(FALLING._replace(drag=0.0, load_ratio=0.0))


@given(st.floats(0.0, 10.0), speeds, st.floats(0.0, 100.0))
def test_without_excess_drag_and_load_it_is_coulombs(brake: float, v: float, pull: float) -> None:
    assert slip_torque(KIND.plain, brake, v, pull) == slip_torque(Coulomb(), brake, v, pull) == brake


@pytest.mark.parametrize(
    ("before", "extrapolated", "speed"),
    [(0.0, 0.7, 0.0), (0.2, 0.3, 0.3), (-0.2, -0.3, 0.3), (0.2, -0.1, 0.0), (-0.2, 0.1, 0.0)],
)
def test_the_level_is_that_in_the_middle_of_the_step(before: float, extrapolated: float, speed: float) -> None:
    sliding, held = slip_torques(FALLING, 2.0, before, extrapolated, 0.0)
    assert sliding == slip_torque(FALLING, 2.0, speed, 0.0)
    assert held == slip_torque(FALLING, 2.0, 0.0, 0.0)


BRAKE, MASS, SPRING, PULLED, SECONDS = 2.0, 0.02, 20.0, 0.2, 1.5  # N m, kg m2, N m/rad, rad/s, s


def stick_slip(friction: Stribeck, h: float) -> tuple[Floats, Floats, Floats]:
    """Angles, velocities and heat of a mass that a spring drags along, its far end at a steady pace."""
    q = v = change = heat = 0.0
    rows = []
    for i in range(round(SECONDS / h)):
        middle = q + 0.5 * h * v
        p = MASS * v + h * SPRING * (PULLED * (i + 0.5) * h - middle)
        sliding, held = slip_torques(friction, BRAKE, v, v + 0.5 * change, 0.0)
        (after,), (J,) = solve_friction(friction, (MASS,), (p,), (v,), (h * sliding,), (h * held,))
        heat -= 0.5 * J * (v + after)
        q, v, change = middle + 0.5 * h * after, after, after - v
        rows.append((q, v, heat))
    angles, velocities, heats = np.array(rows).T
    return angles, velocities, heats


def reference(friction: Stribeck, instants: Floats) -> Floats:
    """The same, slip by slip, each of them smooth."""

    def rates(t: float, y: Floats) -> list[float]:
        return [y[1], (SPRING * (PULLED * t - y[0]) - slip_torque(friction, BRAKE, abs(y[1]), 0.0)) / MASS]

    t, q, times, angles = 0.0, 0.0, [0.0], [0.0]
    while True:
        t = (slip_torque(friction, BRAKE, 0.0, 0.0) / SPRING + q) / PULLED
        if t >= instants[-1]:
            break

        def stops(s: float, y: Floats, since: float = t) -> float:
            return float(y[1]) if s > since + 1e-3 else 1.0

        stops.terminal, stops.direction = True, -1.0  # type: ignore[attr-defined]
        slip = solve_ivp(rates, (t, t + 1.0), [q, 1e-9], "LSODA", rtol=1e-9, atol=1e-12, events=stops, max_step=2e-3)
        times += [t, *slip.t[1:]]
        angles += [q, *slip.y[0, 1:]]
        t, q = slip.t[-1], slip.y[0, -1]
    return np.interp(instants, [*times, instants[-1]], [*angles, q])


@pytest.mark.parametrize("velocity", [0.05, 0.02])
def test_stick_slip_is_of_second_order_and_fine_at_the_default_step(velocity: float) -> None:
    # Friction falls by up to 0.52/v_s = 26 N m s/rad: a disturbance grows at 1300/s, by 65 % in a default step.
    friction, errors = Stribeck(0.4, 1.0 / velocity**2, 0.0, 0.0), []
    for h in (STEP, STEP / 2, STEP / 4):
        q, v, heat = stick_slip(friction, h)
        starts = np.flatnonzero((v[1:] != 0.0) & (v[:-1] == 0.0))
        assert len(starts) >= 2, "it sticks, slips, and sticks again"
        assert np.all(np.diff(heat) >= 0.0)
        assert np.all(v >= 0.0)
        errors.append(np.abs(q - reference(friction, h * np.arange(1, len(q) + 1))).max())
    assert errors[0] < 1e-3
    assert errors[0] / errors[2] > 9.0


@given(st.floats(1e-4, 1.0), st.floats(1e-5, 1e-2), st.floats(0.0, 3.0), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_the_steepest_fall_makes_no_energy(velocity: float, h: float, excess: float, v: float, change: float) -> None:
    friction = Stribeck(excess, 1.0 / velocity**2, 0.0, 0.0)
    for _ in range(30):
        sliding, held = slip_torques(friction, BRAKE, v, v + 0.5 * change, 0.0)
        (after,), _ = solve_friction(friction, (MASS,), (MASS * v,), (v,), (h * sliding,), (h * held,))
        assert abs(after) <= abs(v)
        assert after * v >= 0.0
        v, change = after, after - v
