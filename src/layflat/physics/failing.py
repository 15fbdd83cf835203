"""What goes wrong with a joint: a kinked hose, a hose with a hole; for a valve that sticks see valves/kind.py."""

from typing import Any

from layflat.jit import law
from layflat.physics.chamber import air_mass, energy, pressure, temperature
from layflat.physics.joint import HoseState

BURST_TIME = 0.02  # time constant with which a burst hose loses its air, s


def kinked(valve: Any, share: float) -> Any:
    """A valve behind a kink that lets through a share of what the valve does."""
    return valve._replace(conductance=share * valve.conductance, leakage=share * valve.leakage)


@law
def through_hole(hose, state, share, p_a):
    """State of a hose that has lost a share of its pressure above the outside (p_a, Pa), as warm as before."""
    V = state.volume
    p = pressure(hose.chamber, state.energy, V, p_a)
    T = temperature(hose.chamber, p, state.mass, V, p_a)
    p = p - share * (p - p_a)
    return HoseState(
        energy(hose.chamber, p, V, p_a),
        air_mass(hose.chamber, p, T, V, p_a),
        V,
        p,
        state.pressure_change,
        state.mass_change,
        state.loss,
        state.line,
    )
