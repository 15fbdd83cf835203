"""What is watched of each joint in every cycle, for a supervisor outside the controller: a few comparisons each.

All conditions are written so that what is not a number is at fault. How the limits were found stands in docs/rig.md.
"""

from math import inf, nan, sqrt
from typing import NamedTuple

from layflat.jit import kernel, law
from layflat.lanes import write_row

PRESSED, AT_RAIL, FAST, OUTSIDE, VALVE_UNRESPONSIVE, ANGLE_FROZEN, PRESSURE_FROZEN, OFF_TRACK = (
    1 << bit for bit in range(8)
)
"""Bits of what was found."""

SENSORS, MOTION, AIR = 0, 1, 2
"""What there is to watch: sensors alone; motion too, while air comes; all, where air is there and valves obey."""

MOVING = 2.5
"""Counts from one sample to the next that are motion, not noise."""

BRISK = 5.5
"""The same after which no joint stands still at once: 40 deg/s with the built-in sensor."""

BEYOND = 1.9
"""Of the differential pressure that friction can hide: so much, what others hold off left out, a joint never bears
without a motion of one count. Sound ones at rest, shaken by another, bear 1.6 in an hour."""

TURNS = 0.05
"""Speed from which a joint shakes the others by its torque, which its own brake holds before, rad/s."""

DRIVEN = 0.09
"""Error of a joint that is driven, rad; by less friction may hold it."""


class Limits(NamedTuple):
    """What a joint's signals are judged by; SI."""

    angle_low: float
    """At or below it, or at or above the next, the angle sensor is at its rail, rad."""
    angle_high: float
    lsb: float
    """One count of the angle's converter, rad."""
    stroke: float
    """Beyond it on either side a joint is outside, rad."""
    speed: float
    pressure: float
    """Of differential pressure on either side, Pa."""
    friction_band: float
    """Change of the differential pressure that friction of brake, hose and strap can hide, Pa."""
    following: float
    """Error of a joint that does not move, rad."""
    following_time: float
    """What the error may grow by with speed, s."""
    demand_speed: float
    surplus: float
    """Of air, as an opening of the valve; infinite where the air can't be watched: a joint of a single hose."""
    ripple: float
    """Amplitude below which there is no air (rule 1 of the controller), Pa; zero where the dither can't be seen."""
    lively: float
    """1 if a sound pressure sensor changes all the time, else 0."""


class Patience(NamedTuple):
    """How long conditions have to last: samples, or seconds."""

    rail: float
    fast: float
    outside: float
    pressed: float
    frozen_pressure: float
    """s, as all that follow."""
    frozen_angle: float
    following: float
    quiet: float
    doubtful: float
    """Of the same sample, after which a sensor may be frozen: what is computed from it says nothing of the valve."""
    sure: float
    """The same, when such a sensor does not fit what the valve was told: it is frozen."""
    asleep: float
    """In which a driven joint moves by a count."""
    held: float
    """In which it moves by more than noise."""


class WatchMemory(NamedTuple):
    """What the watch over a joint remembers: samples, and how long conditions have held."""

    angle: float
    """The last sample, rad."""
    pressure_1: float
    """The last samples, newest first, Pa."""
    pressure_2: float
    pressure_3: float
    swing: float
    ripple: float
    """Amplitude of the pressure at a quarter of the loop's rate, whatever its slope; infinite at first, Pa."""
    rail: float
    fast: float
    outside: float
    pressed: float
    same_pressure: float
    same_angle: float
    off: float
    quiet: float
    asleep: float
    least: float
    """Differential pressure since the angle last changed, Pa."""
    most: float
    net_least: float
    """The same less what joints that turn would hold off, Pa."""
    net_most: float
    step: float
    """By which the angle last changed, rad."""
    suspect: float
    reach: float
    """Where the joint should be by now, rad; not a number at first."""
    anchor: float
    """Where it was when it last moved by more than noise, rad."""
    held: float


