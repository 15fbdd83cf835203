"""Tubes that are sold, and the one that a joint's hoses take.

A described line has its length and bore. Bores of others follow a rule: the narrowest tube that is sold whose
conductance, over its length, is `CONDUCTANCE_MARGIN` times that of the valves it feeds, or else the widest. Without a
line the described dead volume of a hose includes its tube, which may take up to `TUBE_SHARE` of it.
"""

from math import pi

from layflat.machine import Machine
from layflat.physics.line import tube_conductance
from layflat.solids.standard.fittings import TUBE_SIZES

CONDUCTANCE_MARGIN = 2.0  # of a tube over the valves that it feeds
TUBE_SHARE = 0.5  # of a hose's dead volume that its tube may take
BORE_TOLERANCE = 0.1  # relative difference up to which a tube that is sold has a described bore
SOLD_TUBES = sorted({size for sizes in TUBE_SIZES.values() for size in sizes})
"""Outer and inner diameter of the tubes that push-in fittings take, m, the narrowest first."""

HoseTube = tuple[float, float | None, float, str]
"""Bore, outer diameter (m; None: not sold), length (m) and note of a tube."""


def hose_tube(machine: Machine, name: str) -> HoseTube:
    """Return the tube from the valve of a joint to each of its hoses; of a machine without valves the narrowest."""
    joint, line, valve = machine.joint[name], machine.lines[name], machine.valve
    needed = 0.0 if valve is None else joint.valve_size * valve.conductance
    if line is None:
        room = TUBE_SHARE * joint.hose.dead_volume
        bore, outer, enough = choose_tube(needed, None, room)
        note = f"at most this long: without [line] the dead volume, {1e6 * joint.hose.dead_volume:.3g} ml, includes it"
        throttles = "" if enough else "; it throttles the valve: describe [line]"
        return bore, outer, room / (0.25 * pi * bore**2), note + throttles
    outer, inner = min(SOLD_TUBES, key=lambda size: abs(size[1] - line.bore))
    if abs(inner - line.bore) > BORE_TOLERANCE * line.bore:
        return line.bore, None, line.length, "as [line]; no push-in tube has this bore: use hose nozzles"
    note = "as [line]" if inner == line.bore else f"as [line]; the tube that is sold has a bore of {1e3 * inner:g} mm"
    return line.bore, outer, line.length, note


def choose_tube(needed: float, length: float | None, room: float = 0.0) -> tuple[float, float, bool]:
    """Return bore and outer diameter, m, of the narrowest tube that feeds valves with a margin; else of the widest.

    Args:
        needed: conductance of the valves, m3/(s Pa).
        length: of the tube, m; None: the length with which its air fills `room`.
        room: volume, m3.

    Returns:
        Bore, outer diameter, and whether the tube has the margin.
    """
    for outer, bore in SOLD_TUBES:
        through = tube_conductance(length or room / (0.25 * pi * bore**2), bore)
        if through >= CONDUCTANCE_MARGIN * needed:
            return bore, outer, True
    return bore, outer, False
