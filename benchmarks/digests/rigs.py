"""A rig's loop with the simulated driver, in virtual time: the rows that it records."""

from __future__ import annotations

from math import nan
from typing import Any

import numpy as np

from benchmarks.digests.runs import Arrays

SHARED = {
    **{name: name for name in ("time", "elapsed", "supply", "air", "stopped", "mode", "fault", "lost")},
    "far": "device",
}
BY_JOINT = {
    name: name
    for name in (
        "demand", "voltage", "measured_angle", "measured_pressure", "averaged_angle", "averaged_velocity",
        "averaged_pressure", "ripple", "phase", "short_term", "long_term", "learning", "joint_fault",
    )
}  # fmt: skip
"""Our name of a number in a row: its name in the code."""

FAULTS = ("angle-frozen", "burst-hose", "e-stop", "reply-lost", "silence", "stuck-spool", "supply-lost")


class PlannedHost:
    """Asks for what it is told, and keeps the rows."""

    def __init__(self, joints: int) -> None:
        self.demands, self.edges, self.ended = [nan] * joints, dict[str, Any](), False
        self.rows: list[Any] = []

    def request(self, _now: int) -> Any:
        """Return the host's request in this cycle."""
        from layflat.rig.safety.supervisor import HostRequest  # noqa: PLC0415

        edges, self.edges = self.edges, {}
        return HostRequest(list(self.demands), **edges)

    def publish(self, row: Any) -> None:
        """Keep a row."""
        self.rows.append(row.copy())


def played(machine_name: str, plan: dict[int, Any], cycles: int, *, filled: bool) -> Arrays:
    """The rows of a loop, by name; `plan` has what is done to host and device before a cycle."""
    from layflat import load  # noqa: PLC0415
    from layflat.rig.clock import NS_PER_SECOND, VirtualClock  # noqa: PLC0415
    from layflat.rig.device.virtual import SimulatedDriver  # noqa: PLC0415
    from layflat.rig.loop import RigLoop  # noqa: PLC0415
    from layflat.virtual_rig import VirtualRig  # noqa: PLC0415

    machine = load(machine_name)
    clock, host = VirtualClock(3 * NS_PER_SECOND), PlannedHost(len(machine.joints))
    device = VirtualRig(machine, seed=5, filled=filled)(clock)
    driver: Any = SimulatedDriver(device)
    driver.configure()
    driver.activate()
    loop: Any = RigLoop(machine, driver, clock, host)
    if filled:
        loop.start_filled(driver.read())
    for k in range(cycles):
        plan.get(k, lambda *_: None)(host, device)
        loop.cycle()
    rows, layout = np.array(host.rows), loop.layout
    found = {ours: rows[:, layout.shared[name]] for ours, name in SHARED.items()}
    for ours, name in BY_JOINT.items():
        found[ours] = layout.joint_rows(rows)[:, :, layout.columns[name]]
    return found


def asks(*demands: float, **edges: bool) -> Any:
    """The host asks for angles."""

    def do(host: PlannedHost, _device: Any) -> None:
        host.demands, host.edges = list(demands), edges

    return do


def fails(name: str) -> Any:
    """The virtual rig fails in its last joint."""

    def do(host: PlannedHost, device: Any) -> None:
        from layflat.rig.device.failures import get_failure  # noqa: PLC0415

        get_failure(name).inject(device, len(host.demands) - 1)

    return do


def mends(name: str, **edges: bool) -> Any:
    """Return an action that mends a failure."""

    def do(host: PlannedHost, device: Any) -> None:
        from layflat.rig.device.failures import get_failure  # noqa: PLC0415

        get_failure(name).heal(device, len(host.demands) - 1)
        host.edges = edges

    return do


def healthy() -> Arrays:
    """Moves with air from the start, and all of it from switching on to venting the air."""
    moves = {20: asks(0.3, -0.2), 200: asks(-0.1, 0.25)}
    runs = {
        "moves": played("paper-arm", moves, 400, filled=True),
        "switching valves": played("paper-small-joint-switching", {20: asks(0.3)}, 200, filled=True),
        "from off to off": played(
            "paper-arm",
            {5: asks(nan, nan, reset=True), 40: asks(nan, nan, start=True), 900: asks(0.2, 0.1),
             1100: asks(0.2, 0.1, stop=True)},
            1500, filled=False,
        ),
    }  # fmt: skip
    return {f"{run}: {name}": values for run, found in runs.items() for name, values in found.items()}


def faulty() -> Arrays:
    """Moves in which something fails, is mended, and is reset."""
    found: Arrays = {}
    for name in FAULTS:
        plan = {20: asks(0.0, -0.5), 60: fails(name), 200: mends(name), 300: asks(0.0, -0.5, reset=True),
                340: asks(0.0, 0.1, start=True)}  # fmt: skip
        found |= {f"{name}: {key}": values for key, values in played("paper-arm", plan, 500, filled=True).items()}
    return found