LIMITS, PATIENCE, WATCH_MEMORY = (len(kind._fields) for kind in (Limits, Patience, WatchMemory))

FRESH = WatchMemory._make([nan] * 5 + [inf] + [0.0] * 15 + [nan] * 2 + [0.0])
"""Memory of a watch that begins."""


@law
def _count(before, condition):
    return before + 1.0 if condition else 0.0


@law
def _last(before, condition, elapsed):
    return before + elapsed if condition else 0.0


@law
def _listen(memory, pressure):
    """Swing and ripple: a slope cancels in a swing, and two swings are a quarter of a period apart."""
    swing = (pressure - memory.pressure_2) - (memory.pressure_1 - memory.pressure_3)
    size = swing * swing + memory.swing * memory.swing
    return swing, sqrt(0.125 * size) if size >= 0.0 else inf


@law
def _reach(limits, reach, angle, demand, elapsed):
    """Where a joint should be: that goes to the demand as fast as demands may for long, or as the joint, if faster.

    So a step is no error, and a joint that is ahead of its time is none either.
    """
    way = limits.demand_speed * elapsed
    start = reach if reach == reach else angle  # noqa: PLR0124  # not a number: none yet
    return min(max(start + way, angle), demand) if demand >= start else max(min(start - way, angle), demand)


@law
def _limited(limits, patience, before, angle, pressure, elapsed, level):
    """Counts of samples at the rail, under pressure, fast, and outside, and bits of those that are enough."""
    sound = limits.angle_low < angle < limits.angle_high
    was_sound = limits.angle_low < before.angle < limits.angle_high
    step = abs(angle - before.angle)
    # Of a joint that speeds up, the mean since the last sample tells half a cycle late.
    gained = 0.5 * (step - before.step)
    speed = (step + (gained if gained > 0.0 else 0.0)) / elapsed
    rail = _count(before.rail, not sound)
    pressed = _count(before.pressed, not (-limits.pressure < pressure < limits.pressure))
    fast = _count(before.fast, level >= MOTION and sound and was_sound and speed > limits.speed)
    # Past the stroke comes the sensor's rail: one that gets there is still outside.
    beyond = abs(angle) > limits.stroke if sound else before.outside > 0.0
    outside = _count(before.outside, level >= MOTION and beyond)
    found = AT_RAIL if rail >= patience.rail else 0
    found |= PRESSED if pressed >= patience.pressed else 0
    found |= FAST if fast >= patience.fast else 0
    found |= OUTSIDE if outside >= patience.outside else 0
    return rail, pressed, fast, outside, found


