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
from layflat.identify.model import FITTED, Model
from layflat.machine import Machine
from layflat.machine.rigs import FrictionRig, RegulatedRig, Rig, VesselRig

if TYPE_CHECKING:
    import xarray

Logs: TypeAlias = "Mapping[str, xarray.Dataset]"


class Bench(NamedTuple):
    """A kind of bench: its blocks, those that are fitted where nothing else is said, and how to make a model.

    `model` takes the description, logs to fit, blocks, and logs to judge. Logs are `even` where a simulation steps
    through them; else every sample stays at its own stamp.
    """

    blocks: Sequence[str]
    usual: Sequence[str]
    model: Callable[[Any, Logs, Sequence[str], Logs], Model]
    even: bool


def _moving(machine: Machine, logs: Logs, blocks: Sequence[str], judged: Logs) -> Model:
    if machine.valve is None:
        right = "give a machine with a valve; or logs with torque and without voltage, of a joint that is turned"
        raise InputError("has no valve", where=machine.origin, right=right)
    if "sensors" in blocks and machine.pressure_sensor is None:
        raise InputError("has no pressure sensor", where=machine.origin, right="leave sensors out of --fit")
    for name, log in (*logs.items(), *judged.items()):
        for signal in ("angle", "voltage"):
            for joint in machine.joints:
                if not _known(log, signal, joint):
                    right = f"map a column to the signal {signal} of every joint: {', '.join(machine.joints)}"
                    raise InputError(f"has no {signal} of joint {joint!r}", where=name, right=right)
    return ArmModel(machine, logs, blocks, judged)


def _loops(machine: Machine, logs: Logs, blocks: Sequence[str], judged: Logs) -> Model:
    turned = [joint for joint in machine.joints if any(_known(log, "torque", joint) for log in logs.values())]
    if len(turned) > 1:
        right = f"give logs of one of them: {', '.join(turned)}"
        raise InputError(f"hold torques of {len(turned)} joints", where="logs", right=right)
    for name, log in (*logs.items(), *judged.items()):
        for signal in ("torque", "angle", "pressure_a"):
            if not _known(log, signal, turned[0]):
                right = f"map a column to the signal {signal}"
                raise InputError(f"has no {signal} of joint {turned[0]!r}", where=name, right=right)
    return LoopModel(machine, logs, judged, joint=turned[0], blocks=blocks)


def _known(log: xarray.Dataset, signal: str, joint: str) -> bool:
    """Whether a log has any sample of a joint's signal."""
    if signal not in log or ("joint" in log[signal].dims and joint not in log["joint"].values):
        return False
    values = log[signal].sel(joint=joint) if "joint" in log[signal].dims else log[signal]
    return bool(values.notnull().any())


def _rod(rig: FrictionRig, logs: Logs, blocks: Sequence[str], judged: Logs) -> Model:
    return RodModel(rig, logs, judged, blocks=blocks)


def _regulated(rig: RegulatedRig, logs: Logs, blocks: Sequence[str], judged: Logs) -> Model:
    share = 1.0 if judged else FITTED
    return RegulatedModel(rig, {**logs, **judged}, blocks=blocks, judged=list(judged), fitted_share=share)


def _vessel(rig: VesselRig, logs: Logs, blocks: Sequence[str], judged: Logs) -> Model:
    share = 1.0 if judged else FITTED
    return vessel_model(rig, {**logs, **judged}, find=blocks, judged=list(judged), fitted_share=share)


MOVING = Bench(ARM_BLOCKS, ("valve", "hose", "losses", "friction", "inertia"), _moving, even=True)
TURNED = Bench(LOOP_BLOCKS, ("torque", "losses"), _loops, even=False)
BENCHES: Mapping[type[Rig], Bench] = {
    FrictionRig: Bench(ROD_BLOCKS, ("piston", "friction"), _rod, even=False),
    RegulatedRig: Bench(tuple(REGULATED_BLOCKS), tuple(REGULATED_BLOCKS), _regulated, even=True),
    VesselRig: Bench(tuple(VESSEL_BLOCKS), tuple(VESSEL_BLOCKS), _vessel, even=False),
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
    blocks = list(bench.usual) if fitted is None else [part.strip() for part in fitted.split(",")]
    strange = [block for block in blocks if block not in bench.blocks]
    if strange:
        right = f"choose of {', '.join(bench.blocks)}"
        raise InputError(f"{strange[0]!r} is no block of this bench", where="--fit", right=right)
    return list(dict.fromkeys(blocks))
