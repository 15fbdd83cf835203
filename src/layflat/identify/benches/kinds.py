"""Which bench a description and its logs make: the one place that knows all kinds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from layflat.errors import InputError
from layflat.identify.benches.arm import ArmModel
from layflat.identify.benches.arm_blocks import BLOCKS as ARM_BLOCKS
from layflat.identify.benches.loops import BLOCKS as LOOP_BLOCKS
from layflat.identify.benches.loops import LoopModel
from layflat.identify.benches.regulated import RegulatedModel
from layflat.identify.benches.regulated_unknowns import BLOCKS as REGULATED_BLOCKS
from layflat.identify.benches.rod import BLOCKS as ROD_BLOCKS
from layflat.identify.benches.rod import RodModel
from layflat.identify.benches.vessel import BLOCKS as VESSEL_BLOCKS
from layflat.identify.benches.vessel import vessel_model
from layflat.identify.model import Model
from layflat.machine import Machine
from layflat.machine.rigs import FrictionRig, RegulatedRig, Rig, VesselRig

if TYPE_CHECKING:
    import xarray

Logs: TypeAlias = "Mapping[str, xarray.Dataset]"


class Bench(NamedTuple):
    """A kind of bench: its blocks, those that are fitted where nothing else is said, and how to make a model.

    `model` takes the description, logs to fit, blocks, and logs to judge.
    """

    blocks: Sequence[str]
    usual: Sequence[str]
    model: Callable[[Any, Logs, Sequence[str], Logs], Model]


ALL_BUT_THE_LAST_THIRD = 2.0 / 3.0
"""What of a log is fitted where no other log judges."""


def _loops(machine: Machine, logs: Logs, blocks: Sequence[str], judged: Logs) -> Model:
    return LoopModel(machine, logs, judged, blocks=blocks)


def _rod(rig: FrictionRig, logs: Logs, blocks: Sequence[str], judged: Logs) -> Model:
    return RodModel(rig, logs, judged, blocks=blocks)


def _regulated(rig: RegulatedRig, logs: Logs, blocks: Sequence[str], judged: Logs) -> Model:
    share = 1.0 if judged else ALL_BUT_THE_LAST_THIRD
    return RegulatedModel(rig, {**logs, **judged}, blocks=blocks, judged=list(judged), fitted_share=share)


def _vessel(rig: VesselRig, logs: Logs, blocks: Sequence[str], judged: Logs) -> Model:
    share = 1.0 if judged else ALL_BUT_THE_LAST_THIRD
    return vessel_model(rig, {**logs, **judged}, find=blocks, judged=list(judged), fitted_share=share)


MOVING = Bench(ARM_BLOCKS, ("valve", "hose", "losses", "friction", "inertia"), ArmModel)
TURNED = Bench(LOOP_BLOCKS, ("torque", "losses"), _loops)
BENCHES: Mapping[type[Rig], Bench] = {
    FrictionRig: Bench(ROD_BLOCKS, ("piston", "friction"), _rod),
    RegulatedRig: Bench(tuple(REGULATED_BLOCKS), tuple(REGULATED_BLOCKS), _regulated),
    VesselRig: Bench(tuple(VESSEL_BLOCKS), tuple(VESSEL_BLOCKS), _vessel),
}


def bench_of(described: Machine | Rig, logs: Logs) -> Bench:
    """The bench of a description with these logs: a joint is turned slowly where only torque was measured."""
    if isinstance(described, Machine):
        turned = all("torque" in log and "voltage" not in log for log in logs.values())
        return TURNED if turned else MOVING
    return BENCHES[type(described)]


def chosen(bench: Bench, fitted: str | None) -> list[str]:
    """Blocks from text such as "valve, hose".

    Raises:
        InputError: naming one that the bench has not.
    """
    blocks = [part.strip() for part in fitted.split(",")] if fitted else list(bench.usual)
    strange = [block for block in blocks if block not in bench.blocks]
    if strange:
        right = f"choose of {', '.join(bench.blocks)}"
        raise InputError(f"{strange[0]!r} is no block of this bench", where="--fit", right=right)
    return list(dict.fromkeys(blocks))
