"""Torque-angle loops of a joint: torque from its angle and the pressures in its hoses, turned slowly.

A log is a data set over `time` (s) with `angle` (rad), `pressure_a` and, where hose B is not vented, `pressure_b`
(absolute, Pa), `torque` (N m, which the joint gives, positive forward), and perhaps `brake` (share of the brake). Logs
at two pressures or more tell what of the losses does not grow with pressure, and the brake from these.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.description.change import changed_all, value_at
from layflat.errors import InputError
from layflat.identify.benches import loop_logs
from layflat.identify.benches.loop_logs import Logs, elements, of_range, rounded, shares_of
from layflat.identify.model import Array, Model, Output
from layflat.identify.unknown import Unknown
from layflat.machine import Joint, Machine, changed, parameters
from layflat.sim.loops import TurnedLog, turned_torques

if TYPE_CHECKING:
    import xarray

BLOCKS = ("torque", "losses", "brake", "offset")
"""What can be found: scale of Eq. (1), losses, the brake's torque, zero of the torque sensor."""

SCALES = 10.0
"""Measured torque is at most so many times that of Eq. (1), and at least this part of it."""

LEAST_SHARE = 1e-3
"""Least loss that is searched, loop height over torque."""

OFFSET = "log.torque_offset"


class LoopModel(Model):
    """Torques in the logs of one joint.

    Args:
        machine: where the search begins, and what is held.
        logs: to fit, by name.
        judged: logs that are only predicted; without any, the last third of each log is.
        joint: its name; the first of the arm where not given.
        blocks: what to find, of `BLOCKS`; usually torque and losses, and the brake where the machine has one.

    Raises:
        InputError: a log lacks a signal, or there is no such joint or block.
    """

    def __init__(
        self,
        machine: Machine,
        logs: Logs,
        judged: Logs | None = None,
        *,
        joint: str | None = None,
        blocks: Collection[str] | None = None,
    ) -> None:
        self.machine, self.joint = machine, joint or machine.arm.joints[0]
        if self.joint not in machine.joint:
            raise InputError(f"{self.joint!r} is no joint", where="joint", right=f"use {', '.join(machine.joint)}")
        braked = machine.joint[self.joint].brake.torque > 0.0
        self.blocks = tuple(blocks or ("torque", "losses", *(("brake",) if braked else ())))
        loop_logs.check_blocks(self.blocks, BLOCKS)
        self.outputs = loop_logs.outputs(logs, judged, "torque", "N*m", self.joint)
        every = [*logs.values(), *(judged or {}).values()]
        self.logs = tuple(self._given(log, out) for log, out in zip(every, self.outputs, strict=True))
        self.unknowns = tuple(self._unknowns())
        self._place = {unknown.path: i for i, unknown in enumerate(self.unknowns)}

    def simulate(self, values: Array) -> Array:
        """Torques by candidate: see `Model.simulate`."""
        described = self._with(values.T).joint[self.joint]
        hose_a = parameters.hose(described)
        hose_b = hose_a if described.acting == "double" else parameters.NO_HOSE
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
                of_range(
                    f"{self._at}.hose.torque_factor", "1", hose.torque_factor, 1.0 / SCALES, SCALES, apart, log=True
                )
            ],
            "losses": [
                of_range(share, "1", hose.loss_share, LEAST_SHARE, 1.0, "motion to and fro", log=True),
                of_range(f"{self._at}.losses.pressure_free", "1", losses.pressure_free, 0.0, 1.0, apart),
                *elements(f"{self._at}.losses", "rad", losses.deflections, losses.weights, travel),
            ],
            "brake": [of_range(f"{self._at}.brake.torque", "N*m", described.brake.torque, 0.0, reach, apart)],
            "offset": [Unknown(OFFSET, "N*m", 0.0, -most, most, log=False, excitation=apart, nuisance=True)],
        }
        return [unknown for block, found in blocks.items() if block in self.blocks for unknown in found]

    def _given(self, log: xarray.Dataset, out: Output) -> TurnedLog:
        """What is given of a log."""
        ambient = self.machine.supply.ambient_pressure
        angle = loop_logs.without_spikes(loop_logs.signal(log, "angle", out.log, self.joint))
        travel = float(np.ptp(angle))
        if travel == 0.0:
            raise InputError("the angle never changes", where=out.log, right="leave the log out")
        gauge = [np.zeros_like(angle), np.zeros_like(angle)]
        for i, name in enumerate(("pressure_a", "pressure_b")):
            if i == 0 or name in log:
                gauge[i] = loop_logs.without_spikes(loop_logs.signal(log, name, out.log, self.joint)) - ambient
        brake = loop_logs.signal(log, "brake", out.log, self.joint) if "brake" in log else np.ones_like(angle)
        give = max(loop_logs.NOISES * loop_logs.noise(angle), loop_logs.LEAST * travel)
        return TurnedLog(angle, gauge[0], gauge[1], brake, loop_logs.first_of(out.measured), give)
