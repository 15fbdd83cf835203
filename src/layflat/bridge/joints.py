"""Joints of layflat hose on hinges of any MuJoCo model: voltages in, angles out."""

from collections.abc import Mapping
from math import ceil
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.bridge.arm import engine
from layflat.bridge.brake import Brakes
from layflat.bridge.halves import Carry, extrapolate, halves_of
from layflat.errors import DivergedError, InputError
from layflat.lanes import leaves, read_numbers
from layflat.machine import Machine, parameters
from layflat.physics.delay import NOTHING_ASKED
from layflat.physics.driven import DrivenJoints, Outputs
from layflat.physics.joint import FILLED, Ledger, Surroundings, joint_at_rest
from layflat.physics.step import STEP
from layflat.physics.valves import held_at

SHORTEST = 1e-6  # timestep of a model, s


class PneumaticJoints(DrivenJoints):
    """A machine's joints on hinges of a model: valves, hoses, losses, stops, brakes; `step` takes the place of mj_step.

    A hinge's zero has to lie in the middle of its joint's stroke, and hose A turns it forward. All that the model says
    of the hinges (damping, friction, limits) acts as well. Between steps `data.qpos` of a moving hinge is half a step
    ahead of `angles` (see halves.py).

    Args:
        model: an MjModel.
        machine: whose joints they are.
        joints: name of the machine's joint that drives a hinge, by name of the hinge; several hinges may be driven by
            joints of the same kind. Default: all joints of the machine, on hinges of their names.
        pressures: absolute pressures in hoses A and B at the start, Pa; default: at equal leakage.

    Attributes:
        hinges: names of the driven hinges, in the order of all arrays.
        supply: absolute pressure at the valves, Pa; settable.
        brakes: torque at which each brake slips, N m, (n,); items can be set. A joint's kind of friction adds to it.

    Raises:
        InputError: a name is neither a hinge of the model nor a joint of the machine, the timestep or integrator of the
            model is no good, the machine has no valve, or MuJoCo is not installed.
    """

    def __init__(
        self,
        model: Any,
        machine: Machine,
        joints: Mapping[str, str] | None = None,
        *,
        pressures: tuple[float, float] | None = None,
    ) -> None:
        self._mj, self._model = engine(), model
        self._cycle = machine.cycle
        laws = dict(zip(machine.joints, parameters.joints(machine), strict=True))
        driven = {name: name for name in laws} if joints is None else dict(joints)
        self.hinges = tuple(driven)
        healthy = tuple(laws[_known(name, list(laws), machine)] for name in driven.values())
        n, air = len(driven), parameters.surroundings(machine)
        super().__init__(healthy, np.array(air, dtype=np.float64), model.opt.timestep)
        ids = [_hinge(self._mj, model, name) for name in driven]
        self._at = np.array([model.jnt_qposadr[ids], model.jnt_dofadr[ids]])
        self._span = _span(self._mj, model, self._cycle)
        filled = FILLED * air.supply_pressure
        self._pressures = (filled, filled) if pressures is None else pressures
        self._brakes = Brakes(model, self._at[1])
        self.brakes = np.array([joint.brake_torque for joint in self._healthy])
        self._kick, self._extrapolated = np.zeros((5, n)), np.zeros(model.nv)
        self._due = 0.0
        self._rest(model.qpos0[self._at[0]])
        self._like: Carry = self._at_rest(0, 0.0)
        self._laws = np.array([list(leaves(joint)) for joint in self._healthy])
        self._kernels = halves_of(self._healthy[0], self._like)
        self._compile()
        self._fresh = True

    @property
    def torques(self) -> Array:
        """Torques of air, losses, stops and bearings in the last step, without the brakes', N m, (n,)."""
        return np.copy(self._kick[2])

    @property
    def ledgers(self) -> list[Ledger]:
        """Works of each joint since the start."""
        return [read_numbers(self._like, row).state.ledger for row in self._kept]

    def reset(self, data: Any) -> None:
        """Begin anew at the angles in an MjData: hoses at rest, filled as at first; the first step does so."""
        self._rest(data.qpos[self._at[0]])
        self._brakes.forget()
        self._fresh = False

    def drive(self, voltages: Array) -> None:
        """Give the valves' drivers voltages (V, (n,)), which hold until the next.

        Where the valves' delay counts control cycles, every call in a new instant counts as one; without calls, time.
        """
        self._voltages[:] = voltages
        self._new = True

    def step(self, data: Any) -> None:
        """Advance an MjData by a timestep of the model, as `mj_step` does, with these joints.

        Raises:
            DivergedError: model or joints diverged.
        """
        if self._fresh:
            self.reset(data)
        mj, model, time = self._mj, self._model, data.time
        self._command(time)
        mj.mj_step1(model, data)
        self._span[0], given, kick = time, data.qfrc_applied.copy(), self._kick
        laws = self._laws, self._kept, self._around, self._span, self._at, data.qpos, data.qvel
        self._kernels.push(*laws, data.qfrc_applied, self.load, self.brakes, kick)
        self._extrapolate(data)
        braked = self._brakes.apply(data, kick[3:])
        mj.mj_step2(model, data)
        data.qfrc_applied[:] = given
        diverged = self._kernels.settle(*laws, kick, braked, self.load, self._holes, self._seen)
        # MuJoCo starts again at time zero where its accelerations leave all meaning.
        if diverged >= 0 or data.time <= time:
            raise DivergedError(time, self.hinges[diverged if diverged >= 0 else int(np.argmax(np.abs(kick[1])))])

    def sense(self, noise: Array) -> tuple[Array, Array]:
        """Angles (rad) and differential pressures (Pa) as the converters report them, (n,).

        Args:
            noise: standard normal samples of angle and pressure sensors, (n, 2).
        """
        out = np.empty((2, len(self.hinges)))
        self._kernels.sample(self._laws, self._seen, noise, out)
        return out[0], out[1]

    def _extrapolate(self, data: Any) -> None:
        """Add what Coriolis and centrifugal forces change by where velocities go on by half of their last change.

        MuJoCo takes them at the start of a step, which alone would make the step one of first order. The velocities in
        the data are extrapolated; they are taken back.
        """
        mj, model = self._mj, self._model
        mj.mj_comVel(model, data)
        mj.mj_rne(model, data, 0, self._extrapolated)
        extrapolate(self._at[1], self._kick[1], data.qfrc_bias, self._extrapolated, data.qfrc_applied, data.qvel)
        mj.mj_comVel(model, data)

    def _write_joints(self) -> None:
        self._laws[:] = [list(leaves(joint)) for joint in self._joints_now()]

    def _command(self, time: float) -> None:
        # Who drives in every cycle, but not to the instant, counts once a cycle; who stops is held.
        if self._new or time >= self._due:
            self._due = time + (1.5 if self._new else 1.0) * self._cycle - 0.5 * self._model.opt.timestep
            self._new = False
            self._kernels.command(self._laws, self._kept, self._voltages, self._cycle)

    def _at_rest(self, j: int, angle: float) -> Carry:
        joint, air = self._healthy[j], Surroundings(*self._around)
        state = joint_at_rest(joint, angle, *self._pressures, air)
        if j in self._seized:
            state = state._replace(valve=held_at(joint.valve, self._seized[j]))
        return Carry(state, NOTHING_ASKED, 0.0)

    def _rest(self, angles: Array) -> None:
        kept = [self._at_rest(j, float(angle)) for j, angle in enumerate(angles)]
        self._kept = np.array([list(leaves(one)) for one in kept])
        self._seen[:] = [Outputs(float(angle), 0.0, *self._pressures) for angle in angles]
        self._new = True

    def _compile(self) -> None:
        """Now, not while a clock runs."""
        n = len(self.hinges)
        kept, seen, at, nothing = self._kept.copy(), self._seen.copy(), np.zeros_like(self._at), np.zeros(n)
        laws, kick = (self._laws, kept, self._around, self._span, at, np.zeros(n), np.zeros(n)), np.zeros((5, n))
        self._kernels.command(self._laws, kept, self._voltages, self._cycle)
        self._kernels.push(*laws, np.zeros(n), nothing, nothing, kick)
        extrapolate(at[1], nothing, nothing, nothing, np.zeros(n), np.zeros(n))
        self._kernels.settle(*laws, kick, kick[:2], nothing, self._holes, seen)
        self.sense(np.zeros((n, 2)))


