"""What can be fitted of a regulated joint, and how far around the description.

The torque per pressure is held: pressures and angles identify all torques and volumes only in proportion to it; the
supply is known from its gauge.
"""

from layflat.identify.benches.regulated.description import RegulatedJointBench, least_volume
from layflat.identify.model import ParameterSpec, around, factor_range, from_zero

GAIN, OFFSET, DELAY = 1.5, 100e3, 0.15  # farthest gain (either way), offset (Pa) and delay (s) of a valve
FAR, FARTHER = factor_range(20.0), factor_range(50.0)  # what a person knows within about a factor of four, and all else
LOADS = 400e3  # load torques are searched up to this pressure, Pa, on the torque per pressure
BEYOND = 0.3  # stops are searched this far beyond the reading, as a share of it

STEPS = "changes of the set-point, up and down"
LARGE = "large steps of the set-point"
MOVES = "moves of different size and speed"
HOLDS = "moves that begin from rest at several angles, both ways"
RESTS = "rests at several set-points"
AT_STOP = "moves that leave the end of the reading"

C = "m^3/s/Pa"


def _load(bench: RegulatedJointBench) -> float:
    return LOADS * bench.chamber.torque_per_pressure


def _volumes(bench: RegulatedJointBench, volume: float) -> tuple[float, float, bool]:
    """At least what leaves some air in a chamber wherever the stops are searched."""
    reach = (0.5 + BEYOND) * bench.stroke.reading
    least = max(least_volume(bench), bench.chamber.torque_per_pressure * reach)
    low, high, log = FAR(bench, volume)
    return min(volume, max(low, 1.02 * least)), high, log


def _lower_stops(bench: RegulatedJointBench, stop: float) -> tuple[float, float, bool]:
    half = 0.5 * bench.stroke.reading
    return min(-half - 2.0 * BEYOND * half, stop), -half, False


def _upper_stops(bench: RegulatedJointBench, stop: float) -> tuple[float, float, bool]:
    half = 0.5 * bench.stroke.reading
    return half, max(half + 2.0 * BEYOND * half, stop), False


BLOCKS = {
    "valve": (
        ParameterSpec("valve.gain", "1", factor_range(GAIN), RESTS),
        ParameterSpec("valve.offset", "Pa", around(lambda _: OFFSET), RESTS),
        ParameterSpec("valve.delay", "s", from_zero(lambda _, delay: max(DELAY, 2.0 * delay)), STEPS),
        ParameterSpec("valve.lag", "s", FAR, STEPS),
        ParameterSpec("valve.conductance_in", C, FARTHER, f"{LARGE}, upwards"),
        ParameterSpec("valve.conductance_out", C, FARTHER, f"{LARGE}, downwards"),
        ParameterSpec("valve.band_in", "Pa", FAR, f"{STEPS}, of different size"),
        ParameterSpec("valve.band_out", "Pa", FAR, f"{STEPS}, of different size"),
    ),
    "gas": (
        ParameterSpec("chamber.volume", "m^3", _volumes, "fast moves"),
        ParameterSpec("chamber.wall_conductance", "W/K", FARTHER, LARGE),
    ),
    "motion": (
        ParameterSpec("load.inertia", "kg*m^2", FARTHER, "moves that start and stop fast"),
        ParameterSpec("load.damping", "N*m*s/rad", FARTHER, MOVES),
        ParameterSpec("load.torque", "N*m", around(_load), HOLDS),
        ParameterSpec("load.stiffness", "N*m/rad", around(lambda b: _load(b) / (0.5 * b.stroke.reading)), HOLDS),
        ParameterSpec("friction.lower_end", "N*m", FARTHER, HOLDS),
        ParameterSpec("friction.upper_end", "N*m", FARTHER, HOLDS),
        ParameterSpec("friction.lag", "s", FAR, "rests of different length, followed by moves"),
        ParameterSpec("stroke.lower_stop", "rad", _lower_stops, AT_STOP, floor=True),
        ParameterSpec("stroke.upper_stop", "rad", _upper_stops, AT_STOP, floor=True),
    ),
}
"""By block; a stop is only fitted where a reading comes to its end."""
