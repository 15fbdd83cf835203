"""Axis one: the small joint alone with and without its brake, against the earlier actuator (Fig. 13)."""

from functools import cached_property
from math import inf, radians

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.experiments.bench import INERTIA_PER_TORQUE, maximum_torque, payload_for_inertia
from layflat.experiments.claim import Evaluated, Experiment, Quantity, claim
from layflat.experiments.limits import (
    AT,
    DURATION,
    STEP,
    SWING,
    WINDOWS,
    Carried,
    carried,
    is_sustained,
    oscillation,
    stepped,
    watched,
)
from layflat.machine import Machine
from layflat.sim.metrics import move, settling_time

GOOD_TIME, SCAN = 1.5, 4.0  # allowed where one or two times are looked at, s: what the paper gives for the arm; more
CLOSE = radians(1.5)  # a joint that oscillates a little has come to its end within this
LITTLE = radians(1.0)  # a small oscillation, peak to peak
GROWS, FINE = 1.1, radians(0.1)  # an oscillation grows that gets larger than so many times what it was, and this more
SLOW = (2.0, 8.0)  # several seconds, s
TWICE = (1.4, 2.8)  # about twice
PER_TORQUE = "kg m2/(N m)"


def settling(run: xarray.Dataset) -> float:
    """Return the time from the step until the joint stays within 0.3 deg of its demand, s."""
    if not _is_whole(run):
        return inf
    return move(run, "small", since=AT).settling


def _is_whole(run: xarray.Dataset) -> bool:
    return float(run["time"][-1]) >= AT + DURATION - 0.01


def _course(run: xarray.Dataset) -> tuple[Array, Array]:
    """Time since the step (s), and angle (rad)."""
    part = run.sel(joint="small", time=slice(AT, None))
    return part["time"].to_numpy() - AT, part["angle"].to_numpy()


class AxisOne(Experiment):
    """Runs of a 40 deg step, and what both joints do with every inertia per torque."""

    def _step(self, machine: Machine, brake: float, payload: float | None = None) -> xarray.Dataset:
        """A step, up to where it diverged if it did; usually at the inertia per torque of the paper's comparison."""
        inertia = INERTIA_PER_TORQUE * maximum_torque(machine, "small")
        carries = payload_for_inertia(machine, "small", inertia) if payload is None else payload
        return watched(machine, stepped(brake, 1, carries))

    @cached_property
    def unbraked(self) -> xarray.Dataset:
        """The new joint without brake."""
        return self._step(self.bench.axis_one, 0.0)

    @cached_property
    def earlier(self) -> xarray.Dataset:
        """The earlier actuator."""
        return self._step(self.bench.earlier_scaled, 0.0)

    @cached_property
    def braked(self) -> xarray.Dataset:
        """The new joint with its brake and the paper's 2 kg."""
        return self._step(self.bench.axis_one, self.bench.brake, self.bench.axis_one.arm.payload)

    @cached_property
    def carried_braked(self) -> Carried:
        """What the new joint with its brake does with every inertia."""
        return carried(self.bench.axis_one, self.bench.brake)

    @cached_property
    def carried_earlier(self) -> Carried:
        """What the earlier actuator does with every inertia."""
        return carried(self.bench.earlier_scaled, 0.0)

    @claim("unbraked-joint")
    def unbraked_joint(self) -> Evaluated:
        """Compare both joints without brake."""
        if not _is_whole(self.unbraked):
            return [Quantity("diverged after", float(self.unbraked["time"][-1]) - AT, "s")], False
        time, angle = _course(self.unbraked)
        last, before = oscillation(time, angle)
        arrives = settling_time(time, angle - angle[time > time[-1] - SWING].mean(), CLOSE)
        overshoot, earlier = float(angle.max()) - STEP / 2, settling(self.earlier)
        calm = last <= LITTLE and last <= GROWS * before + FINE and overshoot <= STEP / 2
        return [
            Quantity("new joint arrives in", arrives, "s", "several seconds"),
            Quantity("oscillation left", float(np.degrees(last)), "deg", "small"),
            Quantity("overshoot", float(np.degrees(overshoot)), "deg"),
            Quantity("earlier actuator settles in", earlier, "s", "good"),
        ], calm and SLOW[0] <= arrives <= SLOW[1] and 2.0 * earlier <= arrives

    @claim("braked-joint")
    def braked_joint(self) -> Evaluated:
        """Settle with the brake, and compare the greatest inertias that settle, whatever the time allowed."""
        time, calm = settling(self.braked), not is_sustained(*_course(self.braked))
        new, earlier = self.carried_braked, self.carried_earlier
        pairs = {f"within {allowed:g} s": (new.within(allowed), earlier.within(allowed)) for allowed in WINDOWS}
        pairs["without sustained oscillation"] = new.stable, earlier.stable
        ratios = {name: ours / theirs if theirs > 0.0 else inf for name, (ours, theirs) in pairs.items()}
        return [
            Quantity("settling", time, "s", "stable"),
            Quantity("limit with brake", new.stable, PER_TORQUE),
            Quantity("limit of earlier", earlier.stable, PER_TORQUE),
            *(Quantity(f"ratio {name}", ratio, paper="about 2") for name, ratio in ratios.items()),
        ], time < inf and calm and all(TWICE[0] <= ratio <= TWICE[1] for ratio in ratios.values())
