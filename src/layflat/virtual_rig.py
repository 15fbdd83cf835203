"""Virtual rigs: the one place where a simulated plant is put behind the interface of a real rig."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from layflat.machine import Machine
    from layflat.rig.clock import LoopClock
    from layflat.rig.device.virtual import VirtualDevice
    from layflat.rig.driver import Driver

SIMULATED_ADDRESS = "simulated"  # address of a virtual rig in the loop's own process


@dataclass(frozen=True)
class VirtualRig:
    """Factory of a virtual device with a simulated machine behind it; it can be pickled and called in any process."""

    machine: "Machine"  # what is simulated
    seed: int = 0  # of the sensors' noise
    filled: bool = False  # with air from the start, as a simulated run, instead of switched off and empty

    def __call__(self, clock: "LoopClock") -> "VirtualDevice":
        """Return a device on a clock."""
        from layflat.rig.device.virtual import VirtualDevice  # noqa: PLC0415
        from layflat.sim.plant import SteppedPlant  # noqa: PLC0415

        ambient = self.machine.supply.ambient_pressure
        plant = SteppedPlant(self.machine, seed=self.seed, pressures=None if self.filled else (ambient, ambient))
        return VirtualDevice(self.machine, plant, clock, running=self.filled)


def simulated_rig(machine: "Machine") -> "Driver":
    """Return the driver of a virtual rig in the same process, by the computer's clock, switched off and without air."""
    from layflat.rig.clock import MonotonicClock  # noqa: PLC0415
    from layflat.rig.device.virtual import SimulatedDriver  # noqa: PLC0415

    return SimulatedDriver(VirtualRig(machine)(MonotonicClock()))
