"""Joints of layflat hose on hinges of any MuJoCo model: voltages in, angles out."""

from collections.abc import Mapping
from math import ceil
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.bridge.arm import import_mujoco
from layflat.bridge.brake import Brakes
from layflat.bridge.halves import CarriedState, extrapolate, joint_kernels
from layflat.errors import DivergedError, InputError
from layflat.lanes import leaves, read_numbers
from layflat.machine import Machine, parameters
from layflat.physics.driven import DrivenJoints, DrivenOutputs
from layflat.physics.driver import ZERO_COMMANDS
from layflat.physics.joint import REST_PRESSURE_RATIO, EnergyLedger, Surroundings, joint_at_rest
from layflat.physics.step import STEP
from layflat.physics.valves import held_at

MIN_TIMESTEP = 1e-6  # lower limit of the timestep of a model, s


class PneumaticJoints(DrivenJoints):
    """A machine's joints on hinges of a model: valves, hoses, losses, stops, brakes; `step` replaces mj_step.

    A hinge's zero has to be in the middle of its joint's stroke, and hose A turns it forward. The model's own damping,
    friction and limits of the hinges act as well. Between steps `data.qpos` of a moving hinge is half a step
    ahead of `angles` (see halves.py).

    Args:
        model: an MjModel.
        machine: the machine.
        joints: name of the machine's joint that drives a hinge, by name of the hinge; several hinges may name
            one joint, of which each is a copy. Default: all joints of the machine, on hinges of their names.
        pressures: absolute pressures in hoses A and B at the start, Pa; default: at equal leakage.

    Attributes:
        hinges: names of the driven hinges, in the order of all arrays.
        supply: absolute pressure at the valves, Pa; settable.
        brakes: torque at which each brake slips, N m, (n,); items can be set. A joint's kind of friction adds to it.

    Raises:
        InputError: a name is neither a hinge of the model nor a joint of the machine, the timestep or integrator of the
            model is not supported, the machine has no valve, or MuJoCo is not installed.
    """

    def __init__(
        self,
        model: Any,
        machine: Machine,
        joints: Mapping[str, str] | None = None,
        *,
        pressures: tuple[float, float] | None = None,
    ) -> None:
        """Check names, timestep and integrator, and compile; the first step sets the joints to rest, see `reset`."""
        self._mj, self._model = import_mujoco(), model
        self._cycle = machine.cycle
        laws = dict(zip(machine.joints, parameters.joints(machine), strict=True))
        driven = {name: name for name in laws} if joints is None else dict(joints)
        self.hinges = tuple(driven)
        healthy = tuple(laws[_check_joint_name(name, list(laws), machine)] for name in driven.values())
        n, air = len(driven), parameters.surroundings(machine)
        super().__init__(healthy, np.array(air, dtype=np.float64), model.opt.timestep)
        ids = [_hinge_index(self._mj, model, name) for name in driven]
        self._at = np.array([model.jnt_qposadr[ids], model.jnt_dofadr[ids]])
        self._span = _step_span(self._mj, model, self._cycle)
        filled = REST_PRESSURE_RATIO * air.supply_pressure
        self._pressures = (filled, filled) if pressures is None else pressures
        self._brakes = Brakes(model, self._at[1])
        self.brakes = np.array([joint.brake_torque for joint in self._healthy])
        self._kick, self._extrapolated = np.zeros((5, n)), np.zeros(model.nv)
        self._due = 0.0
        self._reset_to_rest(model.qpos0[self._at[0]])
        self._like: CarriedState = self._resting_state(0, 0.0)
        self._laws = np.array([list(leaves(joint)) for joint in self._healthy])
        self._kernels = joint_kernels(self._healthy[0], self._like)
        self._compile()
        self._fresh = True

    @property
    def torques(self) -> Array:
        """Torques of air, losses, stops and bearings in the last step, without those of the brakes, N m, (n,)."""
        return np.copy(self._kick[2])

    @property
    def ledgers(self) -> list[EnergyLedger]:
        """Works of each joint since the start."""
        return [read_numbers(self._like, row).state.ledger for row in self._state_array]

    def reset(self, data: Any) -> None:
        """Reset the joints to rest at the angles in an MjData, with the initial pressures; the first step does so."""
        self._reset_to_rest(data.qpos[self._at[0]])
        self._brakes.forget()
        self._fresh = False

    def drive(self, voltages: Array) -> None:
        """Set the voltages of the valves' drivers (V, (n,)), which hold until the next call.

        For the valves' delay, every call at a new instant counts as a control cycle; without calls, time does.
        """
        self._voltages[:] = voltages
        self._new = True

    def step(self, data: Any) -> None:
        """Advance an MjData by a timestep of the model, as `mj_step` does, with these joints.

        `data.qfrc_applied` acts as well, and is the same afterwards.

        Raises:
            DivergedError: model or joints diverged.
        """
        if self._fresh:
            self.reset(data)
        mj, model, time = self._mj, self._model, data.time
        self._command_valves(time)
        mj.mj_step1(model, data)
        self._span[0], external, kick = time, data.qfrc_applied.copy(), self._kick
        laws = self._laws, self._state_array, self._around, self._span, self._at, data.qpos, data.qvel
        self._kernels.push(*laws, data.qfrc_applied, self.load, self.brakes, kick)
        self._extrapolate(data)
        braked = self._brakes.apply(data, kick[3:])
        mj.mj_step2(model, data)
        data.qfrc_applied[:] = external
        diverged = self._kernels.settle(*laws, kick, braked, self.load, self._holes, self._seen)
        # MuJoCo starts again at time zero where its accelerations leave all meaning.
        if diverged >= 0 or data.time <= time:
            raise DivergedError(time, self.hinges[diverged if diverged >= 0 else int(np.argmax(np.abs(kick[1])))])

    def sense(self, noise: Array) -> tuple[Array, Array]:
        """Return angles (rad) and differential pressures (Pa) as the converters report them, (n,).

        Args:
            noise: standard normal samples of angle and pressure sensors, (n, 2).
        """
        out = np.empty((2, len(self.hinges)))
        self._kernels.sample(self._laws, self._seen, noise, out)
        return out[0], out[1]

    def _extrapolate(self, data: Any) -> None:
        """Add the change of Coriolis and centrifugal forces due to velocities extrapolated by half their last change.

        MuJoCo computes them at the start of a step, which alone would reduce the step to first order. The velocities in
        the data are extrapolated before, and restored here.
        """
        mj, model = self._mj, self._model
        mj.mj_comVel(model, data)
        mj.mj_rne(model, data, 0, self._extrapolated)
        extrapolate(self._at[1], self._kick[1], data.qfrc_bias, self._extrapolated, data.qfrc_applied, data.qvel)
        mj.mj_comVel(model, data)

    def _write_joints(self) -> None:
        self._laws[:] = [list(leaves(joint)) for joint in self._joints_now()]

    def _command_valves(self, time: float) -> None:
        """Command the valves after a call of `drive`, else once a control cycle with the last voltages; time in s."""
        if self._new or time >= self._due:
            self._due = time + (1.5 if self._new else 1.0) * self._cycle - 0.5 * self._model.opt.timestep
            self._new = False
            self._kernels.command(self._laws, self._state_array, self._voltages, self._cycle)

    def _resting_state(self, j: int, angle: float) -> CarriedState:
        """Return the state of joint j at rest at an angle (rad) with initial pressures; a seized valve stays."""
        joint, air = self._healthy[j], Surroundings(*self._around)
        state = joint_at_rest(joint, angle, *self._pressures, air)
        if j in self._seized:
            state = state._replace(valve=held_at(joint.valve, self._seized[j]))
        return CarriedState(state, ZERO_COMMANDS, 0.0)

    def _reset_to_rest(self, angles: Array) -> None:
        """Reset all joints to rest at angles (rad); the next cycle commands the valves anew."""
        kept = [self._resting_state(j, float(angle)) for j, angle in enumerate(angles)]
        self._state_array = np.array([list(leaves(one)) for one in kept])
        self._seen[:] = [DrivenOutputs(float(angle), 0.0, *self._pressures) for angle in angles]
        self._new = True

    def _compile(self) -> None:
        """Compile the kernels, so that the first step does not."""
        n = len(self.hinges)
        kept, seen, at, nothing = self._state_array.copy(), self._seen.copy(), np.zeros_like(self._at), np.zeros(n)
        laws, kick = (self._laws, kept, self._around, self._span, at, np.zeros(n), np.zeros(n)), np.zeros((5, n))
        self._kernels.command(self._laws, kept, self._voltages, self._cycle)
        self._kernels.push(*laws, np.zeros(n), nothing, nothing, kick)
        extrapolate(at[1], nothing, nothing, nothing, np.zeros(n), np.zeros(n))
        self._kernels.settle(*laws, kick, kick[:2], nothing, self._holes, seen)
        self.sense(np.zeros((n, 2)))


