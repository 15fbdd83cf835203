"""Control law of a rig's joints in the form of its loop: settings, memory and report as rows of numbers by name."""

from collections.abc import Sequence

import numpy as np

from layflat.control import CONTROL_LAWS, Demand, Sensed, step, wake
from layflat.description.change import changed_all
from layflat.errors import KindError
from layflat.jit.outside import blame_outside
from layflat.lanes import leaves
from layflat.machine import Machine, parameters
from layflat.rig.named import NamedRows, zero_tuple
from layflat.rig.record import RowLayout

PROBE_DEMANDS = (
    0.0,
    0.2,
    0.2,
    -0.2,
    -0.2,
    0.0,
)  # demands, rad, by which a law at rest shows whether it commands shares


def adapt_to_rig(machine: Machine, late: int = 0) -> Machine:
    """Return the machine as a control law has to model it on a rig.

    Its `valve.dither.min` is 1, as the device never stops the dither. For laws that plan their motion, the delay of the
    valve is longer by `late` control cycles, after which commands arrive. A machine without a valve stays.
    """
    if machine.valve is None:
        return machine
    changes: dict[str, float] = {}
    if machine.valve.dithered is not None:
        changes["valve.dither.min"] = 1.0
    if late and machine.controller is not None and machine.control_law.plans:
        changes["valve.delay"] = machine.valve.delay + late * machine.cycle
    return changed_all(machine, changes) if changes else machine


class ArmLaw:
    """Control law of the whole arm; its commands reach the device `late` control cycles after they are written.

    Raises:
        MachineError: the machine has no controller, or a joint lacks gains.
        KindError: the law commands fractions of brake, dither or supply, which no driver of a rig sets.
    """

    def __init__(self, machine: Machine, late: int = 0) -> None:
        machine = adapt_to_rig(machine, late)
        settings, nothing = parameters.control(machine), (0.0,) * len(machine.joints)
        self.kind = CONTROL_LAWS.kind_of(settings)
        with blame_outside():
            memory = tried = wake(settings, Sensed(nothing, nothing))
            for angle in PROBE_DEMANDS:
                demand = Demand((angle,) * len(nothing), nothing, nothing, nothing)
                tried, command, _ = step(settings, tried, Sensed(nothing, nothing), demand, machine.cycle)
                given = next((s for shares in command.shares for s in shares._asdict().items() if s[1] != 1.0), None)
                if given is not None:
                    what = f"control law {self.kind.name!r} commands a fraction of the {given[0]}, which no rig sets"
                    raise KindError(what, where=machine.origin, right="command fractions of 1 on a rig")
        self.settings_as_given = settings
        self.settings, self.memory = NamedRows([settings]), NamedRows([memory])
        self.report = NamedRows([zero_tuple(self.kind.report)] * len(nothing))
        self.layout = RowLayout.for_machine(machine)  # of the rows that a loop with it records
        # Columns of its report that stand in these rows.
        self.recorded = np.array([i for i, name in enumerate(self.kind.signals) if name in dict(self.layout.law)])

    def wake(self, angles: Sequence[float], pressures: Sequence[float]) -> None:
        """Initialize the memory with measured angles, rad, and differential pressures, Pa, (joints,) each."""
        with blame_outside():
            memory = wake(self.settings_as_given, Sensed(tuple(angles), tuple(pressures)))
            self.memory.array[0] = list(leaves(memory))
