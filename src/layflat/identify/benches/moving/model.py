"""A machine that moves: from the voltages of its valves to pressures and angles."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.identify.benches.contract import Bench, Logs, require_samples
from layflat.identify.benches.moving.blocks import BLOCKS, mirrored_losses, unknowns
from layflat.identify.benches.moving.bodies import BodyShares
from layflat.identify.benches.moving.leading import Leads, Stage
from layflat.identify.benches.moving.log import Record, sensor_offset, up_to_impacts
from layflat.identify.benches.moving.spread import possible
from layflat.identify.model import Model
from layflat.identify.unknown import Shares, Unknown
from layflat.machine import Machine
from layflat.physics.step import COARSE

FEEDBACKS, BEGINNING = (4.0, 8.0, 12.0), 0.35
"""First the beginning of the logs with strong feedback: which rate finds its way depends on where the search begins."""

STAGES = (Stage(angle=2.0), Stage(angle=0.5))
"""Then as exactly as a run is simulated, with weak feedback in the end.

Feedback brings the angle's noise along, which widens errors more than a free run's roughness does: the less the better.
"""

FALLING = 2.0  # rate at which valves draw an arm in space at least, 1/s: gravity takes some along in half a second
HELD = (
    Stage(air=20.0, torque=40.0, step=COARSE, share=BEGINNING), Stage(air=1.0, torque=25.0),
    Stage(angle=FALLING, bodies=False), Stage(angle=FALLING, bodies=False),
)  # fmt: skip
"""The same of an arm in space, which gravity takes along once it is off its way: first torques hold it to its log.

They do so in spite of wrong values, which is the way to right ones, but bring noise along. In the end valves draw it,
first roughly and then to the end, and links may be what no body can be: a limit there would pass for knowledge.
"""

LED = Stage(angle=FALLING, share=None)  # how an arm in space is validated that runs away when it is free
LED_SAYS = (
    "Left to itself this arm runs away from its log, even with the best values: errors are those of a run whose angles "
    f"are drawn to the measured ones by its valves, at {LED.angle:g}/s."
)

FREE = Stage(share=None)  # without feedback: how a fitted machine is validated
POSTURES = 200  # of a log at most, by which it is seen what inertia joints feel


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
        logs, said = up_to_impacts(machine, logs)
        validation, said_of_others = up_to_impacts(machine, validation or {})
        self.remarks = (*said, *said_of_others)
        found = unknowns(machine, blocks)
        known = {unknown.path for unknown in found}
        self.records = [Record(machine, name, log, bool(validation), known) for name, log in logs.items()]
        self.records += [Record(machine, name, log, None, known) for name, log in validation.items()]
        angles = [record.angle for record in self.records]
        self.leads = Leads.of(machine, np.concatenate([q[:: len(q) // POSTURES + 1] for q in angles]))
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
        if self.machine.arm.own_links and all(record.difference is not None for record in self.records):
            return [[self._at(stage) for stage in HELD]]
        begun = [Stage(angle=rate, step=COARSE, share=BEGINNING) for rate in FEEDBACKS]
        return [[self._at(stage) for stage in (first, *STAGES)] for first in begun]

    def mirrored(self, values: Array) -> Array:
        """Return values with other ones of two elements of a joint's losses that act nearly the same."""
        columns = self.columns(values)
        pairs = mirrored_losses(self.machine, columns)
        rows = [[float((columns | pair)[unknown.path]) for unknown in self.unknowns] for pair in pairs]
        return np.array(rows).reshape(-1, len(values))

    def led(self) -> Model | None:
        """The same drawn to its log, of an arm in space."""
        if not self.machine.arm.own_links:
            return None
        found = self._at(LED)
        found.remarks = (LED_SAYS,)
        return found

    def _at(self, stage: Stage) -> Self:
        easier = copy(self)
        easier.stage = stage
        ends = {record.name: (stage.share or 1.0) * record.fitted.sum() for record in self.records}
        early = {o.log: np.arange(len(o.time)) < ends[o.log] for o in self.outputs}
        easier.outputs = tuple(replace(o, fitted=o.fitted & early[o.log]) for o in self.outputs)
        vars(easier).pop("used", None)
        return easier

    @cached_property
    def shares(self) -> Shares:
        """In what the search goes: of links in that of which torques are linear."""
        found = BodyShares(self.machine, self.unknowns)
        return found if found.bodies else found.own

    def settled(self, shares: Array, triangle: Array) -> Array:
        """Shares of links that can be bodies: those that were simulated, or the nearest where any were."""
        if not isinstance(self.shares, BodyShares):
            return shares
        if not self.stage.bodies:
            shares = self.shares.nearest(shares, self._bodies(shares), triangle)
        return self._bodies(shares)

    def _bodies(self, shares: Array) -> Array:
        columns = possible(self.machine, self.columns(self.shares.values(shares)[None]))
        return self.shares.of(np.array([columns[unknown.path][0] for unknown in self.unknowns]))

    def written(self, values: Array) -> dict[str, float]:
        """Return the description's values by path from those of the unknowns (SI); links can be bodies."""
        found = possible(self.machine, self.columns(values[None]))
        nuisances = {unknown.path for unknown in self.unknowns if unknown.nuisance}
        return {path: float(column[0]) for path, column in found.items() if path not in nuisances}

    def simulate(self, values: Array) -> Array:
        """All logs from their starts, whatever the candidates' values say."""
        given = self.columns(values)
        if self.stage.bodies:
            given = possible(self.machine, given)
        shared = {path: column for path, column in given.items() if not path.startswith(("log.", "start."))}
        offset = np.asarray(shared.pop("pressure_sensor.offset", sensor_offset(self.machine)))
        shared |= {path.replace("log.", "scenario.", 1): c for path, c in given.items() if path.startswith("log.")}
        shared["scenario.load"] = np.zeros(len(values))
        found = [record.simulate(shared, given, offset, self.stage, self.leads) for record in self.records]
        return np.concatenate(found, axis=1)


BENCH = Bench(BLOCKS, ("valve", "hose", "losses", "friction", "inertia"), ArmModel, even=True)
