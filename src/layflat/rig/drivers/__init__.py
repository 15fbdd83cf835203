"""Drivers of rigs that are wired to this machine, by address."""

from layflat.rig.drivers.address import driver_of

__all__ = ["driver_of"]
