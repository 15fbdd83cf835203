"""Torque-angle curves of a joint: torque from its angle and the pressures in its hoses, moved slowly.

A log is a data set over `time` (s) with `angle` (rad), `pressure_a` and, where hose B is not vented, `pressure_b`
(absolute, Pa), `torque` (N m, which the joint gives, positive forward), and perhaps `brake` (share of the brake). Logs
at two pressures or more separate what of the losses does not grow with pressure, and the brake, from the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.description.change import changed_all, value_at
from layflat.errors import InputError
from layflat.identify.benches.contract import Bench, Logs, check_known, has_samples
from layflat.identify.benches.hysteresis import logs as curves
from layflat.identify.benches.hysteresis.logs import element_unknowns, rounded, shares_of, within
from layflat.identify.benches.joint_loops.run import TurnedLog, turned_torques
from layflat.identify.model import Array, Model, Output
from layflat.identify.unknown import Unknown
from layflat.machine import Joint, Machine, changed, parameters

if TYPE_CHECKING:
    import xarray

BLOCKS = ("torque", "losses", "brake", "offset")
"""What can be fitted: scale of Eq. (1), losses, the brake's torque, zero of the torque sensor."""

SCALES = 10.0
"""Measured torque is at most so many times that of Eq. (1), and at least this part of it."""

LEAST_SHARE = 1e-3
"""Least loss that is searched, height of the curve over torque."""

OFFSET = "log.torque_offset"


