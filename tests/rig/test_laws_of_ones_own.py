"""Control laws that are not the paper's, in a rig's loop: compiled, and as plain Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import numpy as np
import pytest

from layflat.control import CONTROL_LAWS, FULL_FRACTIONS, Command, ControlKind, ControllerPart, voltages_alone
from layflat.errors import KindError
from layflat.jit import law
from layflat.lanes import each
from layflat.machine import Machine, load
from layflat.rig.safety.faults import Fault, RigState
from tests.rig.fake_rig import Rig


class PlainReport(NamedTuple):
    error: float


class CompiledReport(NamedTuple):
    error: float


class PlainSettings(NamedTuple):
    gain: float
    damping: float


class CompiledSettings(NamedTuple):
    gain: float
    damping: float


class Memory(NamedTuple):
    cycles: float


class PlainPart(ControllerPart):
    kind: Literal["plain-proportional"]


class CompiledPart(ControllerPart):
    kind: Literal["compiled-proportional"]


def plain_wake(_settings: PlainSettings, _sensed: Any) -> Memory:
    return Memory(0.0)


def plain_step(
    settings: PlainSettings, memory: Memory, sensed: Any, demand: Any, _elapsed: float
) -> tuple[Memory, Command, tuple[PlainReport, ...]]:
    """Python that the compiler would not take."""
    voltages, reports = [], []
    for angle, pressure, wanted in zip(sensed.angle, sensed.differential_pressure, demand.angle, strict=True):
        asked = 5.0 + settings.gain * (wanted - angle) - settings.damping * pressure
        voltages.append(min(max(asked, 0.0), 10.0))
        reports.append(PlainReport(error=wanted - angle))
    return Memory(memory.cycles + 1.0), Command(tuple(voltages), (FULL_FRACTIONS,) * len(voltages)), tuple(reports)


@law
def compiled_wake(settings: Any, sensed: Any) -> Memory:
    return Memory(0.0)


@law
def _one(angle: float, pressure: float, wanted: float) -> Any:
    asked = 5.0 + 20.0 * (wanted - angle) - 2e-5 * pressure
    return min(max(asked, 0.0), 10.0), CompiledReport(wanted - angle)


@law
def compiled_step(settings: Any, memory: Any, sensed: Any, demand: Any, elapsed: float) -> Any:
    voltages, reports = each(_one, sensed.angle, sensed.differential_pressure, demand.angle)
    return Memory(memory.cycles + 1.0), voltages_alone(voltages), reports


SIGNALS = {"error": ("rad", "demand less angle")}
PLAIN = ControlKind(
    name="plain-proportional", description=PlainPart, parameters=lambda *_: PlainSettings(20.0, 2e-5),
    parameter_types=(PlainSettings,), wake=plain_wake, step=plain_step, report=PlainReport, signals=SIGNALS,
)  # fmt: skip
COMPILED = ControlKind(
    name="compiled-proportional", description=CompiledPart, parameters=lambda *_: CompiledSettings(20.0, 2e-5),
    parameter_types=(CompiledSettings,), wake=compiled_wake, step=compiled_step, report=CompiledReport, signals=SIGNALS,
)  # fmt: skip


class BrakingPart(ControllerPart):
    kind: Literal["braking"]


class BrakingSettings(NamedTuple):
    gain: float
    damping: float


class BrakingReport(NamedTuple):
    error: float


def braking_step(settings: Any, memory: Memory, sensed: Any, demand: Any, elapsed: float) -> Any:
    """Hold with the brake alone where nothing is asked."""
    memory, command, reports = plain_step(settings, memory, sensed, demand, elapsed)
    shares = tuple(FULL_FRACTIONS if abs(angle) > 0.1 else FULL_FRACTIONS._replace(brake=0.5) for angle in demand.angle)
    return memory, Command(command.voltage, shares), tuple(BrakingReport(one.error) for one in reports)


BRAKING = ControlKind(
    name="braking", description=BrakingPart, parameters=lambda *_: BrakingSettings(20.0, 2e-5),
    parameter_types=(BrakingSettings,), wake=plain_wake, step=braking_step, report=BrakingReport, signals=SIGNALS,
)  # fmt: skip
for kind in (PLAIN, COMPILED, BRAKING):
    CONTROL_LAWS.register(kind)


def with_law(part: Callable[..., ControllerPart], kind: str) -> Machine:
    arm = load("paper-arm")
    return arm.model_copy(update={"controller": part(kind=kind, cycle="5 ms")})


def moved(machine: Machine) -> Rig:
    rig = Rig(machine, np.zeros(2), seed=2).seconds(0.1)
    rig.host.demands = [0.15, -0.15]
    return rig.seconds(0.25)


@pytest.mark.parametrize(("part", "kind"), [(PlainPart, PLAIN.name), (CompiledPart, COMPILED.name)])
def test_a_law_of_ones_own_moves_a_rig_and_its_signals_are_recorded(part: Any, kind: str) -> None:
    rig = moved(with_law(part, kind))
    layout, rows = rig.loop.layout, np.array(rig.host.rows)
    assert rig.shows(RigState.MOVING)
    assert rig.shows(Fault.NONE)
    joints, at = layout.joint_rows(rows), layout.columns
    assert layout.by_joint["error"] == ("rad", "demand less angle")
    assert "phase" not in at
    expected = joints[:, :, at["demand"]] - joints[:, :, at["measured_angle"]]
    assert np.array_equal(joints[:, :, at["error"]], expected)
    assert np.abs(joints[-1, :, at["error"]]).max() < 0.15, "it went towards the demand"
    means = joints[:, :, at["measured_angle"]][-4:].mean(axis=0)
    assert joints[-1, :, at["averaged_angle"]] == pytest.approx(means), "the rig estimates for itself"


def test_compiled_and_plain_the_same_law_gives_the_same_run() -> None:
    plain, compiled = (np.array(moved(with_law(part, kind.name)).host.rows) for part, kind in PAIRS)
    wall = 1  # the time of day differs, and what a cycle took
    assert np.array_equal(np.delete(plain, [wall, 4, 5], 1), np.delete(compiled, [wall, 4, 5], 1))


def test_a_law_that_commands_brakes_is_refused_on_a_rig() -> None:
    with pytest.raises(KindError, match="control law 'braking' commands a fraction of the brake, which no rig sets"):
        Rig(with_law(BrakingPart, BRAKING.name), np.zeros(2))


PAIRS = ((PlainPart, PLAIN), (CompiledPart, COMPILED))
