"""A loss of another kind than ours, for logs that our elements did not make: Bouc and Wen, solved by SciPy."""

from dataclasses import dataclass

import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from layflat.machine import Machine, parameters
from layflat.physics.hose import torque_per_pressure

AMBIENT = 101325.0


@dataclass(frozen=True)
class BoucWen:
    """Torque = limit (alpha q / q_y + (1 - alpha) z), dz = (1 - |z|^n (beta sign(z dq) + 1 - beta)) dq / q_y."""

    n: float
    beta: float
    turn: float
    alpha: float = 0.005
    limit: float = 3.0

    def torque(self, time: NDArray[np.float64], amplitude: float, period: float) -> NDArray[np.float64]:
        """Torque on the way q = amplitude sin(2 pi t / period), from rest, N m."""
        w = 2 * np.pi / period

        def rate(t: float, z: NDArray[np.float64]) -> NDArray[np.float64]:
            v, size = amplitude * w * np.cos(w * t) / self.turn, np.abs(z)
            return np.asarray(v - self.beta * np.abs(v) * size ** (self.n - 1) * z - (1 - self.beta) * v * size**self.n)

        z = solve_ivp(rate, (time[0], time[-1]), [0.0], t_eval=time, max_step=0.02, rtol=1e-6, atol=1e-8).y[0]
        q = amplitude * np.sin(w * time)
        return np.asarray(self.limit * (self.alpha * q / self.turn + (1 - self.alpha) * z))


def measured(
    machine: Machine, joint: str, loss: BoucWen, amplitude: float, period: float, seed: int, scale: float = 0.93
) -> xarray.Dataset:
    """Three loops of a single-acting joint at 3 bar with this loss, with noise and 12-bit counts."""
    rng = np.random.default_rng(seed)
    hose, time = parameters.hose(machine.joint[joint]), np.linspace(0.0, 3 * period, 900)
    angle = amplitude * np.sin(2 * np.pi * time / period)
    K = np.array([torque_per_pressure(hose.stroke, hose.neutral + q) for q in angle])
    torque = scale * K * 3e5 - loss.torque(time, amplitude, period) + rng.normal(0.0, 0.03, len(time))
    angle = angle + rng.normal(0.0, np.radians(0.02), len(time))
    return xarray.Dataset(
        {
            "angle": ("time", _counted(angle, np.pi)),
            "torque": ("time", _counted(torque, 100.0)),
            "pressure_a": ("time", np.full(len(time), 3e5 + AMBIENT)),
        },
        {"time": time},
    )


def _counted(values: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
    count = reach / 2**12
    return np.asarray(count * np.round(values / count))