class LoopModel(Model):
    """Torques in the logs of one joint.

    Args:
        machine: where the search begins, and what is held.
        logs: to fit, by name.
        validation: logs that are only predicted; without any, the last third of each log is.
        joint: its name; default: the first of the arm.
        blocks: what to fit, of `BLOCKS`; default: torque and losses, and the brake where the machine has one.

    Raises:
        InputError: a log lacks a signal, or there is no such joint or block.
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
        self.machine, self.joint = machine, joint or machine.arm.joints[0]
        if self.joint not in machine.joint:
            raise InputError(f"unknown joint {self.joint!r}", where="joint", right=f"use {', '.join(machine.joint)}")
        braked = machine.joint[self.joint].brake.torque > 0.0
        blocks = blocks or ("torque", "losses", *(("brake",) if braked else ()))
        self.blocks = tuple(check_known(blocks, BLOCKS, "blocks", "block"))
        self.outputs = curves.outputs(logs, validation, "torque", "N*m", self.joint)
        every = [*logs.values(), *(validation or {}).values()]
        self.logs = tuple(self._given(log, out) for log, out in zip(every, self.outputs, strict=True))
        self.unknowns = tuple(self._unknowns())
        self._place = {unknown.path: i for i, unknown in enumerate(self.unknowns)}

    def simulate(self, values: Array) -> Array:
        """Torques by candidate: see `Model.simulate`."""
        described = self._with(values.T).joint[self.joint]
        hose_a = parameters.hose(described)
        hose_b = hose_a if described.acting == "double" else parameters.no_hose(hose_a)
        brake = np.broadcast_to(described.brake.torque, len(values)).astype(np.float64)
        offset = values[:, self._place[OFFSET]] if OFFSET in self._place else np.zeros(len(values))
        torques = []
        for log in self.logs:
            first = log.first - offset
            torques.append(turned_torques(hose_a, hose_b, brake, first, log) + offset[:, None])
        return np.concatenate(torques, axis=1)

    def described(self, values: Array) -> Machine:
        """The machine with values of the unknowns (SI) in their places."""
        machine = self._with([float(value) for value in values])
        weights = np.array(machine.joint[self.joint].losses.weights)
        return changed(machine, f"{self._at}.losses.weights", rounded(weights)) if "losses" in self.blocks else machine

    def written(self, values: Array) -> dict[str, float]:
        """What was found, by its path in the description: weights in place of how they are split."""
        machine = self.described(values)
        paths = [u.path for u in self.unknowns if ".split." not in u.path and not u.nuisance]
        if "losses" in self.blocks:
            paths += [f"{self._at}.losses.weights.{j}" for j in range(3)]
        return {path: float(value_at(machine, path)) for path in paths}

    @property
    def motions(self) -> tuple[Array, ...]:
        """Angle of every log, rad."""
        return tuple(log.angle for log in self.logs)

    @property
    def _at(self) -> str:
        return f"joint.{self.joint}"

    def _with(self, columns: Array | list[float]) -> Machine:
        """The machine with a number, or an array of all candidates, for each unknown."""
        found: dict[str, Any] = {}
        split = []
        for unknown, column in zip(self.unknowns, columns, strict=True):
            if ".split." in unknown.path:
                split.append(column)
            elif not unknown.nuisance:
                found[unknown.path] = column
        if split:
            weights = tuple(np.moveaxis(shares_of(np.stack(split, axis=-1)), -1, 0))
            found[f"{self._at}.losses.weights"] = weights
        return changed_all(self.machine, found, together=False)  # a search goes where no machine could

    def _unknowns(self) -> list[Unknown]:
        described: Joint = self.machine.joint[self.joint]
        known = [out.measured[np.isfinite(out.measured)] for out in self.outputs]
        travel = max(float(np.ptp(log.angle)) for log in self.logs)
        reach, most = max(float(np.ptp(one)) for one in known), max(float(np.abs(one).max()) for one in known)
        apart = "loops at two pressures or more, the higher the further apart"
        hose, losses = described.hose, described.losses
        share = f"{self._at}.hose.loss_share"
        blocks = {
            "torque": [
                within(f"{self._at}.hose.torque_factor", "1", hose.torque_factor, 1.0 / SCALES, SCALES, apart, log=True)
            ],
            "losses": [
                within(share, "1", hose.loss_share, LEAST_SHARE, 1.0, "motion to and fro", log=True),
                within(f"{self._at}.losses.pressure_free", "1", losses.pressure_free, 0.0, 1.0, apart),
                *element_unknowns(f"{self._at}.losses", "rad", losses.deflections, losses.weights, travel),
            ],
            "brake": [within(f"{self._at}.brake.torque", "N*m", described.brake.torque, 0.0, reach, apart)],
            "offset": [Unknown(OFFSET, "N*m", 0.0, -most, most, log=False, excitation=apart, nuisance=True)],
        }
        return [unknown for block, found in blocks.items() if block in self.blocks for unknown in found]

    def _given(self, log: xarray.Dataset, out: Output) -> TurnedLog:
        """What is given of a log."""
        ambient = self.machine.supply.ambient_pressure
        angle = curves.moving(log, "angle", out.log, self.joint)
        gauge = [np.zeros_like(angle), np.zeros_like(angle)]
        for i, name in enumerate(("pressure_a", "pressure_b")):
            if i == 0 or name in log:
                gauge[i] = curves.without_spikes(curves.signal(log, name, out.log, self.joint)) - ambient
        brake = curves.signal(log, "brake", out.log, self.joint) if "brake" in log else np.ones_like(angle)
        give = max(curves.NOISES * curves.noise(angle), curves.LEAST * float(np.ptp(angle)))
        return TurnedLog(angle, gauge[0], gauge[1], brake, curves.first_of(out), give)


def _model(machine: Machine, logs: Logs, blocks: Sequence[str], validation: Logs) -> LoopModel:
    moved = [joint for joint in machine.joints if any(has_samples(log, "torque", joint) for log in logs.values())]
    if len(moved) > 1:
        right = f"give logs of one of them: {', '.join(moved)}"
        raise InputError(f"hold torques of {len(moved)} joints", where="logs", right=right)
    for name, log in (*logs.items(), *validation.items()):
        for signal in ("torque", "angle", "pressure_a"):
            if not has_samples(log, signal, moved[0]):
                right = f"map a column to the signal {signal}"
                raise InputError(f"has no {signal} of joint {moved[0]!r}", where=name, right=right)
    return LoopModel(machine, logs, validation, joint=moved[0], blocks=blocks)


BENCH = Bench(BLOCKS, ("torque", "losses"), _model, even=False)
