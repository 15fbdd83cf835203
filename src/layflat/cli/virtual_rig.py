"""The virtual rig: the one place where a simulated plant is put behind the interface of a real one."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from layflat.machine import Machine
    from layflat.rig.clock import Clock
    from layflat.rig.device.virtual import VirtualDevice
    from layflat.rig.driver import Driver


@dataclass(frozen=True)
class VirtualRig:
    """Makes a device with a simulated machine behind it, in whatever process it is called; it can be pickled."""

    machine: "Machine"  # what is simulated
    seed: int = 0  # of the sensors' noise
    filled: bool = False  # with air from the start, as a simulated run, instead of switched off and empty

    def __call__(self, clock: "Clock") -> "VirtualDevice":
        """Make it."""
        from layflat.rig.device.virtual import VirtualDevice  # noqa: PLC0415
        from layflat.sim.plant import SteppedPlant  # noqa: PLC0415

        ambient = self.machine.supply.ambient_pressure
        plant = SteppedPlant(self.machine, seed=self.seed, pressures=None if self.filled else (ambient, ambient))
        return VirtualDevice(self.machine, plant, clock, running=self.filled)


def simulated_rig(machine: "Machine") -> "Driver":
    """Driver of a virtual rig in the same process."""
    from layflat.rig.clock import MonotonicClock  # noqa: PLC0415
    from layflat.rig.drivers.simulated import SimulatedDriver  # noqa: PLC0415

    return SimulatedDriver(VirtualRig(machine)(MonotonicClock()))
