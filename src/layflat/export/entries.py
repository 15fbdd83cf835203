"""Entries: the functions that are exported, each a few lines over the laws as they stand.

They work on the caller's memory alone: structs of C (see `layout.py`), which are rows of numbers here. None allocates,
and none keeps anything from call to call but what the caller hands in.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from layflat.control import CONTROL_LAWS, Demand, Sensed, step, wake
from layflat.lanes import Like, in_lanes, leaves, read_lanes, read_numbers, slots, write_lanes, write_numbers
from layflat.machine import Machine, parameters
from layflat.physics.driven import DrivenOutputs
from layflat.physics.plant import states_at_rest
from layflat.physics.step import STEP
from layflat.sim.run import make_timing
from layflat.sim.stepping import ZERO_INPUTS, PlantSetting, carry_at_rest, joint_carry_at_rest, move, sample


@dataclass(frozen=True)
class Argument:
    """Argument of a C function: a struct, an array of them, or a number."""

    name: str
    comment: str
    like: Any = None  # tuple of the struct's structure; None: a number, of the type `number`
    rows: int | None = None  # of an array; None: a single struct
    output: bool = False  # whether the function writes it
    number: str = "real"  # C's type: "real" of the entries' precision, or int32_t
    views: tuple[str, ...] = ("real",)  # types of the numbers as which the function is handed the struct
    struct: str = ""  # name of the struct without prefix; empty: that of the argument
    split: bool = False  # whether the function is handed each field of the struct on its own
    updated: bool = False  # whether the law of an entry reads the struct, too, before the function writes it

    @property
    def struct_name(self) -> str:
        """Name of the struct without prefix."""
        return self.struct or self.name

    @property
    def places(self) -> list[int]:
        """Number of numbers in front of each part of the struct that the function is handed."""
        sizes = [number_of(part) if isinstance(part, tuple) else 1 for part in self.like] if self.split else []
        return list(accumulate(sizes[:-1], initial=0)) if sizes else [0]


@dataclass(frozen=True)
class Entry:
    """Exported function: its name without prefix, its description, its arguments, and itself."""

    name: str
    comment: str
    arguments: tuple[Argument, ...]
    function: Callable[..., Any]  # of pointers (one a view) and numbers
    result: str = ""  # description of the integer that it returns; empty: it returns nothing
    lanes: bool = True  # whether its laws take lanes, which have a form in single precision
    law: Any = None  # law on tuples: of the arguments that it reads, and `constants`; it returns those that are written
    constants: tuple[float, ...] = ()


class PlantState(NamedTuple):
    """State of a plant."""

    joints: Any
    step: int  # number of steps from the start
    due: int  # steps until the voltages reach the valves' drivers


class ArmReport(NamedTuple):
    """Report of the law, for each joint."""

    joints: tuple[Any, ...]


class RestAngles(NamedTuple):
    """Angles at which the joints rest."""

    angle: tuple[float, ...]  # rad


class RestPressures(NamedTuple):
    """Pressures in the hoses at rest."""

    pressure_a: tuple[float, ...]  # absolute, Pa; NAN: those that hold the arm
    pressure_b: tuple[float, ...]  # likewise


class SensorNoise(NamedTuple):
    """Standard normal samples of a joint's sensors."""

    angle: float  # of the angle sensor, in standard deviations
    pressure: float  # of the pressure sensor, likewise


def number_of(value: Any) -> int:
    """Return the number of numbers in a tuple."""
    return sum(1 for _ in leaves(value))


