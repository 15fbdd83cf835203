"""A device in the same process: nothing on the way, so that a voltage acts from the instant it is written."""

import numpy as np

from layflat.rig.device.link import Spoil
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import Capabilities, Command, Driver, Lifecycle, LinkError, Reading


class SimulatedDriver(Driver):
    """Driver of a virtual rig at hand, whose clock should be the loop's."""

    def __init__(self, device: VirtualDevice) -> None:
        super().__init__()
        self.device = device

    def read(self) -> Reading:
        """Return the present readings of the sensors; raise LinkError if the link was told to fail."""
        spoilt = self.device.link.next()
        if spoilt is not None:
            raise LinkError("lost" if spoilt is Spoil.LATE else spoilt.value)
        return self.device.reading()

    def write(self, command: Command) -> None:
        """Obeyed at once; raise DriverError if the driver is not active."""
        self._expect("write", Lifecycle.ACTIVE)
        self._send(command)

    def _send(self, command: Command) -> None:
        if not self.device.link.silent:
            self.device.obey(command)

    def _configure(self) -> Capabilities:
        return self.device.capabilities

    def _deactivate(self) -> None:
        limits = self.device.capabilities
        self._send(Command(np.full(limits.joints, limits.centre_voltage), air=False))
