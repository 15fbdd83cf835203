"""The description of a sized joint: only what differs from the model machine, each value with its provenance.

Similarity: filling takes as long if the valve's conductance grows with the hose's volume, and a joint is as quick if
inertia grows with torque. Then the controller's gains are the model's. With another inertia per torque the natural
frequency, and with it the gains, go as sqrt(T/J).
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import ceil, degrees, sqrt
from typing import Any

from layflat.machine import Joint, Machine
from layflat.machine.parameters import torque_constant, travel_volume
from layflat.machine.parts import JointGains

Tables = dict[str, Any]

BRAKE_SHARE = 0.08
"""Brake over maximum torque. Source: section 4.2."""

OVERSHOOT_ROOM = 20.0
"""Mechanical beyond working stroke, deg. Source: section 2.3."""

HEIGHT_PER_WIDTH = 1.6
"""Height of a joint over the width of its hose: 1.64 and 1.56 in the paper."""


@dataclass(frozen=True)
class SizedJoint:
    """What sizing settled, in SI.

    Args:
        joint: the model's joint with its new sizes.
        torque_constant: K, m3/rad.
        swept_volume: of one hose, m3.
        mass: of the whole joint, kg.
        torque: that was asked for, N m.
        stroke: working stroke, rad.
        supply: gauge supply pressure, Pa.
        payload_inertia: about the joint, kg m2.
    """

    joint: Joint
    torque_constant: float
    swept_volume: float
    mass: float
    torque: float
    stroke: float
    supply: float
    payload_inertia: float


@dataclass(frozen=True)
class _Ratios:
    """Of the sized joint to the model's: torque, volume, length, and quickness sqrt(T/J)."""

    torque: float
    volume: float
    length: float
    quickness: float


def description(sized: SizedJoint, model: Machine, extends: str, name: str) -> Tables:
    """Nested tables of a machine with the sized joint; leaves are tables of value, source and note."""
    joint_name, base = next(iter(model.joints.items()))
    link = base.link
    ratios = _ratios(sized, model, base)
    payload = sized.payload_inertia / link.length**2
    tables: Tables = {
        "extends": extends,
        "name": name,
        "title": f"Sized for {sized.torque:.4g} N m, {degrees(sized.stroke):.4g} deg, {sized.supply / 1e5:.4g} bar",
        "arm": {"payload": _value(f"{payload:.4g} kg", f"{sized.payload_inertia:.4g} kg m2 at the link's end")},
        "supply": {"pressure_gauge": _value(f"{sized.supply / 1e5:.6g} bar", "asked for", "given")},
        "angle_sensor": {
            "range": _value(f"{degrees(sized.stroke) + 1.5 * OVERSHOOT_ROOM:.6g} deg", "mechanical stroke and 10 deg")
        },
        "pressure_sensor": {"range": _value(f"{ceil(2.5e-5 * sized.supply)} bar", "2.5 times supply pressure")},
        "joint": {joint_name: _joint(sized, base, ratios)},
    }
    if model.valve is not None:
        conductance = model.valve.conductance * ratios.volume * 1e8
        note = "grows with the hose's volume, so that filling takes as long as in the model"
        tables["valve"] = {"conductance": _value(f"{conductance:.4g} dm^3/(s bar)", note)}
        leakage = model.valve.leakage * ratios.volume * 1e8
        tables["valve"]["leakage"] = _value(f"{leakage:.4g} dm^3/(s bar)", "as the conductance")
    return tables


def description_text(tables: Tables) -> str:
    """TOML text, laid out as the built-in machines are."""
    return "\n".join(_lines(tables, "")) + "\n"


def _ratios(sized: SizedJoint, model: Machine, base: Joint) -> _Ratios:
    reach = base.link.length
    carried = base.link.rotor_inertia + base.link.inertia + base.link.mass * base.link.centre**2
    torque = sized.torque_constant * sized.supply / (torque_constant(base) * model.supply.pressure_gauge)
    volume = sized.swept_volume / travel_volume(base)
    inertia = (sized.payload_inertia + carried * torque) / (model.arm.payload * reach**2 + carried)
    return _Ratios(torque, volume, sized.joint.hose.width / base.hose.width, sqrt(torque / inertia))


