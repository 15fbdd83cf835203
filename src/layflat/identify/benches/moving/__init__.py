"""Model of a machine that moves: pressures and angles from the voltages of its valves."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.identify.benches import BenchKind, Logs, require_samples
from layflat.identify.benches.moving.blocks import MACHINE_BLOCKS, machine_unknowns, mirrored_losses
from layflat.identify.benches.moving.bodies import BodyScaling, feasible_columns
from layflat.identify.benches.moving.log import (
    ContinuationStage,
    MachineLog,
    OutputInjectionGains,
    cut_at_impacts,
    sensor_offset,
)
from layflat.identify.model import Model, Scaling, Unknown
from layflat.machine import Machine
from layflat.physics.step import COARSE_STEP

FEEDBACK_RATES, BEGINNING_FRACTION = (4.0, 8.0, 12.0), 0.35
"""First stage: the beginning of the logs with strong feedback; each rate (1/s) begins a continuation of its own."""

FINAL_STAGES = (ContinuationStage(angle=2.0), ContinuationStage(angle=0.5))
"""Next stages: at the step of a simulation run, with weak feedback in the end.

Feedback brings the angle's noise along, which widens errors more than a free run's roughness does: the less the better.
"""

SPATIAL_FEEDBACK_RATE = 2.0  # least rate of valves on an arm in space, 1/s: gravity moves some away in half a second
SPATIAL_STAGES = (
    ContinuationStage(air=20.0, torque=40.0, step=COARSE_STEP, fraction=BEGINNING_FRACTION),
    ContinuationStage(air=1.0, torque=25.0),
    ContinuationStage(angle=SPATIAL_FEEDBACK_RATE, bodies=False),
    ContinuationStage(angle=SPATIAL_FEEDBACK_RATE, bodies=False),
)
"""Stages of an arm in space, which gravity moves away from its log: first torques hold it there.

