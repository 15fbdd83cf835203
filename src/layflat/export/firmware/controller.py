"""Settings of a machine's device that runs the control law itself, as the sources that `device/controller.h` needs."""

from collections.abc import Iterator

from layflat.errors import InputError
from layflat.export.firmware.station import station_settings
from layflat.export.numbers import c_number
from layflat.machine import Machine
from layflat.rig.law import ArmLaw
from layflat.rig.safety.cycle_numbers import RECORDED_WIDTH
from layflat.rig.safety.requests import settings_digest
from layflat.rig.wire import Converter, Wire

MAX_SIGNALS = 59  # numbers of a joint that a frame carries
REAL_BY_PRECISION = {"double": "double", "single": "float"}


def controller_sources(machine: Machine, precision: str) -> Iterator[tuple[str, str]]:
    """Yield name and content of the header and the source with the settings of a machine's device.

    Args:
        machine: the machine.
        precision: "double" or "single", of the supervisor's numbers.

    Raises:
        MachineError: the machine has no valve, sensors or controller, or does not fit the wire.
        InputError: the control law reports more signals than a frame carries.
    """
    recorded = ArmLaw(machine).recorded.tolist()
    if RECORDED_WIDTH + len(recorded) > MAX_SIGNALS:
        what = f"its control law reports {len(recorded)} signals of a joint"
        raise InputError(what, where=machine.origin, right=f"report up to {MAX_SIGNALS - RECORDED_WIDTH}")
    lines = [
        "/* Machine of this device. */", "#ifndef MACHINE_H", "#define MACHINE_H", "", '#include "rig.h"', "",
        f"typedef {REAL_BY_PRECISION[precision]} rig_real;",
        f"#define MACHINE_SIGNALS {RECORDED_WIDTH}u /* of a joint under any control law */",
        f"#define MACHINE_RECORDED {len(recorded)}u /* of the control law */", "", "#endif", "",
    ]  # fmt: skip
    yield "machine.h", "\n".join(lines)
    yield "machine.c", station_settings(machine) + _controller_settings(machine, recorded)


def _controller_settings(machine: Machine, recorded: list[int]) -> str:
    """Return the definition of the settings."""
    wire = Wire.for_machine(machine)
    fields = {
        "station": "&machine_station",
        "supervisor": "&rig_default_supervisor_settings",
        "memory": "&rig_default_supervisor_memory",
        **{name: _converter(getattr(wire, name)) for name in ("voltage", "angle", "pressure", "supply")},
        "cycle": f"{round(1e6 * machine.cycle)}u",
        "digest": f"0x{settings_digest(machine):08X}u",
        "recorded": f"{{{', '.join(map(str, [*recorded, 0]))}}}",
    }
    lines = [f"    .{name} = {value}," for name, value in fields.items()]
    head = ["", '#include "controller.h"', "", "extern const controller_settings machine_controller;"]
    return "\n".join([*head, "const controller_settings machine_controller = {", *lines, "};", ""])


def _converter(converter: Converter) -> str:
    return f"{{{c_number(converter.low, 'double')}, {c_number(converter.lsb, 'double')}, {converter.top}u}}"
