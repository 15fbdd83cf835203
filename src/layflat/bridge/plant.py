"""Plant of a machine whose arm moves in MuJoCo; sim/plant.py is that with the arm of the package."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from layflat.arrays import Array
from layflat.bridge.arm import arm_spec, import_mujoco
from layflat.bridge.joints import PneumaticJoints
from layflat.description import units as u
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.physics.driven import MachinePlant
from layflat.physics.sensor import noise_samples

Value = str | float
Advance = Callable[[Any], None]  # advances an MjData by a timestep, in place of `mj_step`


class MujocoPlant(PneumaticJoints, MachinePlant):
    """Plant of a machine in MuJoCo, initially at rest: set voltages, advance the time, read the sensors.

    Args:
        machine: the machine.
        model: an MjModel that contains its arm; default: the arm alone.
        data: MjData of that model, at whose angles it begins; default: a new one.
        joints: names of all the machine's joints by those of their hinges; default: hinges have the joints' names.
        start: initial angles of the joints (rad, or text with a unit), one for all or one a joint; default: those of
            `data`.
        pressures: initial absolute pressures of the hoses A and B (Pa, or text with a unit); default: at equal leakage.
        seed: seed of the sensors' noise; None: no noise.
        step: performs a timestep; it gets a function that advances an MjData by one with the joints, and may act before
            and after.

    Attributes:
        model: the MjModel.
        data: the MjData; to read bodies, call `mj_kinematics` or `mj_forward` first, as after any `mj_step`.

    Raises:
        InputError: as `PneumaticJoints`; the hinges are not those of all the machine's joints; `start` or `pressures`
            are wrong.
    """

    def __init__(
        self,
        machine: Machine,
        model: Any = None,
        data: Any = None,
        *,
        joints: Mapping[str, str] | None = None,
        start: Value | Sequence[Value] | None = None,
        pressures: tuple[Value, Value] | None = None,
        seed: int | None = 0,
        step: Callable[[Advance], object] | None = None,
    ) -> None:
        """Make what is not given, write the initial angles into the data, and set the joints to rest there."""
        self.model = arm_spec(machine).compile() if model is None else model
        self.data = import_mujoco().MjData(self.model) if data is None else data
        filled = None if pressures is None else _read_pressures(pressures)
        super().__init__(self.model, machine, _order_hinges(machine, joints), pressures=filled)
        self.joints = tuple(machine.joints)
        self._advance, n = step or (lambda advance: advance(self.data)), len(self.joints)
        if start is not None:
            values = [start] * n if isinstance(start, (str, int, float)) else list(start)
            if len(values) != n:
                raise InputError(
                    f"has {len(values)} values", where="start", right=f"give {n}: {', '.join(self.joints)}"
                )
            for hinge, value in zip(self.hinges, values, strict=True):
                self.data.joint(hinge).qpos[0] = u.quantity(value, u.ANGLE, "start")
        self.reset(self.data)
        self._own = self.brakes.copy()
        self._noise = noise_samples(seed, n)

    @property
    def time(self) -> float:
        """Time to which it has been advanced, s."""
        return float(self.data.time)

    @property
    def payload(self) -> float:
        """Mass of the body "payload", kg; settable. Zero where the model has none, and then not settable."""
        body = self._payload()
        return float(self.model.body_mass[body]) if body >= 0 else 0.0

    @payload.setter
    def payload(self, mass: float) -> None:
        body = self._payload()
        if body < 0:
            raise InputError(
                "the model has no such body", where="payload", right="add a body named 'payload' at the tip"
            )
        if mass == self.payload:
            return
        self.model.body_mass[body] = mass
        # Updates constants that depend on masses, in another MjData, since it would reset this one.
        self._mj.mj_setConst(self.model, self._mj.MjData(self.model))

    def advance(self, until: float) -> None:
        """Advance to the last whole step up to `until` (s), if ahead; raise DivergedError if the machine diverged."""
        # A deadline that is a whole number of steps may be a hair short of it.
        for _ in range(int((until - self.time) / self.model.opt.timestep + 1e-3)):
            self._advance(self.step)

    def sense(self, noise: Array | None = None) -> tuple[Array, Array]:
        """Return angles (rad) and differential pressures (Pa) as the converters report them now, (joints,).

        Args:
            noise: as in `PneumaticJoints.sense`; default: the next samples of the seed.
        """
        return super().sense(next(self._noise) if noise is None else noise)

    def grip(self, joint: int, torque: float) -> None:
        """Set the torque (N m) that is added to that at which a joint's brake slips; 0 leaves the brake's own."""
        self.brakes[joint] = self._own[joint] + torque

    def _payload(self) -> int:
        return int(self._mj.mj_name2id(self.model, self._mj.mjtObj.mjOBJ_BODY, "payload"))


def _order_hinges(machine: Machine, joints: Mapping[str, str] | None) -> Mapping[str, str] | None:
    """Return the joint by hinge in the order of the machine's joints; None for None.

    Raises:
        InputError: a joint has no hinge, or several.
    """
    if joints is None:
        return None
    if sorted(joints.values()) != sorted(machine.joints):
        raise InputError(
            f"are {', '.join(joints.values())}",
            where="joints",
            right=f"give one hinge for each of {', '.join(machine.joints)}",
        )
    hinges = {name: hinge for hinge, name in joints.items()}
    return {hinges[name]: name for name in machine.joints}


def _read_pressures(values: tuple[Value, Value]) -> tuple[float, float]:
    """Return two absolute pressures in Pa; raise InputError unless both are above vacuum."""
    a, b = (u.quantity(value, u.PRESSURE, "pressures") for value in values)
    if min(a, b) <= 0.0:
        raise InputError(f"{min(a, b):g} Pa is not above vacuum", where="pressures", right='give absolute "3.5 bar"')
    return a, b
