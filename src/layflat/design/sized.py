"""The description of a sized joint: only what differs from the model machine, each value with its provenance.

Similarity: a volt fills a hose as fast in shares of the supply pressure if the valve's conductance grows with the
hose's volume, and shares of the supply pressure are what moves the joint. So the gains of the error are the model's,
and those of the pressure go with one over the supply pressure. A joint that carries more inertia per torque than the
model moves more slowly, as sqrt(T/J), and the speeds below which its phases begin fall with it. One that carries less
is not made quicker: spool, averaging and control cycle are as slow as the model's.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import ceil, degrees, sqrt
from typing import Any

from layflat.control.paper import PaperGainsPart
from layflat.design.request import SizingRequest
from layflat.machine import Joint, Machine
from layflat.machine.parameters import torque_constant, travel_volume
from layflat.machine.parts import Link

Tables = dict[str, Any]

BRAKE_SHARE = 0.08
"""Brake over maximum torque. Source: section 4.2."""

OVERSHOOT_ROOM = 20.0
"""Mechanical beyond working stroke, deg. Source: section 2.3."""

HEIGHT_PER_WIDTH = 1.6
"""Height of a joint over the width of its hose: 1.64 and 1.56 in the paper."""

INERTIA_PER_TORQUE = 1e-2
"""Payload inertia that a joint carries, kg m2 per N m. Source: section 5."""

BY_TORQUE = "the paper's small joint, scaled by torque"


@dataclass(frozen=True)
class SizedJoint:
    """What sizing settled, in SI.

    Args:
        request: what was asked for.
        joint: the model's joint with its new sizes.
        torque_constant: K, m3/rad.
        swept_volume: of one hose, m3.
        mass: of the whole joint, kg.
    """

    request: SizingRequest
    joint: Joint
    torque_constant: float
    swept_volume: float
    mass: float

    @property
    def torque(self) -> float:
        """Torque at supply pressure, N m."""
        return self.torque_constant * self.request.supply

    @property
    def payload_inertia(self) -> float:
        """Of what is carried, about the joint, kg m2."""
        return self.request.payload_inertia or INERTIA_PER_TORQUE * self.request.torque


@dataclass(frozen=True)
class _Ratios:
    """Of the sized joint to the model's: torque, hose's volume, hose's width, link's length, supply pressure."""

    torque: float
    volume: float
    width: float
    reach: float
    supply: float


def description(sized: SizedJoint, model: Machine, extends: str, name: str) -> Tables:
    """Return nested tables of a machine with the sized joint; leaves are tables of value, source and note."""
    joint_name, base = next(iter(model.joints.items()))
    request, reach = sized.request, sized.request.link_length or base.link.length
    ratios = _Ratios(
        torque=sized.torque / (torque_constant(base) * model.supply.pressure_gauge),
        volume=sized.swept_volume / travel_volume(base),
        width=sized.joint.hose.width / base.hose.width,
        reach=reach / base.link.length,
        supply=request.supply / model.supply.pressure_gauge,
    )
    payload, stroke = sized.payload_inertia / reach**2, degrees(request.stroke)
    tables: Tables = {
        "extends": extends,
        "name": name,
        "title": f"Sized for {request.torque:.4g} N m, {stroke:.4g} deg, {request.supply / 1e5:.4g} bar",
        "arm": {"payload": _value(f"{payload:.4g} kg", f"{sized.payload_inertia:.4g} kg m2 at the link's end")},
        "supply": {"pressure_gauge": _value(f"{request.supply / 1e5:.6g} bar", "asked for", "given")},
        "angle_sensor": {"range": _value(f"{stroke + 1.5 * OVERSHOOT_ROOM:.6g} deg", "mechanical stroke and 10 deg")},
        "pressure_sensor": {"range": _value(f"{ceil(2.5e-5 * request.supply)} bar", "2.5 times supply pressure")},
        "joint": {joint_name: _joint(sized, base, ratios)},
    }
    if base.gains is not None:
        tables["joint"][joint_name]["gains"] = _gains(base.gains, ratios, _slowness(sized, model, base, ratios))
    if model.valve is not None:
        conductance = model.valve.conductance * ratios.volume * 1e8
        note = "grows with the hose's volume, so that filling takes as long as in the model"
        tables["valve"] = {"conductance": _value(f"{conductance:.4g} dm^3/(s bar)", note)}
        leakage = model.valve.leakage * ratios.volume * 1e8
        tables["valve"]["leakage"] = _value(f"{leakage:.4g} dm^3/(s bar)", "as the conductance")
    return tables


def description_text(tables: Tables) -> str:
    """Return TOML text, laid out as the built-in machines are."""
    return "\n".join(_lines(tables, "")) + "\n"


def _joint(sized: SizedJoint, base: Joint, ratios: _Ratios) -> Tables:
    joint = sized.joint
    return {
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
            "torque": _value(f"{BRAKE_SHARE * sized.torque:.4g} N m", "8 % of maximum torque, section 4.2"),
            "viscous": _value(f"{base.brake.viscous * ratios.torque:.4g} N m s/rad", BY_TORQUE),
        },
        "stops": _stops(sized, base, ratios),
        "link": _link(base.link, ratios),
        "body": {
            "mass": _value(f"{sized.mass:.4g} kg", "counted parts over their share in the paper's small joint"),
            "height": _mm(HEIGHT_PER_WIDTH * joint.hose.width, "1.6 times the hose's width, as the paper's joints"),
        },
    }


def _stops(sized: SizedJoint, base: Joint, ratios: _Ratios) -> Tables:
    stops, stroke = base.stops, degrees(sized.request.stroke)
    return {
        "working_stroke": _value(f"{stroke:.6g} deg", "asked for", "given"),
        "mechanical_stroke": _value(f"{stroke + OVERSHOOT_ROOM:.6g} deg", "20 deg more, section 2.3"),
        "squeeze_stiffness": _value(f"{stops.squeeze_stiffness * ratios.torque:.4g} N m/rad", BY_TORQUE),
        "stop_stiffness": _value(f"{stops.stop_stiffness * ratios.torque:.4g} N m/rad", BY_TORQUE),
        "stop_damping": _value(f"{stops.stop_damping * ratios.torque:.4g} N m s/rad", BY_TORQUE),
    }


def _link(base: Link, ratios: _Ratios) -> Tables:
    """The model's link, as heavy per length as its torque is greater; its length and centre only where asked for."""
    torque, reach = ratios.torque, ratios.reach
    note = BY_TORQUE if reach == 1.0 else f"{BY_TORQUE} and length"
    tables = {
        "mass": _value(f"{base.mass * torque * reach:.4g} kg", note),
        "inertia": _value(f"{base.inertia * torque * reach**3:.4g} kg m^2", note),
        "rotor_inertia": _value(f"{base.rotor_inertia * ratios.width**5:.4g} kg m^2", "scaled by size"),
    }
    if reach == 1.0:
        return tables
    own = {
        "length": _mm(base.length * reach, "asked for", "given"),
        "centre": _mm(base.centre * reach, "as its length"),
    }
    return own | tables


