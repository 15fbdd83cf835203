"""What machine this is: description files, validated objects, and the parameters of the laws."""

from layflat.description.change import changed
from layflat.machine.loader import build, load, names
from layflat.machine.model import Machine
from layflat.machine.parts import Joint

__all__ = ["Joint", "Machine", "build", "changed", "load", "names"]
