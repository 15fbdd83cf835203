"""A hose in its joint: stroke, losses, chamber.

| symbol | meaning | unit |
|---|---|---|
| s | travel of a hose: output angle from its collapsed state on | rad |
| S | full travel: (gamma - alpha_end) c R/r | rad |
| K | torque per pressure | m3/rad |
"""

from __future__ import annotations

from functools import partial
from math import pi
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyfit

from layflat.lanes import mapped
from layflat.machine import parts
from layflat.physics.arrays import itemwise
from layflat.physics.chamber import Chamber
from layflat.physics.hose import ConstantStroke, Stroke, peeled_volume, roller_torque, roller_travel
from layflat.physics.hysteresis import HYSTERESIS
from layflat.physics.joint import Hose


def full_travel(joint: parts.Joint) -> float:
    """S: output angle between the collapsed hose and its end of travel, rad."""
    hose, R = joint.hose, joint.cylinder.diameter / 2
    return itemwise(roller_travel, R, joint.output.radius, hose.wrap, hose.contact_end, hose.peel_ratio)


def travel_volume(joint: parts.Joint) -> float:
    """Volume that one hose sweeps over its full travel, m3."""
    hose, R = joint.hose, joint.cylinder.diameter / 2
    swept = itemwise(peeled_volume, R, hose.width / pi, hose.wrap, hose.contact_end, hose.peel_ratio)
    return hose.torque_factor * swept


def stroke(joint: parts.Joint) -> ConstantStroke | Stroke:
    """K over the travel of one hose: Eq. (1) for a roller, its mean for a cam."""
    S = full_travel(joint)
    if joint.output.kind == "cam":
        return ConstantStroke(travel_volume(joint) / S)
    hose, R, r = joint.hose, joint.cylinder.diameter / 2, joint.output.radius
    t = 0.5 - 0.5 * np.cos(np.linspace(0.0, pi, 41))
    alphas = [hose.wrap - share * S * r / (hose.peel_ratio * R) for share in t]
    one = partial(itemwise, roller_torque, 1.0, R, r, hose.width / pi, hose.wrap)
    K = np.array([hose.torque_factor * one(alpha) for alpha in alphas])
    return Stroke(*(k / S**i for i, k in enumerate(polyfit(t, K, 4))))


def torque_constant(joint: parts.Joint) -> float:
    """Greatest K over the travel, m3/rad: maximum torque per gauge pressure."""
    curve = stroke(joint)
    if isinstance(curve, ConstantStroke):
        return curve.k0
    S, t = full_travel(joint), np.linspace(0.0, 1.0, 101)
    return np.max(sum(np.multiply.outer(t**i, k * S**i) for i, k in enumerate(curve)), axis=0)  # type: ignore[no-any-return]


def loss_share(joint: parts.Joint) -> float:
    """Loop height over greatest torque at the reference pressure, of hose, strap and rollers together."""
    share = joint.hose.loss_share * joint.cover.loss_factor + joint.strap.loss_share
    roller = joint.deflecting_roller
    if roller is not None:
        bend = joint.strap.thickness / roller.diameter
        share += roller.count * (roller.friction_share + roller.bending_share * bend)
    return share


def loss(joint: parts.Joint) -> Any:
    """Parameters of the hysteresis of one hose with its strap."""
    at = joint.losses.reference_pressure_gauge
    # A loop is twice as high as the torque that opposes either way.
    limit = 0.5 * loss_share(joint) * torque_constant(joint) * at
    return HYSTERESIS.parameters(joint.losses, limit)


def hose(joint: parts.Joint) -> Hose:
    """One hose in its joint."""
    chamber = Chamber(joint.hose.dead_volume, joint.hose.compliance, joint.hose.wall_conductance)
    return Hose(stroke(joint), chamber, loss(joint), full_travel(joint) / 2)


def no_hose(hose: Hose) -> Hose:
    """In place of the second hose of a single-acting joint that has this one: it turns nothing."""
    return Hose(ConstantStroke(0.0), Chamber(1e-5, 0.0, 0.0), mapped(hose.loss, lambda _: 0.0), 0.0)


def long_stroke(stroke: ConstantStroke | Stroke) -> Stroke:
    """The same stroke as one that may change over its travel."""
    return Stroke(*stroke, *[0.0] * (len(Stroke._fields) - len(stroke)))
