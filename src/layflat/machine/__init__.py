"""What machine this is: description files, validated objects, and the parameters of the laws."""

from layflat.description.change import changed
from layflat.machine.loader import load, names
from layflat.machine.model import Machine, build
from layflat.machine.parts import Joint

__all__ = ["Joint", "Machine", "build", "changed", "load", "names"]
