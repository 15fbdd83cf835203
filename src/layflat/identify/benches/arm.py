"""A machine that moves: from the voltages of its valves to pressures and angles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray

from layflat.identify.benches.arm_blocks import unknowns
from layflat.identify.benches.arm_log import Record, sensor_offset
from layflat.identify.model import Array, Model
from layflat.identify.unknown import Unknown
from layflat.machine import Machine, parameters
from layflat.physics.joint import FILLED
from layflat.physics.step import STEP

REFERENCE_PRESSURE = 1e5
"""Of the air that a sonic conductance is given for, Pa (ISO 6358)."""


class Rung(NamedTuple):
    """How values are sought: the rate at which joints are led (1/s), step (s), and share of what is fitted."""

    led: float
    step: float
    share: float = 1.0


LEADS, BEGINNING, COARSE = (4.0, 8.0, 12.0), 0.35, 2.0 * STEP
"""From afar by the beginning of the logs, led strongly: which rate finds its way depends on where the search begins."""

LADDER = (Rung(2.0, STEP), Rung(0.5, STEP))
"""Then as exactly as a run is simulated, and led weakly in the end.

What leads brings its noise along, which widens errors more than a free run's roughness does: the less the better.
"""


FREE = Rung(0.0, STEP)
"""Led by nothing: how a fitted machine is judged."""


class ArmModel(Model):
    """Angles and pressures of every joint, from the voltages in the logs.

    Args:
        machine: where the search begins, and what is held.
        logs: to fit, by name: uniform in time at the machine's control cycle, from rest.
        blocks: what to fit, of `BLOCKS`.
        judged: logs that are only predicted; without any, the last third of each log is.

    Raises:
        InputError: a log lacks what is needed, or a block is unknown.
    """

    def __init__(
        self,
        machine: Machine,
        logs: Mapping[str, xarray.Dataset],
        blocks: Sequence[str],
        judged: Mapping[str, xarray.Dataset] | None = None,
    ) -> None:
        self.machine, self.rung = machine, FREE
        found = unknowns(machine, blocks)
        known = {unknown.path for unknown in found}
        self.records = [Record(machine, name, log, bool(judged), known) for name, log in logs.items()]
        self.records += [Record(machine, name, log, None, known) for name, log in (judged or {}).items()]
        nuisances = [unknown for record in self.records for unknown in record.nuisances]
        self.unknowns = (*found, *_nulls(machine, known), *nuisances)
        self.outputs = tuple(output for record in self.records for output in record.outputs)

    def ladder(self) -> Sequence[Model]:
        """The same, led along the measured angles, less and less.

        A joint integrates what its valve lets through: over a whole log, a small error of a parameter becomes a large
        one of the angle, and one more of stick and slip with it. Led at 0.5/s it forgets in two seconds, which is
        hundreds of samples: errors stay small, and the right values still leave none.
        """
        return self.ladders()[0]

    def ladders(self) -> Sequence[Sequence[Model]]:
        """Ladders that begin led more or less strongly."""
        return [[self._on(rung) for rung in (Rung(led, COARSE, BEGINNING), *LADDER)] for led in LEADS]

    def _on(self, rung: Rung) -> ArmModel:
        easier = copy(self)
        easier.rung = rung
        ends = {record.name: rung.share * record.fitted.sum() for record in self.records}
        early = {o.log: np.arange(len(o.time)) < ends[o.log] for o in self.outputs}
        easier.outputs = tuple(replace(o, fitted=o.fitted & early[o.log]) for o in self.outputs)
        vars(easier).pop("used", None)
        return easier

    @cached_property
    def _leads(self) -> dict[str, float]:
        """Voltage per error of the angle by which each joint is drawn along at 1/s, V/rad."""
        valve = self.machine.valve
        if valve is None:
            return {}
        flow = valve.conductance * REFERENCE_PRESSURE / FILLED
        joints = self.machine.joints.items()
        return {name: valve.volts_to_full * parameters.torque_constant(joint) / flow for name, joint in joints}

    def simulate(self, values: Array) -> Array:
        """All logs from their starts, whatever the candidates' values say."""
        given = {unknown.path: values[:, i] for i, unknown in enumerate(self.unknowns)}
        offset = given.get("pressure_sensor.offset", sensor_offset(self.machine))
        shared = {path: column for path, column in given.items() if not path.startswith(("log.", "start."))}
        shared |= {f"scenario.lead.{name}": np.full(len(values), self.rung.led * v) for name, v in self._leads.items()}
        shared |= {path.replace("log.", "scenario.", 1): c for path, c in given.items() if path.startswith("log.")}
        asked = len(values), self.rung.step, None if self.rung is FREE else self.rung.share
        found = [record.simulate(shared, given, np.asarray(offset), *asked) for record in self.records]
        return np.concatenate(found, axis=1)


def _nulls(machine: Machine, known: set[str]) -> list[Unknown]:
    """A valve's null differs from joint to joint: what those after the first have on top."""
    if "valve.centre_voltage" not in known or machine.valve is None:
        return []
    reach = 0.1 * machine.valve.volts_to_full
    later = list(machine.joints)[1:]
    return [Unknown(f"log.drift.{name}", "V", 0.0, -reach, reach, log=False, nuisance=True) for name in later]
