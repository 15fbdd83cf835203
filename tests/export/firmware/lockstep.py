"""A device that runs the law, in lock-step with a loop: its numbers are the loop's, its drives those of a station."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from layflat.export.firmware.station import CYCLES_PER_DITHER
from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.rig import frames
from layflat.rig.abilities import falls_without_air
from layflat.rig.device.virtual import LINE_EMPTY_TIME
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.safety.remote import RemoteSupervisor
from layflat.rig.safety.requests import DeviceRequest, DeviceStatus, RequestWire
from layflat.rig.safety.supervisor import HostRequest
from layflat.rig.wire import Identity, Wire
from tests.export.firmware.c_devices import Bench
from tests.export.firmware.controllers import CController
from tests.export.firmware.loop_cycles import Cycle, counts_of, request_frame
from tests.rig.firmwares import firmware


def python_station(machine: Machine, bench: Bench) -> Any:
    """Return the device in Python that obeys voltages, on a bench."""
    one, (valve, _, _) = Identity.for_machine(machine), valve_and_sensors(machine)
    settings = SimpleNamespace(
        JOINTS=one.joints, VOLTAGE_BITS=one.voltage_bits, ANGLE_BITS=one.angle_bits, PRESSURE_BITS=one.pressure_bits,
        SUPPLY_BITS=one.supply_bits, VOLTAGE_LOW=one.voltage_low, VOLTAGE_HIGH=one.voltage_high,
        CENTRE_VOLTAGE=one.centre_voltage, CENTRES_AFTER=1000 * one.centres_after, DUMPS_AFTER=1000 * one.dumps_after,
        EMPTIES_AFTER=LINE_EMPTY_TIME // 1000, LETS_DOWN=falls_without_air(machine), SHORTEST_CYCLE=one.shortest_cycle,
        DITHER_AMPLITUDE=valve.dithered.amplitude if valve.dithered is not None else 0.0,
        DITHER_PERIOD=round(1e6 * CYCLES_PER_DITHER * machine.cycle), OUTPUT_PINS=machine.interface.outputs,
    )  # fmt: skip
    return firmware("station").Station(bench, settings)


class Mirror:
    """Host's end: what the remote supervisor makes of the statuses."""

    def __init__(self, machine: Machine) -> None:
        self.supervisor = RemoteSupervisor(machine, self)
        self.status: DeviceStatus | None = None
        self.events: list[str] = []

    def request(self, request: DeviceRequest) -> None: ...

    def take(self, status: DeviceStatus) -> None:
        self.status = status
        self.supervisor.cycle(status.reading, HostRequest([]), 0.0, 0.0)
        self.events += self.supervisor.ledger.events
        self.supervisor.ledger.events.clear()


class LockStep:
    """Device in C that lives through the cycles of a loop; beside it the device in Python that gets its voltages."""

    def __init__(self, machine: Machine, library: Any) -> None:
        n = len(machine.joints)
        self.device, self.mirror = CController(library, n), Mirror(machine)
        self.wire, self.requests = Wire.for_machine(machine), RequestWire.for_machine(machine)
        self.bench = Bench(n)
        self.station = python_station(machine, self.bench)
        self.before: Cycle | None = None
        plans = machine.control_law.plans
        unused = [] if plans else [16 + 5 * j + i for j in range(n) for i in (3, 4)]
        self.inputs = np.delete(np.arange(16 + 5 * n), unused)
        self._number = 0
        self.faults: set[Fault] = set()
        self.states: set[RigState] = set()

    def cycle(self, cycle: Cycle) -> None:
        """Live through a cycle, and compare all numbers with the loop's, and the drives with those of the station."""
        device, bench = self.device, self.bench
        self._number += 1
        for one in (device.bench, bench):
            one.time, one.open, one.counts = cycle.time, cycle.reading.stopped, counts_of(self.wire, cycle.reading)
        sent = device.answers_to(request_frame(self.requests, self._number, cycle.request))
        np.testing.assert_array_equal(device.numbers("inputs")[self.inputs], self.cleared(cycle.inputs)[self.inputs])
        np.testing.assert_array_equal(device.numbers("memory", "results"), cycle.after)
        command = frames.pack_words(self.wire.command_words(cycle.command))
        bench.bytes = frames.encode(frames.COMMAND_FRAME, self._number & 0xFFFF, command)
        self.station.step()
        driven = device.bench.driven, device.bench.on, device.bench.switched
        assert driven == (bench.driven, bool(bench.on), bench.switched)
        if self.before is not None:
            self.compare_status(self.requests.status([frame.payload for frame in sent]), self.before)
        else:
            assert sent == []
        self.before = cycle

    def cleared(self, inputs: Any) -> Any:
        """Return inputs as they are after a cycle, without edges."""
        after = inputs.copy()
        after[[6, 7, 8, 9, 12, 13]] = 0.0
        return after

    def compare_status(self, status: DeviceStatus, cycle: Cycle) -> None:
        """Compare what the host shows with the row of the loop's cycle."""
        self.mirror.take(status)
        rows, shown = np.zeros_like(cycle.rows), self.mirror.supervisor
        shown.record(rows)
        exact = cycle.rows.copy()
        exact[:, [*range(3), *range(5, exact.shape[1] - 1)]] = exact[
            :, [*range(3), *range(5, exact.shape[1] - 1)]
        ].astype(np.float32)
        np.testing.assert_array_equal(rows, exact)
        assert status.reading.supply == cycle.reading.supply
        assert (status.reading.stopped, status.reading.device) == (cycle.reading.stopped, cycle.reading.device)
        self.states.add(shown.state)
        self.faults.add(shown.fault)