@law
def watch_joint(
    limits, patience, before, angle, pressure, averaged, others, speed, surplus, demand, lead, elapsed, level, alone
):
    """Memory and bits of what was found after a cycle.

    Args: `Limits`, `Patience`, `WatchMemory`; angle (rad) and differential pressure (Pa) as sampled, the latter
    averaged, and what the others hold off of it if they turn (Pa), speed (rad/s); surplus of air; demand and the
    greatest lead of any demand (rad); s; what there is to watch; whether the supply is beyond doubt.
    """
    swing, ripple = _listen(before, pressure)
    step = abs(angle - before.angle)
    rail, pressed, fast, outside, found = _limited(limits, patience, before, angle, pressure, elapsed, level)
    airy = level >= AIR
    same = airy and angle == before.angle
    last_step = before.step if same else step
    least = min(before.least, averaged) if same else averaged
    most = max(before.most, averaged) if same else averaged
    # Shaken by the others, or not as much as is believed: it is blocked if it bears both.
    net_least = min(before.net_least, averaged - others) if same else averaged - others
    net_most = max(before.net_most, averaged - others) if same else averaged - others
    borne = min(most - least, net_most - net_least)
    same_angle = _last(before.same_angle, same, elapsed)
    same_pressure = _last(before.same_pressure, airy and limits.lively > 0.0 and pressure == before.pressure_1, elapsed)
    doubt_angle = same_angle > patience.doubtful and last_step > MOVING * limits.lsb
    doubt = same_pressure > patience.doubtful or doubt_angle
    wrong = airy and alone and abs(surplus) > limits.surplus
    suspect = doubt and (wrong or before.suspect > 0.0)
    stays = same_angle > patience.sure
    if wrong and not doubt:
        found |= ANGLE_FROZEN if stays and most - least > limits.friction_band else VALVE_UNRESPONSIVE
    quiet = _last(before.quiet, airy and alone and ripple < limits.ripple, elapsed)
    found |= VALVE_UNRESPONSIVE if quiet >= patience.quiet else 0
    driven = airy and abs(demand - angle) > DRIVEN
    asleep = _last(before.asleep, same and driven, elapsed)
    anchor = before.anchor if abs(angle - before.anchor) <= MOVING * limits.lsb else angle
    held = _last(before.held, anchor == before.anchor and driven, elapsed)
    brisk = last_step > BRISK * limits.lsb
    if (
        (stays and (brisk or (doubt_angle and suspect)))
        or asleep >= patience.asleep
        or held >= patience.held
        or (same_angle >= patience.frozen_angle and borne > BEYOND * limits.friction_band)
    ):
        found |= ANGLE_FROZEN
    if same_pressure >= patience.frozen_pressure or (suspect and same_pressure > patience.sure):
        found |= PRESSURE_FROZEN

    reach = _reach(limits, before.reach, angle, demand, elapsed) if airy else nan
    allowed = limits.following + limits.following_time * abs(speed) + lead
    off = _last(before.off, airy and abs(angle - reach) > allowed, elapsed)
    found |= OFF_TRACK if off >= patience.following else 0
    after = WatchMemory(
        angle, pressure, before.pressure_1, before.pressure_2, swing, ripple, rail, fast, outside, pressed,
        same_pressure, same_angle, off, quiet, asleep, least, most, net_least, net_most, last_step,
        1.0 if suspect else 0.0, reach, anchor, held,
    )  # fmt: skip
    return after, found


@law
def _limits(row):
    return Limits(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10], row[11], row[12]
    )


@law
def _memory(row):
    return WatchMemory(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10], row[11], row[12],
        row[13], row[14], row[15], row[16], row[17], row[18], row[19], row[20], row[21],
        row[22], row[23],
    )  # fmt: skip


@kernel
def watch_joints(
    limits, patience, coupling, memory, angles, pressures, status, beliefs, demands, lead, elapsed, level, fed, found
):
    """`watch_joint` for all joints.

    Args: rows of `Limits` (joints, LIMITS); `Patience` as a row; how much of each other joint's differential pressure a
    joint at rest feels (joints, joints); `memory` (1, joints, WATCH_MEMORY), changed; what was measured (joints,);
    `status` of the controllers (1, joints, ...); `beliefs` in the air (1, joints, ...), the surplus last; demands
    (joints,) and their greatest lead; s; what there is to watch; whether the supply's pressure is good. Writes bits
    into `found` (joints,). Returns the number of joints whose ripple is missing.
    """
    n, p = len(angles), patience
    times = Patience(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11])
    still = 0
    for j in range(n):
        _, ripple = _listen(_memory(memory[0, j]), pressures[j])
        still += 1 if ripple < limits[j, 11] else 0
    alone = fed and (n == 1 or still < n)
    for j in range(n):
        others = 0.0
        for i in range(n):
            others += coupling[j, i] * status[0, i, 2] if abs(status[0, i, 1]) > TURNS else 0.0
        after, found[j] = watch_joint(
            _limits(limits[j]), times, _memory(memory[0, j]), angles[j], pressures[j], status[0, j, 2], others,
            status[0, j, 1], beliefs[0, j, 3], demands[j], lead, elapsed, level, alone,
        )  # fmt: skip
        write_row(memory, 0, j, after)
    return still
