"""The line that tells what a rig does."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.text import Text

    from layflat.rig.recorded import Recorded
    from layflat.rig.session import Snapshot


def status(rig: Recorded) -> Text:
    """State, fault, angles against demands, pressures and lateness; shown ten times a second."""
    from rich.text import Text  # noqa: PLC0415

    try:
        shot = rig.session.snapshot()
    except ValueError:  # the memory was closed meanwhile
        shot = None
    text = "waiting for the loop" if shot is None else line_of(shot, list(rig.machine.joints))
    style = "bold red" if shot is not None and shot.fault else ""
    return Text(text if rig.recording else f"NOT RECORDED  {text}", style=style)


def line_of(shot: Snapshot, joints: list[str]) -> str:
    """A snapshot in a line that fits a terminal."""
    from layflat.rig.plan import fault_text  # noqa: PLC0415

    state = shot.state.name.lower()
    parts = [f"{state:8s}", f"{float(shot['time']):6.1f} s"]
    angles, demands = shot["averaged_angle"], shot["demand"]
    pressures = shot["averaged_pressure"]
    for name, angle, demand, pressure in zip(joints, angles, demands, pressures, strict=True):  # type: ignore[arg-type]
        parts.append(f"{name} {57.29578 * angle:.1f}/{57.29578 * demand:.1f} deg {pressure / 1e5:+.1f} bar")
    parts += [f"supply {float(shot['supply']) / 1e5:.1f} bar", f"late {1e6 * float(shot['lateness']):.0f} us"]
    if shot.fault:
        parts.insert(1, f"FAULT {fault_text(shot, joints)}")
    return "  ".join(parts)
