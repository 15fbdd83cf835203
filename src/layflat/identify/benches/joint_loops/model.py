"""Torque-angle curves of a joint: torque from its angle and the pressures in its hoses, moved slowly.

A log is a data set over `time` (s) with `angle` (rad), `pressure_a` and, where hose B is not vented, `pressure_b`
(absolute, Pa), `torque` (N m, which the joint gives, positive forward), and perhaps `brake` (share of the brake). Logs
at two pressures or more separate what of the losses does not grow with pressure, and the brake, from the rest. Each
kind of losses has unknowns of its own, and a place where a search of another kind begins.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.description.change import annotation_at, quantity_of
from layflat.errors import InputError
from layflat.identify.benches.contract import Bench, Logs, chosen, has_samples, require_samples, simulated
from layflat.identify.benches.hysteresis import logs as curves
from layflat.identify.benches.hysteresis.model import LEAST, MOST, CurveModel, element_unknowns, within
from layflat.identify.benches.joint_loops.run import TurnedJoint, TurnedLog, turned_torque
from layflat.identify.logs.checks.channels import without_spikes
from layflat.identify.model import Output
from layflat.identify.unknown import Unknown
from layflat.machine import Joint, Machine, parameters
from layflat.machine.exchanged import with_losses
from layflat.physics.hysteresis import LossesPart

FINE = "reversals, sampled finely where the motion reverses"
SMALL = "small motions beside large ones"
STEEPEST, HARDEST = 3.0, 0.2  # greatest beta, and stiffness of the spring over that of the curve's start
SLOPE = 2.0  # greatest power of an element's deflection that its share grows or falls with


def loss_unknowns(at: str, losses: LossesPart, travel: float) -> list[Unknown] | None:
    """Return the unknowns of losses at a path, of a joint that turned by `travel` (rad); None: not of this kind."""
    low, high = LEAST * travel, MOST * travel

    def turn(key: str) -> Unknown:
        return within(f"{at}.{key}", "rad", getattr(losses, key), low, high, FINE, log=True)

    def number(key: str, least: float, most: float) -> Unknown:
        found = within(f"{at}.{key}", "1", getattr(losses, key), least, most, SMALL)
        # The ends are those of the law, but for how large a number may sensibly be.
        return replace(found, floor=True, ceiling=key == "exponent")

    if losses.kind == "elasto-slip":
        return element_unknowns(at, "rad", losses.deflections, losses.weights, travel)
    if losses.kind == "elasto-slip-spectrum":
        return [turn("first"), turn("last"), number("slope", -SLOPE, SLOPE)]
    if losses.kind == "bouc-wen":
        shape = [number("beta", 0.5, STEEPEST), number("exponent", 1.0, 2.0), number("hardening", 0.0, HARDEST)]
        return [turn("deflection"), *shape]
    return None


STARTS: Mapping[str, Any] = {
    "elasto-slip-spectrum": lambda travel: {"first": 0.02 * travel, "last": 0.5 * travel},
    "bouc-wen": lambda travel: {"deflection": 0.05 * travel},
    "elasto-slip": lambda travel: {
        "deflections": tuple(share * travel for share in (0.02, 0.1, 0.5)),
        "weights": (0.4, 0.3, 0.3),
    },
}
"""Kinds that logs are compared by, the simplest first, and where each begins, from the travel (rad)."""


def replaced_losses(machine: Machine, joint: str) -> dict[str, Any]:
    """Return the table of a joint's losses as it stands in a file, by its path."""
    losses = machine.joint[joint].losses

    def text(path: str, value: Any) -> Any:
        quantity = quantity_of(annotation_at(losses, path))
        return value if quantity is None else quantity.text(value, quantity.unit)

    table = {}
    for key in type(losses).model_fields:
        value = getattr(losses, key)
        several = isinstance(value, tuple)
        table[key] = [text(f"{key}.{i}", one) for i, one in enumerate(value)] if several else text(key, value)
    return {f"joint.{joint}.losses": table}


BLOCKS = ("torque", "losses", "brake", "offset")  # scale of Eq. (1), losses, brake's torque, zero of the torque sensor
SCALES = 10.0  # measured torque is at most so many times that of Eq. (1), and at least this part of it
LEAST_SHARE = 1e-3  # least loss that is searched, height of the curve over torque
OFFSET = "log.torque_offset"