def _slowness(sized: SizedJoint, model: Machine, base: Joint, ratios: _Ratios) -> float:
    """How slowly the sized joint moves beside the model's, sqrt(T/J) over the model's: at most 1."""
    link = base.link
    along = link.inertia + link.mass * link.centre**2
    own = sized.payload_inertia + along * ratios.torque * ratios.reach**3 + link.rotor_inertia * ratios.width**5
    models = model.arm.payload * link.length**2 + along + link.rotor_inertia
    return min(1.0, sqrt(ratios.torque * models / own))


def _gains(gains: PaperGainsPart, ratios: _Ratios, slowness: float) -> Tables:
    """What differs from the model's gains; those of the error and the integral do not."""
    by_supply = f"the paper's small joint over {ratios.supply:.3g}: its share of the supply pressure"
    by_speed = f"the paper's small joint times {slowness:.3g}: sqrt of torque per inertia, relative to it, at most 1"
    tables: Tables = {
        phase: {"pressure": _value(f"{getattr(gains, phase).pressure / ratios.supply * 1e5:.4g} V/bar", by_supply)}
        for phase in ("far", "near", "close")
    }
    for threshold in ("near_below", "close_below"):
        speed = degrees(getattr(gains, threshold).speed * slowness)
        tables[threshold] = {"speed": _value(f"{speed:.4g} deg/s", by_speed)}
    return tables


def _value(value: str | int, note: str, source: str = "derived") -> Tables:
    return {"value": value, "source": source, "note": note}


def _mm(value: float, note: str, source: str = "derived") -> Tables:
    return _value(f"{value * 1e3:.6g} mm", note, source)


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
