"""Loops of a control law with the linear model of its plant, each opened at the input of its valve, and their margins.

A law is not linear, and may be any code, so its loop is measured while it is closed: the law, cycle by cycle, drives
the sampled linear model through a motion that does what is demanded. A sum of sines d is added to the voltage u that
the law returns for a valve. Then L = -U / (U + D) is the loop, opened at that valve, with those of other valves closed.
Two runs with opposite sines are compared, as in response.py; the sines have whole periods in the time of evaluation.

A loop that does not settle, as one that is not stable, has no margins. Dry friction may still bring the joint to rest.
A law that leaves joints at rest to friction, and centres their valves, closes no loop then: it is 0, even if the law
corrects their pressures now and then.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.control import Demand, Sensed
from layflat.extras import import_extra
from layflat.linear.kernel import close_loop
from layflat.linear.response import fit_sines
from layflat.machine import parameters

if TYPE_CHECKING:
    from control import FrequencyResponseData, StateSpace

SETTLING_TIME, WINDOW_TIME = 6.0, 10.0  # before a loop is evaluated, and in which it is, s
MIN_FREQUENCY, MAX_CYCLE_FRACTION = 0.2, 0.4  # lowest frequency, Hz, and highest one as a fraction of the cycles' rate
FREQUENCY_COUNT = 60  # of frequencies, evenly spaced on a logarithmic axis
SINES_SIZE = 0.005  # rms of the sum of sines, V
IDLE_FRACTION = 0.5  # of the cycles in which a valve is centred by a law that closes no loop
MAX_UNEXPLAINED = 0.2  # rms of what is no sine at these frequencies, fraction of all, in a loop that settles


class LoopMargins(NamedTuple):
    """Margins of a stable loop; infinite where it has no such crossing."""

    gain: float  # by which the loop's gain may grow, 1
    phase: float  # deg
    crossover: float  # where the gain is 1, Hz; NaN if nowhere
    distance: float  # least distance of the Nyquist curve from -1


def measure_loops(model: "StateSpace") -> "FrequencyResponseData":
    """Return the loops of a machine's control law with a linear model, each opened at its valve alone.

    Args:
        model: of `linearize`, of a machine with a controller.

    Returns:
        The response of each loop by python-control, on the diagonal: from a valve's voltage to the one that the law
        returns, with its sign reversed. It is NaN where the loop does not settle, and 0 where the law closes none.

    Raises:
        MachineError: the machine has no controller.
    """
    control: Any = import_extra("control", "control", where="measure_loops")
    point, joints = model.operating_point, list(model.operating_point.machine.joints)
    settings, cycle, n = parameters.control(point.machine), point.machine.cycle, len(joints)
    run = close_loop if point.machine.control_law.compiled else close_loop.py_func  # type: ignore[attr-defined]
    highest = MAX_CYCLE_FRACTION / cycle * WINDOW_TIME
    harmonics = np.unique(np.geomspace(MIN_FREQUENCY * WINDOW_TIME, highest, FREQUENCY_COUNT).astype(int))
    w = 2.0 * np.pi * harmonics / WINDOW_TIME
    t = cycle * np.arange(round((SETTLING_TIME + WINDOW_TIME) / cycle)) - SETTLING_TIME
    speeds = np.array([state.velocity for state in point.states])
    demands = np.array([state.angle for state in point.states]) + np.outer(t, speeds)
    steady = np.zeros((len(t), 2, n))
    steady[:, 0], steady[:, 1] = demands, [s.air_a.pressure - s.air_b.pressure for s in point.states]
    first, zeros = Sensed(*(tuple(row) for row in steady[0].tolist())), (0.0,) * n
    demand = Demand(first.angle, tuple(speeds.tolist()), zeros, zeros)
    plant = _sampled_plant(control, model)
    phases = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, len(w))
    sines = SINES_SIZE * np.sqrt(2.0 / len(w)) * np.sin(np.outer(t, w) + phases).sum(axis=1)
    loops = np.zeros((n, n, len(w)), dtype=complex)
    for j in range(n):
        results = np.empty((2, len(t), n))
        for sign, voltages in zip((1.0, -1.0), results, strict=True):
            added = np.tile(-point.voltages, (len(t), 1))
            added[:, j] += sign * sines
            run(settings, first, demand, demands, steady, plant, added, cycle, voltages)
        if (results[:, t >= 0.0, j] == point.plant.joints[j].valve.centre_voltage).mean() < IDLE_FRACTION:
            loops[j, j] = _opened(w, t, sines, 0.5 * (results[0] - results[1])[:, j])
    names = {"inputs": [f"{joint}_voltage" for joint in joints], "outputs": [f"{joint}_returned" for joint in joints]}
    return control.frd(loops, w, name="loop", **names)


def loop_margins(loops: "FrequencyResponseData") -> dict[str, LoopMargins | None]:
    """Return the margins of the loops of `measure_loops` by joint; None of one that does not settle."""
    control: Any = import_extra("control", "control", where="loop_margins")
    margins: dict[str, LoopMargins | None] = {}
    for j, name in enumerate(loops.input_labels):
        loop, joint = loops.frdata[j, j], name.removesuffix("_voltage")
        margins[joint] = None
        if np.isfinite(loop).all():
            alone = control.frd(loop, loops.omega, smooth=True)
            gain, phase, distance, _, crossover, _ = (float(value) for value in control.stability_margins(alone))
            margins[joint] = LoopMargins(gain, phase, crossover / (2.0 * np.pi), min(distance, 1.0))
    return margins


def _sampled_plant(control: Any, model: "StateSpace") -> tuple[Array, Array, Array]:
    """Return A, B and C of a model that is held once per control cycle, from voltages to angles and pressures."""
    joints = list(model.operating_point.machine.joints)
    sampled = control.sample_system(model, model.operating_point.machine.cycle, "zoh")
    B = sampled.B[:, [model.input_labels.index(f"{joint}_voltage") for joint in joints]]
    rows = dict(zip(model.output_labels, sampled.C, strict=True))
    names = [f"{joint}_{quantity}" for quantity in ("angle", "differential_pressure") for joint in joints]
    still = np.zeros(len(sampled.A))  # the angle of a joint that is held
    C = np.array([rows.get(name, still) for name in names])
    return np.ascontiguousarray(sampled.A), np.ascontiguousarray(B), C


def _opened(w: Array, t: Array, sines: Array, returned: Array) -> Array:
    """Return an opened loop at angular frequencies (rad/s) from the sines and their part in the returned voltage."""
    evaluated = t >= 0.0
    if not np.isfinite(returned).all():
        return np.full(len(w), np.nan, dtype=complex)
    drift, signals = np.vander(t[evaluated] / WINDOW_TIME, 3), np.column_stack([sines, returned])[evaluated]
    D, U = fit_sines(w, t[evaluated], drift, signals).T
    explained = np.sqrt(0.5 * (np.abs(U) ** 2).sum())
    total = float(np.std(returned[evaluated]))
    if total > SINES_SIZE * 1e-6 and total**2 - explained**2 > (MAX_UNEXPLAINED * total) ** 2:
        return np.full(len(w), np.nan, dtype=complex)
    return np.asarray(-U / (U + D))