class ControlEntries:
    """Control law of a machine as entries.

    Args:
        machine: the machine.
        bytes_each: size of a number: 8 in double precision, 4 in single.

    Raises:
        KindError: the law is plain Python.
    """

    def __init__(self, machine: Machine, bytes_each: int) -> None:
        self.settings = parameters.control(machine)
        law = CONTROL_LAWS.kind_of(self.settings)
        law.check_compiled("in C")
        nothing = (0.0,) * len(machine.joints)
        self.sensed, self.demand = Sensed(nothing, nothing), Demand(*[nothing] * 4)
        self.memory = in_lanes(wake(self.settings, self.sensed), 0.0)
        _, command, report = step(self.settings, self.memory, self.sensed, self.demand, machine.cycle)
        self.command, self.report = in_lanes(command, 0.0), ArmReport(in_lanes(report, 0.0))
        self._bytes = bytes_each
        signals = {name: f"{meaning}, {unit}" for name, (unit, meaning) in law.signals.items()}
        self.comments: dict[type, dict[str, str]] = {law.report: signals}

    def __iter__(self) -> Iterator[Entry]:
        """Yield the entries."""
        from numba import carray  # type: ignore[attr-defined]  # noqa: PLC0415  # only where something is exported

        likes = [Like.from_tuple(one, self._bytes) for one in (self.settings, self.sensed, self.memory, self.demand)]
        settings_like, sensed_like, memory_like, demand_like = likes
        settings_shape, sensed_shape, memory_shape, demand_shape = ((number_of(one.value), 1) for one in likes)
        command_shape, report_shape = (number_of(self.command), 1), (number_of(self.report), 1)
        zero_like = Like.from_tuple((0.0,), self._bytes)

        def woken(settings, sensed, memory):  # type: ignore[no-untyped-def]
            own = read_lanes(settings_like, carray(settings, settings_shape))
            rows = carray(sensed, sensed_shape)
            (zero,) = read_lanes(zero_like, rows)
            write_lanes(carray(memory, memory_shape), in_lanes(wake(own, read_lanes(sensed_like, rows)), 0.0 * zero))

        def stepped(settings, memory, sensed, demand, elapsed, after, command, report):  # type: ignore[no-untyped-def]
            own = read_lanes(settings_like, carray(settings, settings_shape))
            before = read_lanes(memory_like, carray(memory, memory_shape))
            rows = carray(sensed, sensed_shape)
            (zero,) = read_lanes(zero_like, rows)
            came, asked = read_lanes(sensed_like, rows), read_lanes(demand_like, carray(demand, demand_shape))
            remembered, commanded, reported = step(own, before, came, asked, float(elapsed))
            write_lanes(carray(after, memory_shape), in_lanes(remembered, 0.0 * zero))
            write_lanes(carray(command, command_shape), in_lanes(commanded, 0.0 * zero))
            write_lanes(carray(report, report_shape), in_lanes(reported, 0.0 * zero))

        settings = Argument("settings", "settings of the law", self.settings)
        sensed = Argument("sensed", "readings of the sensors in this cycle", self.sensed)
        yield Entry(
            "control_wake",
            "Initialise the memory of the control law at these readings.",
            (settings, sensed, Argument("memory", "memory, which is filled", self.memory, output=True)),
            woken,
            law=wake,
        )
        yield Entry(
            "control_step",
            "Step the control law by a control cycle. `after` may be `memory`.",
            (
                settings,
                Argument("memory", "memory of the law before this cycle", self.memory),
                sensed,
                Argument("demand", "demands of this cycle", self.demand),
                Argument("elapsed", "time since the last cycle, s"),
                Argument(
                    "after", "memory after this cycle, which is filled", self.memory, output=True, struct="memory"
                ),
                Argument("command", "commands, which are filled", self.command, output=True),
                Argument("report", "report of the law, which is filled", self.report, output=True),
            ),
            stepped,
            law=step,
        )