def _joint(sized: SizedJoint, base: Joint, ratios: _Ratios) -> Tables:
    joint, torque = sized.joint, sized.torque_constant * sized.supply
    by_torque = "the paper's small joint, scaled by torque"
    tables: Tables = {
        "hose": {
            "width": _mm(joint.hose.width, "the narrowest that gives torque and stroke, or as given"),
            "wrap": _deg(joint.hose.wrap, "over 120 deg the hose kinks and slides"),
            "contact_end": _deg(joint.hose.contact_end, "0.7 of the wrap, as Table 1"),
            "dead_volume": _value(f"{base.hose.dead_volume * ratios.volume * 1e6:.4g} ml", "scaled by swept volume"),
            "compliance": _value(f"{base.hose.compliance * ratios.volume * 1e11:.4g} ml/bar", "scaled by swept volume"),
            "wall_conductance": _value(
                f"{base.hose.wall_conductance * ratios.volume ** (2 / 3):.4g} W/K", "scaled by the hose's area"
            ),
        },
        "cylinder": {
            "diameter": _mm(joint.cylinder.diameter, "sweeps torque x full travel / supply pressure"),
            "wall": _mm(joint.cylinder.wall, "scaled by diameter"),
        },
        "output": {
            "kind": _value("cam", "constant torque over the stroke"),
            "radius": _mm(joint.output.radius, "working stroke and 13.3 deg more at full travel"),
            "shaft_offset": _mm(
                joint.output.shaft_offset, "the strap pulls along the shell's motion and clears the edge"
            ),
        },
        "strap": {
            "width": _mm(joint.strap.width, "tension and bending below yield, with the margin asked for"),
            "thickness": _mm(joint.strap.thickness, "as its width"),
            "layers": _value(joint.strap.layers, "as its width"),
        },
        "cover": {"thickness": _mm(joint.cover.thickness, "scaled by diameter")},
        "brake": {
            "torque": _value(f"{BRAKE_SHARE * torque:.4g} N m", "8 % of maximum torque, section 4.2"),
            "viscous": _value(f"{base.brake.viscous * ratios.torque:.4g} N m s/rad", by_torque),
        },
        "stops": _stops(sized, base, ratios, by_torque),
        "link": {
            "mass": _value(f"{base.link.mass * ratios.torque:.4g} kg", by_torque),
            "inertia": _value(f"{base.link.inertia * ratios.torque:.4g} kg m^2", by_torque),
            "rotor_inertia": _value(f"{base.link.rotor_inertia * ratios.length**5:.4g} kg m^2", "scaled by size"),
        },
        "body": {
            "mass": _value(f"{sized.mass:.4g} kg", "counted parts over their share in the paper's small joint"),
            "height": _mm(HEIGHT_PER_WIDTH * joint.hose.width, "1.6 times the hose's width, as the paper's joints"),
        },
    }
    if base.gains is not None:
        tables["gains"] = _gains(base.gains, ratios.quickness)
    return tables


def _stops(sized: SizedJoint, base: Joint, ratios: _Ratios, by_torque: str) -> Tables:
    stops = base.stops
    return {
        "working_stroke": _value(f"{degrees(sized.stroke):.6g} deg", "asked for", "given"),
        "mechanical_stroke": _value(f"{degrees(sized.stroke) + OVERSHOOT_ROOM:.6g} deg", "20 deg more, section 2.3"),
        "squeeze_stiffness": _value(f"{stops.squeeze_stiffness * ratios.torque:.4g} N m/rad", by_torque),
        "stop_stiffness": _value(f"{stops.stop_stiffness * ratios.torque:.4g} N m/rad", by_torque),
        "stop_damping": _value(f"{stops.stop_damping * ratios.torque:.4g} N m s/rad", by_torque),
    }


def _gains(gains: JointGains, quickness: float) -> Tables:
    note = f"the paper's small joint times {quickness:.3g}: sqrt of torque per inertia, relative to it"
    tables: Tables = {
        phase: {
            "error": _value(f"{getattr(gains, phase).error * quickness:.4g} V/rad", note),
            "pressure": _value(f"{getattr(gains, phase).pressure * quickness * 1e5:.4g} V/bar", note),
        }
        for phase in ("far", "near", "close")
    }
    tables["integral"] = _value(f"{gains.integral * quickness:.4g} V/(rad s)", note)
    return tables


def _value(value: str | int, note: str, source: str = "derived") -> Tables:
    return {"value": value, "source": source, "note": note}


def _mm(value: float, note: str) -> Tables:
    return _value(f"{value * 1e3:.6g} mm", note)


def _deg(value: float, note: str) -> Tables:
    return _value(f"{degrees(value):.6g} deg", note)


def _lines(table: Tables, path: str) -> list[str]:
    own, below = [], []
    for key, value in table.items():
        here = f"{path}.{key}" if path else key
        if isinstance(value, dict) and "value" in value:
            own.append(f"{key} = {{ {', '.join(f'{k} = {_quoted(v)}' for k, v in value.items())} }}")
        elif isinstance(value, dict):
            below += _lines(value, here)
        else:
            own.append(f"{key} = {_quoted(value)}")
    head = ["", f"[{path}]"] if path and own else []
    return head + own + below


def _quoted(value: str | int) -> str:
    # A JSON string is a TOML basic string.
    return json.dumps(value, ensure_ascii=False)