def _check_joint_name(name: str, names: list[str], machine: Machine) -> str:
    """Return the name, or raise InputError unless it is among the names of the machine's joints."""
    if name not in names:
        raise InputError(
            f"{name!r} is not a joint of {machine.origin}", where="joints", right=f"joints are {', '.join(names)}"
        )
    return name


def _hinge_index(mj: Any, model: Any, name: str) -> int:
    """Return the index of a named joint of the model, or raise InputError if it is not a hinge."""
    hinges = [i for i in range(model.njnt) if model.jnt_type[i] == mj.mjtJoint.mjJNT_HINGE]
    index = mj.mj_name2id(model, mj.mjtObj.mjOBJ_JOINT, name)
    if index not in hinges:
        names = [model.joint(i).name for i in hinges if model.joint(i).name]
        raise InputError(
            f"{name!r} is not a hinge of the model", where="joints", right=f"hinges are {', '.join(names) or 'none'}"
        )
    return int(index)


def _step_span(mj: Any, model: Any, cycle: float) -> Array:
    """Return the numbers of a `StepSpan` for a model and control cycle (s), its time zero.

    Raises:
        InputError: the timestep is below `MIN_TIMESTEP` or above the cycle, or the integrator is RK4.
    """
    H = model.opt.timestep
    if not MIN_TIMESTEP <= H <= cycle:
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
