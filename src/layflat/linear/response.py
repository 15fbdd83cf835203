"""Small-signal response of the simulated plant, against which a linear model is compared.

Two plants start at the operating point and move with the voltages that hold them there, with a sum of sines added to a
voltage or a load of the one and subtracted from the other's. They differ by twice their response: what both have in
common, as the dither, cancels. Transients are fitted as decaying motions of the model's slow modes.

Both are kept where they started (kept_plant.py) by what they have in common. In their difference nothing is taken back.

Sines have equal parts in the velocity of the joint that they move most, or, where theirs is held, in its pressure. The
plant, driven once per control cycle, holds its voltage: the response is to that stepped voltage.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.extras import import_extra
from layflat.linear.kept_plant import KeptPlant, keep_in_place
from layflat.linear.point import OperatingPoint

if TYPE_CHECKING:
    from control import FrequencyResponseData, StateSpace

DEFAULT_FREQUENCIES = (0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 14.0, 20.0)  # default, Hz
VELOCITY_FRACTION, MAX_VELOCITY_SIZE = 1e-4, 5e-6  # rms of a sliding joint's response: fraction of the speed, rad/s
PRESSURE_SIZE = 2.5  # that of a held joint's, Pa
SETTLING_TIME, WINDOW_TIME = 3.0, 6.0  # before the response is evaluated, and in which it is, s
SLOW_MODES = 8.0  # rate of decay below which modes outlast the settling or are excited by the sines' start, 1/s
MAX_GROWTH = 5.0  # of deviations while a response is measured, as a power of e
COMMON_MODES = 1e-4  # relative singular value below which two modes are one


def measure_response(
    model: "StateSpace", frequencies: Sequence[float] = DEFAULT_FREQUENCIES, inputs: Sequence[str] | None = None
) -> "FrequencyResponseData":
    """Return the small-signal response of the simulated plant at the operating point of its linear model.

    Args:
        model: of `linearize`.
        frequencies: Hz.
        inputs: those of the model's inputs that are excited, one after the other; default: the voltages.

    Returns:
        The response by python-control, with the outputs of the model.

    Raises:
        InputError: an input is unknown, or joints do not slide steadily there.
    """
    control = import_extra("control", "control", where="measure_response")
    names = [name for name in model.input_labels if name.endswith("_voltage")] if inputs is None else list(inputs)
    if unknown := [name for name in names if name not in model.input_labels]:
        raise InputError(f"there is no input {unknown[0]!r}", where="inputs", right=f"{', '.join(model.input_labels)}")
    w = 2.0 * np.pi * np.asarray(frequencies, dtype=float)
    if growth := deviations_growth(model):
        what = f"joints do not slide steadily: deviations grow by e in {1.0 / growth:.2g} s"
        right = "where friction falls with the speed, give a higher one; where a load falls over, another configuration"
        raise InputError(what, where="speed", right=right)
    columns = [_measure_input(model, name, w) for name in names]
    return control.frd(np.stack(columns, axis=1), w, inputs=names, outputs=model.output_labels, name="plant")


def deviations_growth(model: "StateSpace") -> float:
    """Return the rate at which deviations from the operating point grow, 1/s; 0 where they hardly do in a measurement.

    They do where friction falls with the speed, so that joints stick and slip, or where a load falls over.
    """
    growth = float(model.poles().real.max(initial=0.0))
    return growth if growth * (SETTLING_TIME + WINDOW_TIME) > MAX_GROWTH else 0.0


def _measure_input(model: "StateSpace", name: str, w: Array) -> Array:
    """Return the response to an input at angular frequencies (rad/s), (outputs, frequencies)."""
    point, cycle = model.operating_point, model.operating_point.machine.cycle
    joint, _, quantity = name.rpartition("_")
    j, speeds = list(point.machine.joints).index(joint), np.array([state.velocity for state in point.states])
    sizes = {
        f"{other}_velocity": min(VELOCITY_FRACTION * abs(speed), MAX_VELOCITY_SIZE)
        for other, speed in zip(point.machine.joints, speeds, strict=True)
        if speed
    }
    if point.plant.held[j]:
        sizes[f"{joint}_differential_pressure"] = PRESSURE_SIZE
    gains = np.max([np.abs(model[output, name](1j * w)).ravel() / size for output, size in sizes.items()], axis=0)
    t = cycle * np.arange(round((SETTLING_TIME + WINDOW_TIME) / cycle))
    phases = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, len(w))
    sines = (np.sqrt(2.0 / len(w)) / gains) @ np.sin(np.outer(w, t) + phases[:, np.newaxis])
    signal = np.zeros((2, len(t), len(speeds)))  # voltages and loads
    signal[0 if quantity == "voltage" else 1, :, j] = sines
    forward, back = simulate(point, signal, -signal)
    evaluated = t >= SETTLING_TIME
    for name_j, speed, velocities in zip(point.machine.joints, speeds, (forward + back)[:, 1].T, strict=True):
        if speed and (velocities[evaluated] * speed <= 0.0).any():
            right = "give a higher speed, or let fewer joints slide"
            raise InputError(f"joint {name_j!r} stops on its way", where="speed", right=right)
    response = _outputs(model, 0.5 * (forward - back))[evaluated]
    modes = _modes(model, t[evaluated] - SETTLING_TIME)
    stepped = np.sinc(w * cycle / (2.0 * np.pi)) * np.exp(-0.5j * w * cycle)
    t, applied = t[evaluated], sines[evaluated, np.newaxis]
    gains = fit_sines(w, t, modes, response) / (fit_sines(w, t, modes, applied) * stepped[:, np.newaxis])
    return np.asarray(gains.T)


def simulate(point: OperatingPoint, *signals: Array) -> Array:
    """Return the motions of a plant from the operating point, at the start of each control cycle.

    Args:
        point: operating point.
        signals: of each run, what is added to the voltages (V) and loads (N m), (2, cycles, joints).

    Returns:
        Angles, velocities (rad, rad/s), absolute pressures of hoses A and B (Pa), (runs, cycles, 4, joints).
    """
    plants, rows = [KeptPlant(point) for _ in signals], []
    for inputs in np.stack(signals, axis=2).swapaxes(0, 1):
        rows.append([plant.motion() for plant in plants])
        for plant, voltages, loads in zip(plants, *inputs, strict=True):
            plant.advance(voltages, loads)
        keep_in_place(plants)
    return np.array(rows).swapaxes(0, 1)


def _outputs(model: "StateSpace", motion: Array) -> Array:
    """Return the outputs of a model from deviations as `simulate` returns the motion, (cycles, outputs)."""
    rows: dict[str, Any] = {}
    for j, joint in enumerate(model.operating_point.machine.joints):
        q, v, p_a, p_b = motion[:, :, j].T
        names = ("angle", "velocity", "pressure_a", "pressure_b", "differential_pressure")
        rows |= {f"{joint}_{name}": row for name, row in zip(names, (q, v, p_a, p_b, p_a - p_b), strict=True)}
    return np.array([rows[name] for name in model.output_labels]).T


def _modes(model: "StateSpace", t: Array) -> Array:
    """Return an orthogonal base of the model's slow free motions at times t (s), (times, modes)."""
    rates = model.poles()
    slow = np.exp(np.outer(t, rates[(rates.real > -SLOW_MODES) & (rates.imag >= 0.0)]))
    motions = np.column_stack([np.ones_like(t), t, slow.real, slow.imag])
    motions /= np.maximum(np.linalg.norm(motions, axis=0), 1e-12)
    base, sizes, _ = np.linalg.svd(motions, full_matrices=False)
    return np.asarray(base[:, sizes > COMMON_MODES * sizes[0]])


def fit_sines(w: Array, t: Array, modes: Array, signals: Array) -> Array:
    """Return the complex amplitudes of signals, fitted under a Hann window: sidebands of dither hardly leak.

    Args:
        w: angular frequencies of the sines, rad/s, (frequencies,).
        t: times, s, (times,).
        modes: other motions in the signals, (times, modes).
        signals: signals, (times, signals).

    Returns:
        Amplitudes, (frequencies, signals).
    """
    angles = np.outer(t, w)
    window = np.hanning(len(t))[:, np.newaxis]
    base = np.column_stack([np.cos(angles), np.sin(angles), modes])
    fit, *_ = np.linalg.lstsq(window * base, window * signals, rcond=None)
    return np.asarray(fit[: len(w)] - 1j * fit[len(w) : 2 * len(w)])