def _known(name: str, names: list[str], machine: Machine) -> str:
    if name not in names:
        raise InputError(
            f"{name!r} is not a joint of {machine.origin}", where="joints", right=f"joints are {', '.join(names)}"
        )
    return name


def _hinge(mj: Any, model: Any, name: str) -> int:
    hinges = [i for i in range(model.njnt) if model.jnt_type[i] == mj.mjtJoint.mjJNT_HINGE]
    found = mj.mj_name2id(model, mj.mjtObj.mjOBJ_JOINT, name)
    if found not in hinges:
        names = [model.joint(i).name for i in hinges if model.joint(i).name]
        raise InputError(
            f"{name!r} is not a hinge of the model", where="joints", right=f"hinges are {', '.join(names) or 'none'}"
        )
    return int(found)


def _span(mj: Any, model: Any, cycle: float) -> Array:
    """Numbers of a `Span` for the model's timestep."""
    H = model.opt.timestep
    if not SHORTEST <= H <= cycle:
        raise InputError(
            f"{H:g} s is out of range", where="option.timestep of the model", right=f"give 1 us to {cycle:g} s"
        )
    if model.opt.integrator == mj.mjtIntegrator.mjINT_RK4:
        raise InputError(
            "RK4 steps several times in one", where="option.integrator of the model", right="give Euler or implicitfast"
        )
    steps = ceil(H / STEP - 1e-9)
    # An odd number, so that one is in the middle.
    steps += 1 - steps % 2
    return np.array([0.0, H / steps, (steps - 1) // 2])