They do so in spite of wrong values, which leads to right ones, but bring noise along. In the end valves hold it, first
roughly and then to convergence, and links may be infeasible: a limit there would look like information.
"""

TRACKING_STAGE = ContinuationStage(angle=SPATIAL_FEEDBACK_RATE, fraction=None)  # validation of an arm that diverges
TRACKING_REMARK = (
    "Without feedback this arm diverges from its log, even with the best values: errors are those of a simulation run "
    f"whose valves feed back the measured angles, at {TRACKING_STAGE.angle:g}/s."
)

FREE_STAGE = ContinuationStage(fraction=None)  # without feedback: validation of a fitted machine
MAX_CONFIGURATIONS = 200  # of a log, over which the least inertia of joints is computed


class ArmModel(Model):
    """Model of angles and pressures of every joint, from the voltages in the logs; built as `BenchKind` says.

    Logs are uniform in time at the machine's control cycle, from rest; they are used up to the first impact on a stop.
    InputError also: the machine has no valve, or no pressure sensor for the block `sensors`.
    """

    def __init__(self, machine: Machine, logs: Logs, validation: Logs | None = None, *, blocks: Sequence[str]) -> None:
        if machine.valve is None:
            right = "give a machine with a valve; or logs with torque and without voltage, of a joint moved slowly"
            raise InputError("has no valve", where=machine.origin, right=right)
        if "sensors" in blocks and machine.pressure_sensor is None:
            raise InputError("has no pressure sensor", where=machine.origin, right="leave sensors out of `blocks`")
        require_samples({**logs, **(validation or {})}, ("angle", "voltage"), list(machine.joints))
        self.machine, self.stage = machine, FREE_STAGE
        logs, remarks = cut_at_impacts(machine, logs)
        validation, validation_remarks = cut_at_impacts(machine, validation or {})
        self.remarks = (*remarks, *validation_remarks)
        described = machine_unknowns(machine, blocks)
        sought = {unknown.path for unknown in described}
        self.logs = [MachineLog(machine, name, log, bool(validation), sought) for name, log in logs.items()]
        self.logs += [MachineLog(machine, name, log, None, sought) for name, log in validation.items()]
        angles = [log.angle for log in self.logs]
        configurations = np.concatenate([q[:: len(q) // MAX_CONFIGURATIONS + 1] for q in angles])
        self.gains = OutputInjectionGains.from_machine(machine, configurations)
        # Null voltages differ from valve to valve: those after the first have an offset of their own.
        reach, later = 0.1 * machine.valve.volts_to_full, list(machine.joints)[1:]
        nulls = [Unknown(f"log.drift.{name}", "V", 0.0, -reach, reach, log=False, nuisance=True) for name in later]
        nuisances = [unknown for log in self.logs for unknown in log.nuisances]
        self.unknowns = (*described, *(nulls if "valve.centre_voltage" in sought else ()), *nuisances)
        self.outputs = tuple(output for log in self.logs for output in log.outputs)

    def continuations(self) -> Sequence[Sequence[Model]]:
        """Return continuations: stages of the same model with less and less feedback of the measured angles.

        An arm in space has one, if all logs have differential pressures; others have one per rate in `FEEDBACK_RATES`.

        A joint integrates the flow of its valve: over a whole log, a small error of a parameter becomes a large one of
        the angle, and one more of stick and slip with it. With feedback at 0.5/s errors decay in two seconds, which is
        hundreds of samples: they stay small, and the right values still leave none.
        """
        if self.machine.arm.own_links and all(log.difference is not None for log in self.logs):
            return [[self._with_stage(stage) for stage in SPATIAL_STAGES]]
        starts = [
            ContinuationStage(angle=rate, step=COARSE_STEP, fraction=BEGINNING_FRACTION) for rate in FEEDBACK_RATES
        ]
        return [[self._with_stage(stage) for stage in (first, *FINAL_STAGES)] for first in starts]

    def mirrored_values(self, values: Array) -> Array:
        """Return values with one pair of elements of losses mirrored, (pairs, unknowns): see `mirrored_losses`."""
        columns = self.columns(values)
        pairs = mirrored_losses(self.machine, columns)
        rows = [[float((columns | pair)[unknown.path]) for unknown in self.unknowns] for pair in pairs]
        return np.array(rows).reshape(-1, len(values))

    def tracking_model(self) -> Model | None:
        """Return the same model with feedback of its log, of an arm in space; otherwise None."""
        if not self.machine.arm.own_links:
            return None
        tracking = self._with_stage(TRACKING_STAGE)
        tracking.remarks = (TRACKING_REMARK,)
        return tracking

    def _with_stage(self, stage: ContinuationStage) -> Self:
        """Return a copy in a stage of the continuation, which fits only that stage's fraction of the logs."""
        other = copy(self)
        other.stage = stage
        ends = {log.name: (stage.fraction or 1.0) * log.fitted.sum() for log in self.logs}
        early = {o.log: np.arange(len(o.time)) < ends[o.log] for o in self.outputs}
        other.outputs = tuple(replace(o, fitted=o.fitted & early[o.log]) for o in self.outputs)
        vars(other).pop("used", None)
        return other

    @cached_property
    def scaling(self) -> Scaling:
        """Return the coordinates of the search: of links those in which torques are linear."""
        of_bodies = BodyScaling(self.machine, self.unknowns)
        return of_bodies if of_bodies.bodies else of_bodies.plain

    def project(self, scaled: Array, triangle: Array) -> Array:
        """Return scaled values with feasible links; see `Model.project`.

        A stage with `bodies` replaces infeasible links as `simulate` does; others use the nearest by the norm of
        `triangle`. Values of a machine whose links are not searched are returned as they are.
        """
        if not isinstance(self.scaling, BodyScaling):
            return scaled
        if not self.stage.bodies:
            scaled = self.scaling.project(scaled, self._feasible(scaled), triangle)
        return self._feasible(scaled)

    def _feasible(self, scaled: Array) -> Array:
        """Return scaled values with infeasible links replaced: see `feasible_columns`."""
        columns = feasible_columns(self.machine, self.columns(self.scaling.unscale(scaled)[None]))
        return self.scaling.scale(np.array([columns[unknown.path][0] for unknown in self.unknowns]))

    def described_values(self, values: Array) -> dict[str, float]:
        """Return the description's values (SI) by path, without nuisances; links are made feasible."""
        columns = feasible_columns(self.machine, self.columns(values[None]))
        nuisances = {unknown.path for unknown in self.unknowns if unknown.nuisance}
        return {path: float(column[0]) for path, column in columns.items() if path not in nuisances}

    def simulate(self, values: Array) -> Array:
        """Simulate all logs from their starts, with the injection of the present stage: see `Model.simulate`."""
        columns = self.columns(values)
        if self.stage.bodies:
            columns = feasible_columns(self.machine, columns)
        shared = {path: column for path, column in columns.items() if not path.startswith(("log.", "start."))}
        offset = np.asarray(shared.pop("pressure_sensor.offset", sensor_offset(self.machine)))
        shared |= {path.replace("log.", "scenario.", 1): c for path, c in columns.items() if path.startswith("log.")}
        shared["scenario.load"] = np.zeros(len(values))
        outputs = [log.simulate(shared, columns, offset, self.stage, self.gains) for log in self.logs]
        return np.concatenate(outputs, axis=1)


BENCH = BenchKind(MACHINE_BLOCKS, ("valve", "hose", "losses", "friction", "inertia"), ArmModel, even=True)