class PlantEntries:
    """Plant of a machine as entries, in double precision.

    Args:
        machine: the machine.
    """

    def __init__(self, machine: Machine) -> None:
        n, cycle = len(machine.joints), machine.cycle
        self.steps = make_timing(cycle, STEP, 1, machine).steps
        self.h = cycle / self.steps
        self.setting = PlantSetting(
            parameters.arm(machine), parameters.joints(machine), cycle, parameters.surroundings(machine)
        )
        self.carries = tuple(carry_at_rest(self.setting, np.zeros(n), np.full((n, 2), np.nan), self.h))
        self.state = PlantState(self.carries, 0, -1)

    def __iter__(self) -> Iterator[Entry]:
        """Yield the entries."""
        from numba import carray  # type: ignore[attr-defined]  # noqa: PLC0415  # only where something is exported

        n, steps, h = len(self.carries), self.steps, self.h
        setting_like, carry_like = Like.from_tuple(self.setting), Like.from_tuple(self.carries[0])
        numbers, columns, items = (number_of(one) for one in (self.setting, self.carries[0], ZERO_INPUTS))
        angles_like = (0.0,) * n

        def rest(setting, angles, pressures, state, clock):  # type: ignore[no-untyped-def]
            arm, joints, _, around = read_numbers(setting_like, carray(setting, (numbers,)))
            filled, rows = carray(pressures, (2, n)), carray(state, (n, columns))
            start = read_numbers(angles_like, carray(angles, (n,)))
            a, b = read_numbers(angles_like, filled[0]), read_numbers(angles_like, filled[1])
            states, places = slots(states_at_rest(arm, joints, start, a, b, around)), slots(joints)
            for j in range(n):
                write_numbers(rows[j], joint_carry_at_rest(places[j], states[j], h))
            clock[n * columns], clock[n * columns + 1] = 0, -1

        def advanced(setting, state, clock, driven, outputs, count, new):  # type: ignore[no-untyped-def]
            begin = clock[n * columns]
            due = -1 if new != 0 else clock[n * columns + 1]
            due, diverged = move(
                setting_like, carry_like, carray(setting, (numbers,)), carray(state, (n, columns)),
                carray(driven, (n, items)), carray(outputs, (n, 4)), steps, begin, begin + count, due,
            )  # fmt: skip
            clock[n * columns], clock[n * columns + 1] = begin + count, due
            return diverged

        def sampled(setting, state, noise, sensed):  # type: ignore[no-untyped-def]
            rows, out = carray(state, (n, columns)), carray(sensed, (2, n))
            sample(setting_like, carry_like, carray(setting, (numbers,)), rows, carray(noise, (n, 2)), out)

        setting = Argument("parameters", "parameters of the plant", self.setting)
        state = Argument("state", "state of the plant", self.state, output=True, views=("real", "int64_t"))
        nothing = (0.0,) * n
        yield Entry(
            "plant_rest",
            "Set the state to rest.",
            (
                setting,
                Argument("angles", "angles of the joints, rad", RestAngles(nothing)),
                Argument(
                    "pressures",
                    "absolute pressures of the hoses, Pa; NAN: those that hold the arm",
                    RestPressures(nothing, nothing),
                ),
                state,
            ),
            rest,
        )
        yield Entry(
            "plant_advance",
            "Advance the plant by steps, and write what the joints then do.",
            (
                setting,
                state,
                Argument("inputs", "inputs of each joint", ZERO_INPUTS, n),
                Argument(
                    "outputs", "outputs of each joint, which are filled", DrivenOutputs(*[0.0] * 4), n, output=True
                ),
                Argument("steps", "number of steps", number="int32_t"),
                Argument("driven", "1 if the voltages are those of a new control cycle, else 0", number="int32_t"),
            ),
            advanced,
            "-1, or the number of the joint whose state became invalid",
        )
        yield Entry(
            "plant_sample",
            "Read the sensors, with noise of the caller's (standard normal samples; zeros: none).",
            (
                setting,
                Argument("state", "state of the plant", self.state),
                Argument("noise", "standard normal samples of each joint", SensorNoise(0.0, 0.0), n),
                Argument("sensed", "readings, which are filled", Sensed(nothing, nothing), output=True),
            ),
            sampled,
        )
