"""Whole simulated run as an entry: the rollout's time loop, on the caller's arrays."""

# mypy: disable-error-code="no-untyped-def,no-untyped-call,attr-defined"
# What is compiled is untyped.

from collections.abc import Iterator
from typing import NamedTuple

from layflat.export.entries import (
    Argument,
    ControlEntries,
    Entry,
    PlantEntries,
    RestAngles,
    RestPressures,
    SensorNoise,
    number_of,
)
from layflat.lanes import Like, read_numbers
from layflat.machine.signals import SIGNALS
from layflat.sim.kernel import COLUMNS, JointRecord, RunBuffers, run_case
from layflat.sim.loop import ZERO_JOINT_SIGNALS, ZERO_SHARED_SIGNALS, Case, Signals, Timing

ZERO_RECORD = JointRecord(*[0.0] * COLUMNS)


class RunProgress(NamedTuple):
    """Progress of a run."""

    cycles: int  # number of control cycles begun
    records: int  # number of valid records
    diverged: int  # number of the joint that diverged; -1: none


def run_entry(control: ControlEntries, plant: PlantEntries) -> Iterator[Entry]:
    """Yield the entry of a simulated run.

    Args:
        control: entries of the control law.
        plant: entries of the plant.
    """
    from numba import carray  # noqa: PLC0415  # only where something is exported

    setting_like, settings_like = Like.from_tuple(plant.setting), Like.from_tuple(control.settings)
    numbers, settings_numbers = number_of(plant.setting), number_of(control.settings)
    n, steps, report_width = len(plant.carries), plant.steps, number_of(control.report.joints[0])
    joint_width, shared_width = number_of(ZERO_JOINT_SIGNALS), number_of(ZERO_SHARED_SIGNALS)

    def ran(parameters, settings, angles, pressures, by_joint, shared, noise, cycles, records, out, reports, progress):
        setting = read_numbers(setting_like, carray(parameters, (numbers,)))
        law = read_numbers(settings_like, carray(settings, (settings_numbers,)))
        signals = Signals(carray(by_joint, (cycles, n, joint_width)), carray(shared, (cycles, shared_width)))
        rows = cycles * records + 1
        buffers = RunBuffers(
            signals, carray(noise, (cycles + 1, n, 2)), carray(out, (rows, n, COLUMNS)),
            carray(reports, (rows, n, report_width)), records, carray(progress, (3,)),
        )  # fmt: skip
        case = Case(setting.arm, setting.joints, law, setting.around)
        timing = Timing(setting.cycle, steps, records)
        run_case(case, carray(angles, (n,)), carray(pressures, (2, n)).T, timing, buffers)
        return buffers.counters[2]

    nothing = (0.0,) * n
    yield Entry(
        "run",
        "Simulate a closed loop from rest, bit for bit as a rollout.",
        (
            Argument("parameters", "parameters of the plant", plant.setting),
            Argument("settings", "settings of the law", control.settings),
            Argument("angles", "angles at the start, rad", RestAngles(nothing)),
            Argument("pressures", "absolute pressures at the start, Pa", RestPressures(nothing, nothing)),
            Argument("joint_signals", f"array of cycles x {n}", ZERO_JOINT_SIGNALS),
            Argument("shared_signals", "array of cycles", ZERO_SHARED_SIGNALS),
            Argument("noise", f"array of (cycles + 1) x {n}", SensorNoise(0.0, 0.0)),
            Argument("cycles", "number of control cycles", number="int32_t"),
            Argument("records", f"records a cycle, a divisor of {steps}", number="int32_t"),
            Argument("record", f"array of (cycles * records + 1) x {n}, filled", ZERO_RECORD, output=True),
            Argument("joint_report", "array likewise, filled", control.report.joints[0], output=True),
            Argument(
                "progress",
                "counts, which another thread may read",
                RunProgress(0, 0, -1),
                views=("int64_t",),
                output=True,
            ),
        ),
        ran,
        "-1, or the number of the joint that diverged",
    )


def record_comments() -> dict[type, dict[str, str]]:
    """Return unit and meaning of the fields of records, by class."""
    return {JointRecord: {name: f"{SIGNALS[name][1]}, {SIGNALS[name][0]}" for name in JointRecord._fields}}
