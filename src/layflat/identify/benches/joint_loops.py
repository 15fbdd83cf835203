"""Torque-angle curves of a joint that is moved slowly: torque from its angle and the pressures in its hoses.

A log is a data set over `time` (s) with `angle` (rad), `pressure_a` and, where hose B is not vented, `pressure_b`
(absolute, Pa), `torque` (N m, of the joint on its surroundings, positive forward), and perhaps `brake` (duty of the
brake, 0..1). Logs at two pressures or more separate losses that do not grow with pressure, and the brake, from the
rest. Each kind of losses has unknowns of its own, and values at which a search of another kind begins.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.description.change import annotation_at, quantity_of
from layflat.errors import InputError
from layflat.identify.benches import BenchKind, Logs, has_samples, require_samples, select_blocks, simulate_candidates
from layflat.identify.benches import hysteresis as curves
from layflat.identify.benches.hysteresis import (
    FINE_REVERSALS,
    MAX_DEFLECTION_RATIO,
    MIN_DEFLECTION_RATIO,
    CurveModel,
    bounded_unknown,
    element_unknowns,
)
from layflat.identify.benches.turned_joint import TurnedJoint, TurnedLog, turned_torque
from layflat.identify.logs.checks.channels import median_filter
from layflat.identify.model import ModelOutput, Unknown
from layflat.machine import Joint, Machine, parameters
from layflat.machine.exchanged import with_losses
from layflat.physics.hysteresis import LossesPart

SMALL_MOTIONS = "small motions beside large ones"
MAX_BETA = 3.0  # of Bouc and Wen's law
MAX_HARDENING = 0.2  # stiffness of the spring over that of the curve's start
MAX_SPECTRUM_SLOPE = 2.0  # greatest power of an element's deflection that its weight grows or falls with


def loss_unknowns(where: str, losses: LossesPart, travel: float) -> list[Unknown] | None:
    """Return the unknowns of a joint's losses, or None for a kind that loops don't identify.

    Args:
        where: path of the losses in the description.
        losses: described ones.
        travel: rotation of the joint in the logs, rad; bounds deflections.
    """
    bounds = MIN_DEFLECTION_RATIO * travel, MAX_DEFLECTION_RATIO * travel

    def rotation(key: str) -> Unknown:
        return bounded_unknown(f"{where}.{key}", "rad", getattr(losses, key), bounds, FINE_REVERSALS, log=True)

    def number(key: str, lower: float, upper: float) -> Unknown:
        unknown = bounded_unknown(f"{where}.{key}", "1", getattr(losses, key), (lower, upper), SMALL_MOTIONS)
        # The bounds are those of the law, but for the greatest sensible number.
        return replace(unknown, floor=True, ceiling=key == "exponent")

    if losses.kind == "elasto-slip":
        return element_unknowns(where, "rad", losses.deflections, losses.weights, travel)
    if losses.kind == "elasto-slip-spectrum":
        return [rotation("first"), rotation("last"), number("slope", -MAX_SPECTRUM_SLOPE, MAX_SPECTRUM_SLOPE)]
    if losses.kind == "bouc-wen":
        shape = [
            number("beta", 0.5, MAX_BETA), number("exponent", 1.0, 2.0), number("hardening", 0.0, MAX_HARDENING)
        ]  # fmt: skip
        return [rotation("deflection"), *shape]
    return None


STARTING_LOSSES: Mapping[str, Any] = {
    "elasto-slip-spectrum": lambda travel: {"first": 0.02 * travel, "last": 0.5 * travel},
    "bouc-wen": lambda travel: {"deflection": 0.05 * travel},
    "elasto-slip": lambda travel: {
        "deflections": tuple(fraction * travel for fraction in (0.02, 0.1, 0.5)),
        "weights": (0.4, 0.3, 0.3),
    },
}
"""Kinds of losses that are compared on logs, the simplest first, and the start of each search from the travel (rad)."""


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
        table[key] = [text(f"{key}.{i}", item) for i, item in enumerate(value)] if several else text(key, value)
    return {f"joint.{joint}.losses": table}


LOOP_BLOCKS = ("torque", "losses", "brake", "offset")  # factor of Eq. (1), losses, brake's torque, zero of the sensor
MAX_TORQUE_RATIO = 10.0  # greatest ratio of measured torques and those of Eq. (1), either way
MIN_LOSS_SHARE = 1e-3  # lower bound of the loss, height of the curve over torque
OFFSET_PATH = "log.torque_offset"


class LoopModel(CurveModel[Machine]):
    """Model of the torques in the logs of one joint, by default the first of the arm; built as `BenchKind` says.

    Default blocks are torque and losses, and the brake where the joint has one. InputError also: an unknown joint.
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
        self.outputs = curves.effort_outputs(logs, validation, "torque", "N*m", self.joint)
        all_logs = [*logs.values(), *(validation or {}).values()]
        self.logs = tuple(self._read_log(log, out) for log, out in zip(all_logs, self.outputs, strict=True))
        self.motions = tuple(log.angle for log in self.logs)
        self.unknowns = tuple(select_blocks(self._unknowns(), blocks))

    def simulate(self, values: Array) -> Array:
        """Return the torques of all logs, (candidates, samples): see `Model.simulate`."""
        described = self.describe_candidates(values).joint[self.joint]
        hose_a = parameters.hose(described)
        hose_b = hose_a if described.acting == "double" else parameters.missing_hose(hose_a)
        offset: Any = self.columns(values).get(OFFSET_PATH, 0.0)
        joint = TurnedJoint(hose_a, hose_b, parameters.friction(described), described.brake.torque, offset)
        cases = [(joint, log) for log in self.logs]
        shapes = [angle.shape for angle in self.motions]
        return np.concatenate(simulate_candidates(turned_torque, len(values), cases, shapes), axis=1)

    def _unknowns(self) -> dict[str, list[Unknown]]:
        """Return the unknowns by block (torque, losses, brake, offset), with bounds from the range of the logs.

        Raises:
            InputError: this kind of losses can't be fitted to loops.
        """
        described: Joint = self.origin.joint[self.joint]
        where = f"joint.{self.joint}"
        measured = [out.measured[np.isfinite(out.measured)] for out in self.outputs]
        travel = max(float(np.ptp(log.angle)) for log in self.logs)
        span, peak = max(float(np.ptp(one)) for one in measured), max(float(np.abs(one).max()) for one in measured)
        pressures = "loops at two pressures or more, the higher the further apart"
        hose, losses = described.hose, described.losses
        of_kind = loss_unknowns(f"{where}.losses", losses, travel)
        if of_kind is None:
            what = f"losses of kind {losses.kind!r} can't be fitted to loops"
            raise InputError(what, where=self.origin.origin, right=f"use {', '.join(STARTING_LOSSES)}")
        factors, shares = (1.0 / MAX_TORQUE_RATIO, MAX_TORQUE_RATIO), (MIN_LOSS_SHARE, 1.0)
        torque = described.brake.torque
        return {
            "torque": [
                bounded_unknown(f"{where}.hose.torque_factor", "1", hose.torque_factor, factors, pressures, log=True)
            ],
            "losses": [
                bounded_unknown(
                    f"{where}.hose.loss_fraction", "1", hose.loss_fraction, shares, "motion to and fro", log=True
                ),
                bounded_unknown(f"{where}.losses.pressure_free", "1", losses.pressure_free, (0.0, 1.0), pressures),
                *of_kind,
            ],
            "brake": [bounded_unknown(f"{where}.brake.torque", "N*m", torque, (0.0, span), pressures)],
            "offset": [Unknown(OFFSET_PATH, "N*m", 0.0, -peak, peak, log=False, excitation=pressures, nuisance=True)],
        }

    def _read_log(self, log: Dataset, out: ModelOutput) -> TurnedLog:
        """Return angle, gauge pressures, brake duty and first torque of a log, and the rotation at which a brake slips.

        Without a signal the gauge pressure of hose B is 0, and the duty 1. Raises InputError as `read_signal` does.
        """
        ambient = self.origin.supply.ambient_pressure
        angle = curves.read_moving_signal(log, "angle", out.log, self.joint)
        gauge = [np.zeros_like(angle), np.zeros_like(angle)]
        for i, name in enumerate(("pressure_a", "pressure_b")):
            if i == 0 or name in log:
                gauge[i] = median_filter(curves.read_signal(log, name, out.log, self.joint)) - ambient
        brake = curves.read_signal(log, "brake", out.log, self.joint) if "brake" in log else np.ones_like(angle)
        noise, travel = curves.noise_level(angle), float(np.ptp(angle))
        slip_angle = max(curves.SLIP_NOISE_RATIO * noise, MIN_DEFLECTION_RATIO * travel)
        return TurnedLog(angle, gauge[0], gauge[1], brake, curves.first_sample(out), slip_angle)


