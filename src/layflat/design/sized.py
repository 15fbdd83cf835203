"""The description of a sized joint: only what differs from the model machine, each value with its provenance.

Similarity: a volt fills a hose as fast in shares of the supply pressure if the valve's conductance grows with the
hose's volume, and shares of the supply pressure are what moves the joint. So the gains of the error are the model's,
and those of the pressure go with one over the supply pressure. A joint that carries more inertia per torque than the
model moves more slowly, as sqrt(T/J), and the speeds below which its phases begin fall with it. One that carries less
is not made quicker: spool, averaging and control cycle are as slow as the model's.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from math import ceil, degrees, sqrt
from typing import NamedTuple

from layflat.control.paper import PaperGainsPart
from layflat.design.request import SizingRequest
from layflat.machine import Joint, Machine
from layflat.machine.parameters import torque_constant

Rows = Iterator[tuple[str, str | int, str]]  # dotted path, value as it is written, and note

BRAKE_SHARE = 0.08  # brake over maximum torque; source: section 4.2
OVERSHOOT_ROOM = 20.0  # mechanical less working stroke, deg; source: section 2.3
HEIGHT_PER_WIDTH = 1.6  # height of a joint over the width of its hose: 1.64 and 1.56 in the paper
INERTIA_PER_TORQUE = 1e-2  # payload inertia that a joint carries, kg m2 per N m; source: section 5
GIVEN_NOTE = "asked for"  # note of values that are given; all others are derived
BY_TORQUE = "the paper's small joint, scaled by torque"


@dataclass(frozen=True)
class SizedJoint:
    """Sized joint, in SI."""

    request: SizingRequest
    joint: Joint  # the model's joint with its new sizes
    torque_constant: float  # K, m3/rad
    swept_volume: float  # of one hose, m3
    mass: float  # of the whole joint, kg

    @property
    def torque(self) -> float:
        """Torque at supply pressure, N m."""
        return self.torque_constant * self.request.supply

    @property
    def payload_inertia(self) -> float:
        """Inertia of the payload about the joint, kg m2."""
        return self.request.payload_inertia or INERTIA_PER_TORQUE * self.request.torque


class _Ratios(NamedTuple):
    """Ratios of the sized joint's quantities to the model's."""

    torque: float
    volume: float
    width: float
    length: float
    supply: float


def joint_description(sized: SizedJoint, model: Machine, extends: str) -> str:
    """Return the TOML text of a machine with the sized joint, in the layout of the built-in machines.

    Args:
        sized: the joint.
        model: machine with one joint, from which all other values are scaled.
        extends: name of this machine in the text.
    """
    joint_name, base = next(iter(model.joints.items()))
    request, length = sized.request, sized.request.link_length or base.planar_link.length
    ratios = _Ratios(
        torque=sized.torque / (torque_constant(base) * model.supply.pressure_gauge),
        volume=sized.swept_volume / base.geometry.volume,
        width=sized.joint.hose.width / base.hose.width,
        length=length / base.planar_link.length,
        supply=request.supply / model.supply.pressure_gauge,
    )
    stroke, bar = degrees(request.stroke), request.supply / 1e5
    title = f"Sized for {request.torque:.4g} N m, {stroke:.4g} deg, {bar:.4g} bar"
    lines = [
        f"{key} = {_quoted(text)}" for key, text in {"extends": extends, "name": request.name, "title": title}.items()
    ]
    payload = f"{sized.payload_inertia / length**2:.4g} kg"
    rows: list[tuple[str, str | int, str]] = [
        ("arm.payload", payload, f"{sized.payload_inertia:.4g} kg m2 at the link's end"),
        ("supply.pressure_gauge", f"{bar:.6g} bar", GIVEN_NOTE),
        ("angle_sensor.range", f"{stroke + 1.5 * OVERSHOOT_ROOM:.6g} deg", "mechanical stroke and 10 deg"),
        ("pressure_sensor.range", f"{ceil(2.5e-5 * request.supply)} bar", "2.5 times supply pressure"),
    ]
    joint_rows = [*_sizes(sized, base, ratios), *_scaled(sized, base, ratios)]
    if base.gains is not None:
        joint_rows += _gains(base.gains, ratios, _speed_ratio(sized, model, base, ratios))
    rows += [(f"joint.{joint_name}.{path}", value, note) for path, value, note in joint_rows]
    if model.valve is not None:
        conductance, leakage = (flow * ratios.volume * 1e8 for flow in (model.valve.conductance, model.valve.leakage))
        note = "grows with the hose's volume, so that filling takes as long as in the model"
        rows += [
            ("valve.conductance", f"{conductance:.4g} dm^3/(s bar)", note),
            ("valve.leakage", f"{leakage:.4g} dm^3/(s bar)", "as the conductance"),
        ]
    for table, values in groupby(rows, lambda row: row[0].rpartition(".")[0]):
        lines += ["", f"[{table}]"]
        for path, value, note in values:
            source = "given" if note == GIVEN_NOTE else "derived"
            described = f"value = {_quoted(value)}, source = {_quoted(source)}, note = {_quoted(note)}"
            lines.append(f"{path.rpartition('.')[2]} = {{ {described} }}")
    return "\n".join(lines) + "\n"


def _sizes(sized: SizedJoint, base: Joint, ratios: _Ratios) -> Rows:
    """Yield the sizes that the sizing chose, and values of the hose that follow from them."""
    joint, volume = sized.joint, ratios.volume
    hose, strap = joint.hose, joint.strap
    yield "hose.width", _mm(hose.width), "the narrowest that gives torque and stroke, or as given"
    yield "hose.wrap", f"{degrees(hose.wrap):.6g} deg", "over 120 deg the hose kinks and slides"
    yield "hose.contact_end", f"{degrees(hose.contact_end):.6g} deg", "0.7 of the wrap, as Table 1"
    yield "hose.dead_volume", f"{base.hose.dead_volume * volume * 1e6:.4g} ml", "scaled by swept volume"
    yield "hose.compliance", f"{base.hose.compliance * volume * 1e11:.4g} ml/bar", "scaled by swept volume"
    conductance = base.hose.wall_conductance * volume ** (2 / 3)
    yield "hose.wall_conductance", f"{conductance:.4g} W/K", "scaled by the hose's area"
    yield "cylinder.diameter", _mm(joint.cylinder.diameter), "sweeps torque x full travel / supply pressure"
    yield "cylinder.wall", _mm(joint.cylinder.wall), "scaled by diameter"
    yield "output.kind", "cam", "constant torque over the stroke"
    yield "output.radius", _mm(joint.output.radius), "working stroke and 13.3 deg more at full travel"
    clears = "the strap pulls along the shell's motion and clears the edge"
    yield "output.shaft_offset", _mm(joint.output.shaft_offset), clears
    yield "strap.width", _mm(strap.width), "tension and bending below yield, with the margin asked for"
    yield "strap.thickness", _mm(strap.thickness), "as its width"
    yield "strap.layers", strap.layers, "as its width"
    yield "cover.thickness", _mm(joint.cover.thickness), "scaled by diameter"


def _scaled(sized: SizedJoint, base: Joint, ratios: _Ratios) -> Rows:
    """Yield values scaled from the model's joint: the mass per length of a link is scaled by torque."""
    torque, length, stroke = ratios.torque, ratios.length, degrees(sized.request.stroke)
    stops, link = base.stops, base.planar_link
    yield "brake.torque", f"{BRAKE_SHARE * sized.torque:.4g} N m", "8 % of maximum torque, section 4.2"
    yield "brake.viscous", f"{base.brake.viscous * torque:.4g} N m s/rad", BY_TORQUE
    yield "stops.working_stroke", f"{stroke:.6g} deg", GIVEN_NOTE
    yield "stops.mechanical_stroke", f"{stroke + OVERSHOOT_ROOM:.6g} deg", "20 deg more, section 2.3"
    yield "stops.squeeze_stiffness", f"{stops.squeeze_stiffness * torque:.4g} N m/rad", BY_TORQUE
    yield "stops.stop_stiffness", f"{stops.stop_stiffness * torque:.4g} N m/rad", BY_TORQUE
    yield "stops.stop_damping", f"{stops.stop_damping * torque:.4g} N m s/rad", BY_TORQUE
    if length != 1.0:
        yield "link.length", _mm(link.length * length), GIVEN_NOTE
        yield "link.centre", _mm(link.centre * length), "as its length"
    note = BY_TORQUE if length == 1.0 else f"{BY_TORQUE} and length"
    yield "link.mass", f"{link.mass * torque * length:.4g} kg", note
    yield "link.inertia", f"{link.inertia * torque * length**3:.4g} kg m^2", note
    yield "link.rotor_inertia", f"{link.rotor_inertia * ratios.width**5:.4g} kg m^2", "scaled by size"
    yield "body.mass", f"{sized.mass:.4g} kg", "counted parts over their share in the paper's small joint"
    height = _mm(HEIGHT_PER_WIDTH * sized.joint.hose.width)
    yield "body.height", height, "1.6 times the hose's width, as the paper's joints"


