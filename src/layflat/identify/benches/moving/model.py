"""A machine that moves: from the voltages of its valves to pressures and angles."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import NamedTuple, Self

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.identify.benches.contract import Bench, Logs, require_samples
from layflat.identify.benches.moving.blocks import BLOCKS, unknowns
from layflat.identify.benches.moving.links import possible
from layflat.identify.benches.moving.log import Record, sensor_offset
from layflat.identify.model import Model, Unknown
from layflat.machine import Machine, parameters
from layflat.physics.joint import FILLED
from layflat.physics.step import COARSE, STEP

REFERENCE_PRESSURE = 1e5  # of the air that a sonic conductance is given for, Pa (ISO 6358)


class Stage(NamedTuple):
    """A stage of the continuation."""

    feedback: float  # rate at which the simulated angle is drawn to the measured one, 1/s (output injection)
    step: float  # of the simulation, s
    share: float = 1.0  # of what is fitted, from the start of each log on


FEEDBACKS, BEGINNING = (4.0, 8.0, 12.0), 0.35
"""First the beginning of the logs with strong feedback: which rate finds its way depends on where the search begins."""

STAGES = (Stage(2.0, STEP), Stage(0.5, STEP))
"""Then as exactly as a run is simulated, with weak feedback in the end.

Feedback brings the angle's noise along, which widens errors more than a free run's roughness does: the less the better.
"""

FREE = Stage(0.0, STEP)  # without feedback: how a fitted machine is validated


class ArmModel(Model):
    """Angles and pressures of every joint, from the voltages in the logs; made as `Bench` says.

    Logs are uniform in time at the machine's control cycle, from rest.
    """

    def __init__(self, machine: Machine, logs: Logs, validation: Logs | None = None, *, blocks: Sequence[str]) -> None:
        if machine.valve is None:
            right = "give a machine with a valve; or logs with torque and without voltage, of a joint moved slowly"
            raise InputError("has no valve", where=machine.origin, right=right)
        if "sensors" in blocks and machine.pressure_sensor is None:
            raise InputError("has no pressure sensor", where=machine.origin, right="leave sensors out of --fit")
        require_samples({**logs, **(validation or {})}, ("angle", "voltage"), list(machine.joints))
        self.machine, self.stage = machine, FREE
        flow = machine.valve.conductance * REFERENCE_PRESSURE / FILLED  # of a valve of size 1
        # Voltage per error of the angle that makes each joint follow at 1/s, V/rad.
        self.feedback_gains = {
            name: machine.valve.volts_to_full * parameters.torque_constant(joint) / (flow * joint.valve_size)
            for name, joint in machine.joints.items()
        }
        found = unknowns(machine, blocks)
        known = {unknown.path for unknown in found}
        self.records = [Record(machine, name, log, bool(validation), known) for name, log in logs.items()]
        self.records += [Record(machine, name, log, None, known) for name, log in (validation or {}).items()]
        # A valve's null differs from joint to joint: what those after the first have on top.
        reach, later = 0.1 * machine.valve.volts_to_full, list(machine.joints)[1:]
        nulls = [Unknown(f"log.drift.{name}", "V", 0.0, -reach, reach, log=False, nuisance=True) for name in later]
        nuisances = [unknown for record in self.records for unknown in record.nuisances]
        self.unknowns = (*found, *(nulls if "valve.centre_voltage" in known else ()), *nuisances)
        self.outputs = tuple(output for record in self.records for output in record.outputs)

    def continuations(self) -> Sequence[Sequence[Model]]:
        """The same with feedback of the measured angles, less and less; each way begins with more of it.

        A joint integrates what its valve lets through: over a whole log, a small error of a parameter becomes a large
        one of the angle, and one more of stick and slip with it. With feedback at 0.5/s it forgets in two seconds,
        which is hundreds of samples: errors stay small, and the right values still leave none.
        """
        return [[self._at(stage) for stage in (Stage(rate, COARSE, BEGINNING), *STAGES)] for rate in FEEDBACKS]

    def _at(self, stage: Stage) -> Self:
        easier = copy(self)
        easier.stage = stage
        ends = {record.name: stage.share * record.fitted.sum() for record in self.records}
        early = {o.log: np.arange(len(o.time)) < ends[o.log] for o in self.outputs}
        easier.outputs = tuple(replace(o, fitted=o.fitted & early[o.log]) for o in self.outputs)
        vars(easier).pop("used", None)
        return easier

    def possible(self, values: Array) -> Array:
        """Candidates whose links can be bodies."""
        columns = possible(self.machine, self.columns(values))
        return np.stack([columns[unknown.path] for unknown in self.unknowns], axis=-1)

    def written(self, values: Array) -> dict[str, float]:
        """What values of the unknowns (SI) make of the description, by its paths; links can be bodies."""
        found = possible(self.machine, self.columns(values[None]))
        nuisances = {unknown.path for unknown in self.unknowns if unknown.nuisance}
        return {path: float(column[0]) for path, column in found.items() if path not in nuisances}

    def simulate(self, values: Array) -> Array:
        """All logs from their starts, whatever the candidates' values say."""
        given, rate = possible(self.machine, self.columns(values)), self.stage.feedback
        shared = {path: column for path, column in given.items() if not path.startswith(("log.", "start."))}
        offset = np.asarray(shared.pop("pressure_sensor.offset", sensor_offset(self.machine)))
        shared |= {f"scenario.lead.{name}": np.full(len(values), rate * v) for name, v in self.feedback_gains.items()}
        shared |= {path.replace("log.", "scenario.", 1): c for path, c in given.items() if path.startswith("log.")}
        shared["scenario.load"] = np.zeros(len(values))
        share = None if self.stage is FREE else self.stage.share
        found = [record.simulate(shared, given, offset, self.stage.step, share) for record in self.records]
        return np.concatenate(found, axis=1)


BENCH = Bench(BLOCKS, ("valve", "hose", "losses", "friction", "inertia"), ArmModel, even=True)
