"""List of the tubes of a machine: ends, bore, outer diameter, length and air, in agreement with `[line]`."""

import csv
import io
from typing import NamedTuple

from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.physics.line import tube_volume
from layflat.solids.documents.components import ValvePorts
from layflat.solids.tubing import SOLD_TUBES, HoseTube, choose_tube, hose_tube

SUPPLY_LENGTH, JOINT_LENGTH, SENSOR_LENGTH = 1.0, 0.5, 0.1  # of tubes that are not described, m
SILENCER_NOTE = "silencer, screwed into the port"
COLUMNS = ("number", "from", "to", "bore_mm", "outer_mm", "length_m", "volume_ml", "note")


class TubeRow(NamedTuple):
    """Tube between two ports, or what is screwed into one: then without sizes."""

    number: str
    origin: str  # component and port
    end: str
    bore: float | None = None  # m
    outer: float | None = None  # m; None: no push-in fitting takes this bore
    length: float | None = None  # m
    note: str = ""

    @property
    def volume(self) -> float | None:
        """Volume of its air, m3; None for what is no tube."""
        return None if self.bore is None or self.length is None else tube_volume(self.length, self.bore)


def list_tubes(machine: Machine) -> list[TubeRow]:
    """Return the tubes and silencers of a machine: the supply's, then each joint's from base to tip.

    Raises:
        MachineError: the machine has no valve or sensors.
    """
    valve, _, _ = valve_and_sensors(machine)
    all_valves = sum(joint.valve_size * valve.conductance for joint in machine.joints.values())
    trunk = _feed_tube(all_valves, SUPPLY_LENGTH)
    ends = (("0P1", "0V1:1"), ("0V1:2", "0Z1:1"), ("0V4:2", "0Z2"))
    rows = [TubeRow("", origin, end, *trunk) for origin, end in ends]
    rows += [TubeRow("", port, silencer, note=SILENCER_NOTE) for port, silencer in (("0V1:3", "0Z3"), ("0V3:3", "0Z4"))]
    for number, name in enumerate(machine.joints, start=1):
        rows += _joint_tubes(machine, number, name)
    return [row._replace(number=f"T{i}") for i, row in enumerate(rows, start=1)]


def _joint_tubes(machine: Machine, number: int, name: str) -> list[TubeRow]:
    """Return the tubes and silencers of a joint, without numbers."""
    (valve, _, _), joint = valve_and_sensors(machine), machine.joint[name]
    needed = joint.valve_size * valve.conductance
    feed, hose = _feed_tube(needed, JOINT_LENGTH), hose_tube(machine, name)
    outer, bore = SOLD_TUBES[0]
    signal = bore, outer, SENSOR_LENGTH, "keep it short: its air counts as the hose's"
    brake = bore, outer, JOINT_LENGTH, "cut to fit"
    ports, source = ValvePorts.of_joint(valve.kind, number), "0Z2"
    tubes: list[tuple[str, str, HoseTube]] = []
    if joint.regulator is not None:
        tubes.append((source, f"{number}V2:1", feed))
        source = f"{number}V2:2"
    tubes += [(source, inlet, feed) for inlet in ports.inlets]
    hoses = {"A1": ports.to_a, "A2": ports.to_b} if joint.acting == "double" else {"A1": ports.to_a}
    for actuator, (outlet, *others) in hoses.items():
        tubes.append((outlet, f"{number}{actuator}", hose))
        tubes += [(outlet, other, (*hose[:2], SENSOR_LENGTH, "keep it short")) for other in others]
    tubes += [(f"{number}{actuator}", f"{number}S1:{'+-'[i]}", signal) for i, actuator in enumerate(hoses)]
    if joint.brake.calliper is not None:
        tubes += [("0Z2", f"{number}V3:1", brake), (f"{number}V3:2", f"{number}A3", brake)]
    plugged = ports.to_b if joint.acting == "single" else ()
    return [
        *(TubeRow("", origin, end, *tube) for origin, end, tube in tubes),
        *(TubeRow("", port, "plug", note="plugged: the joint has a single hose") for port in plugged),
        *(TubeRow("", port, f"{number}Z{i}", note=SILENCER_NOTE) for i, port in enumerate(ports.exhausts, start=1)),
    ]


def _feed_tube(needed: float, length: float) -> HoseTube:
    """Return the tube that feeds valves of a conductance (m3/(s Pa)) over a length (m)."""
    bore, outer, enough = choose_tube(needed, length)
    return (
        bore,
        outer,
        length,
        "cut to fit" if enough else "cut to fit; no tube that is sold is wide enough: use several",
    )


def tubes_csv(machine: Machine) -> str:
    """Return the list of tubes as CSV; errors as from `list_tubes`."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in list_tubes(machine):
        sizes = ((row.bore, 1e3), (row.outer, 1e3), (row.length, 1.0), (row.volume, 1e6))
        cells = ["" if value is None else f"{scale * value:.4g}" for value, scale in sizes]
        writer.writerow((row.number, row.origin, row.end, *cells, row.note))
    return text.getvalue()