def _speed_ratio(sized: SizedJoint, model: Machine, base: Joint, ratios: _Ratios) -> float:
    """Return the speed of the sized joint over the model's, by sqrt(T/J): at most 1."""
    link = base.planar_link
    along = link.inertia + link.mass * link.centre**2
    inertia = sized.payload_inertia + along * ratios.torque * ratios.length**3 + link.rotor_inertia * ratios.width**5
    model_inertia = model.arm.payload * link.length**2 + along + link.rotor_inertia
    return min(1.0, sqrt(ratios.torque * model_inertia / inertia))


def _gains(gains: PaperGainsPart, ratios: _Ratios, speed_ratio: float) -> Rows:
    """Yield the gains that differ from the model's: all but those of error and integral."""
    for phase in ("far", "near", "close"):
        pressure = getattr(gains, phase).pressure / ratios.supply * 1e5
        note = f"the paper's small joint over {ratios.supply:.3g}: its share of the supply pressure"
        yield f"gains.{phase}.pressure", f"{pressure:.4g} V/bar", note
    for threshold in ("near_below", "close_below"):
        speed = degrees(getattr(gains, threshold).speed * speed_ratio)
        note = f"the paper's small joint times {speed_ratio:.3g}: sqrt of torque per inertia, relative to it, at most 1"
        yield f"gains.{threshold}.speed", f"{speed:.4g} deg/s", note


def _mm(value: float) -> str:
    return f"{value * 1e3:.6g} mm"


def _quoted(value: str | int) -> str:
    return json.dumps(value, ensure_ascii=False)  # a JSON string is a TOML basic string