class LoopModel(CurveModel[Machine]):
    """Torques in the logs of one joint, by default the first of the arm; made as `Bench` says.

    Default blocks are torque and losses, and the brake where the machine has one.
    """

    def __init__(
        self,
        machine: Machine,
        logs: Logs,
        validation: Logs | None = None,
        *,
        joint: str | None = None,
        blocks: Sequence[str] | None = None,
    ) -> None:
        self.origin, self.joint = machine, joint or machine.arm.joints[0]
        if self.joint not in machine.joint:
            raise InputError(f"unknown joint {self.joint!r}", where="joint", right=f"use {', '.join(machine.joint)}")
        self.losses = f"joint.{self.joint}.losses"
        braked = machine.joint[self.joint].brake.torque > 0.0
        blocks = blocks or ("torque", "losses", *(("brake",) if braked else ()))
        self.outputs = curves.outputs(logs, validation, "torque", "N*m", self.joint)
        every = [*logs.values(), *(validation or {}).values()]
        self.logs = tuple(self._given(log, out) for log, out in zip(every, self.outputs, strict=True))
        self.motions = tuple(log.angle for log in self.logs)
        self.unknowns = tuple(chosen(self._unknowns(), blocks))

    def simulate(self, values: Array) -> Array:
        """Torques by candidate: see `Model.simulate`."""
        described = self.candidates(values).joint[self.joint]
        hose_a = parameters.hose(described)
        hose_b = hose_a if described.acting == "double" else parameters.no_hose(hose_a)
        offset: Any = self.columns(values).get(OFFSET, 0.0)
        joint = TurnedJoint(hose_a, hose_b, parameters.friction(described), described.brake.torque, offset)
        cases = [(joint, log) for log in self.logs]
        return np.concatenate(simulated(turned_torque, len(values), cases, [one.shape for one in self.motions]), axis=1)

    def _unknowns(self) -> dict[str, list[Unknown]]:
        described: Joint = self.origin.joint[self.joint]
        at = f"joint.{self.joint}"
        known = [out.measured[np.isfinite(out.measured)] for out in self.outputs]
        travel = max(float(np.ptp(log.angle)) for log in self.logs)
        reach, most = max(float(np.ptp(one)) for one in known), max(float(np.abs(one).max()) for one in known)
        apart = "loops at two pressures or more, the higher the further apart"
        hose, losses = described.hose, described.losses
        own = loss_unknowns(f"{at}.losses", losses, travel)
        if own is None:
            what, right = f"losses of kind {losses.kind!r} can't be fitted to loops", f"use {', '.join(STARTS)}"
            raise InputError(what, where=self.origin.origin, right=right)
        return {
            "torque": [
                within(f"{at}.hose.torque_factor", "1", hose.torque_factor, 1.0 / SCALES, SCALES, apart, log=True)
            ],
            "losses": [
                within(f"{at}.hose.loss_share", "1", hose.loss_share, LEAST_SHARE, 1.0, "motion to and fro", log=True),
                within(f"{at}.losses.pressure_free", "1", losses.pressure_free, 0.0, 1.0, apart),
                *own,
            ],
            "brake": [within(f"{at}.brake.torque", "N*m", described.brake.torque, 0.0, reach, apart)],
            "offset": [Unknown(OFFSET, "N*m", 0.0, -most, most, log=False, excitation=apart, nuisance=True)],
        }

    def _given(self, log: Dataset, out: Output) -> TurnedLog:
        """Return what is given of a log."""
        ambient = self.origin.supply.ambient_pressure
        angle = curves.moving(log, "angle", out.log, self.joint)
        gauge = [np.zeros_like(angle), np.zeros_like(angle)]
        for i, name in enumerate(("pressure_a", "pressure_b")):
            if i == 0 or name in log:
                gauge[i] = without_spikes(curves.signal(log, name, out.log, self.joint)) - ambient
        brake = curves.signal(log, "brake", out.log, self.joint) if "brake" in log else np.ones_like(angle)
        give = max(curves.NOISES * curves.noise(angle), LEAST * float(np.ptp(angle)))
        return TurnedLog(angle, gauge[0], gauge[1], brake, curves.first_of(out), give)


def _moved(machine: Machine, logs: Logs) -> list[str]:
    """Joints whose torques the logs hold; raise InputError if there are several."""
    moved = [joint for joint in machine.joints if any(has_samples(log, "torque", joint) for log in logs.values())]
    if len(moved) > 1:
        right = f"give logs of one of them: {', '.join(moved)}"
        raise InputError(f"hold torques of {len(moved)} joints", where="logs", right=right)
    return moved


def _model(machine: Machine, logs: Logs, validation: Logs, *, blocks: Sequence[str]) -> LoopModel:
    moved = _moved(machine, logs)
    require_samples({**logs, **validation}, ("torque", "angle", "pressure_a"), moved[:1])
    return LoopModel(machine, logs, validation, joint=moved[0], blocks=blocks)


def _kinds(machine: Machine, logs: Logs, blocks: Sequence[str]) -> dict[str, tuple[Machine, dict[str, Any]]]:
    """The machine with each kind of losses that loops are compared by; with its own as they are described."""
    (joint,) = _moved(machine, logs)
    own = machine.joint[joint].losses.kind
    if "losses" not in blocks or own not in STARTS:
        return {}
    angles = [curves.moving(log, "angle", name, joint) for name, log in logs.items()]
    travel, found = max(float(np.ptp(one)) for one in angles), {}
    for kind, start in STARTS.items():
        tried = machine if kind == own else with_losses(machine, kind, start(travel), (joint,))
        found[kind] = tried, {} if kind == own else replaced_losses(tried, joint)
    return found


BENCH = Bench(BLOCKS, ("torque", "losses"), _model, even=False, kinds=_kinds)