def _find_moved_joint(machine: Machine, logs: Logs) -> str:
    """Return the joint whose torques the logs hold; raise InputError if there are none, or several."""
    moved = [joint for joint in machine.joints if any(has_samples(log, "torque", joint) for log in logs.values())]
    if not moved:
        raise InputError("hold no torque of any joint", where="logs", right="map a column to the signal torque")
    if len(moved) > 1:
        right = f"give logs of one of them: {', '.join(moved)}"
        raise InputError(f"hold torques of {len(moved)} joints", where="logs", right=right)
    return moved[0]


def _build_model(machine: Machine, logs: Logs, validation: Logs, *, blocks: Sequence[str]) -> LoopModel:
    """Return the model of the one joint whose torques the logs hold.

    Raises:
        InputError: the logs hold torques of no joint or several, or one lacks a signal of that joint.
    """
    moved = _find_moved_joint(machine, logs)
    require_samples({**logs, **validation}, ("torque", "angle", "pressure_a"), [moved])
    return LoopModel(machine, logs, validation, joint=moved, blocks=blocks)


def _build_alternatives(
    machine: Machine, logs: Logs, blocks: Sequence[str]
) -> dict[str, tuple[Machine, dict[str, Any]]]:
    """Return by kind of losses: the machine with them, and the parts of its file that change, none for its own kind.

    There are none where the losses are not fitted, or are of a kind outside `STARTING_LOSSES`.
    """
    joint = _find_moved_joint(machine, logs)
    described = machine.joint[joint].losses.kind
    if "losses" not in blocks or described not in STARTING_LOSSES:
        return {}
    angles = [curves.read_moving_signal(log, "angle", name, joint) for name, log in logs.items()]
    travel, alternatives = max(float(np.ptp(one)) for one in angles), {}
    for kind, start in STARTING_LOSSES.items():
        changed = machine if kind == described else with_losses(machine, kind, start(travel), (joint,))
        alternatives[kind] = changed, {} if kind == described else replaced_losses(changed, joint)
    return alternatives


BENCH = BenchKind(LOOP_BLOCKS, ("torque", "losses"), _build_model, even=False, alternatives=_build_alternatives)
