"""Fittings of air and of the angle's sensor: push-in fittings, hollow screws for hose inlets, potentiometer.

Threads are of ISO 228-1 (G1/8, G1/4; they seal on a face) and of ISO 261 (M5). Outer sizes are typical of makers' data
sheets: leave a margin around them. Masses are computed volumes times the density of brass.
"""

from dataclasses import dataclass
from math import pi

from layflat.errors import DesignError
from layflat.solids.standard.materials import MATERIALS
from layflat.solids.standard.screws import HEXAGON_AREA

RING_SHARE = 0.5  # filled share of a push-in head, whose collet and release ring are of plastic


@dataclass(frozen=True)
class Port:
    """Thread of a port for air, m."""

    name: str  # such as "G1/8"
    diameter: float  # outer, of the thread
    pitch: float
    tapping_hole: float
    depth: float  # of the thread in a port (ISO 16030)
    bore: float  # of a hollow screw
    flats: float  # across the flats of its hexagon
    flange: float  # diameter of the sealing face


AIR_PORTS = {
    port.name: port
    for port in (
        Port("M5", 5e-3, 0.8e-3, 4.2e-3, 4.5e-3, 2.5e-3, 8e-3, 9e-3),
        Port("G1/8", 9.728e-3, 0.907e-3, 8.8e-3, 7.5e-3, 5.5e-3, 13e-3, 14e-3),
        Port("G1/4", 13.157e-3, 1.337e-3, 11.8e-3, 10.5e-3, 8e-3, 17e-3, 18e-3),
    )
}
"""Known ports by name."""

TUBE_SIZES = {  # outer and inner diameter of tubing that a port's fitting takes, m
    "M5": ((4e-3, 2.6e-3), (6e-3, 4e-3)),
    "G1/8": ((4e-3, 2.6e-3), (6e-3, 4e-3), (8e-3, 5.7e-3)),
    "G1/4": ((6e-3, 4e-3), (8e-3, 5.7e-3), (10e-3, 7e-3)),
}


@dataclass(frozen=True)
class PushInFitting:
    """Straight push-in fitting with a male thread."""

    port: Port
    tube_outer: float  # m
    tube_inner: float  # m

    @property
    def designation(self) -> str:
        """Designation, such as "push-in fitting G1/8 - 6"."""
        return f"push-in fitting {self.port.name} - {self.tube_outer * 1e3:g}"

    @property
    def body_diameter(self) -> float:
        """Outer diameter of the head, m: typical of data sheets."""
        return self.tube_outer + 6e-3

    @property
    def body_length(self) -> float:
        """Length above the sealing face, m: typical of data sheets."""
        return 2 * self.tube_outer + 9e-3

    @property
    def mass(self) -> float:
        """Mass, kg."""
        head = RING_SHARE * pi / 4 * (self.body_diameter**2 - self.tube_outer**2) * self.body_length
        return MATERIALS["brass"].density * (head + _thread_volume(self.port))


@dataclass(frozen=True)
class HollowScrew:
    """Hollow screw with a hexagon head, through whose bore air enters a hose; a nut inside clamps the hose's wall."""

    port: Port
    grip: float  # clamped thickness, m

    @property
    def length(self) -> float:
        """Length below the head, m: the clamped thickness and the thread of its nut."""
        return self.grip + self.port.depth

    @property
    def head_height(self) -> float:
        """Height of the head, m: two thirds of the thread's diameter, as a screw's (ISO 4017)."""
        return 2 / 3 * self.port.diameter

    @property
    def designation(self) -> str:
        """Designation, such as "hollow screw G1/8 x 12 - brass"."""
        return f"hollow screw {self.port.name} x {self.length * 1e3:.3g} - brass"

    @property
    def mass(self) -> float:
        """Mass, kg, with its nut."""
        port = self.port
        hexagon = HEXAGON_AREA * port.flats**2
        head = (hexagon - pi / 4 * port.bore**2) * self.head_height
        nut = (hexagon - pi / 4 * port.diameter**2) * port.depth
        shank = _thread_volume(port) / port.depth * self.length
        return MATERIALS["brass"].density * (head + nut + shank)


def _thread_volume(port: Port) -> float:
    """Return the volume of a hollow thread of a port's depth, m3."""
    mean = port.diameter - 0.64 * port.pitch
    return pi / 4 * (mean**2 - port.bore**2) * port.depth


def port(name: str) -> Port:
    """Return a known port; raise DesignError for an unknown one, with the list of the known."""
    if name not in AIR_PORTS:
        raise DesignError(f"unknown port {name!r}", where="fitting", right=f"known are {', '.join(AIR_PORTS)}")
    return AIR_PORTS[name]


def push_in_fitting(name: str, tube_outer: float) -> PushInFitting:
    """Return the straight fitting of a port, such as G1/8, for tubing of an outer diameter (m).

    Raises:
        DesignError: the port is unknown, or has no fitting for this tubing.
    """
    thread = port(name)
    for outer, inner in TUBE_SIZES[name]:
        if abs(outer - tube_outer) < 1e-6:
            return PushInFitting(thread, outer, inner)
    known = ", ".join(f"{outer * 1e3:g}" for outer, _ in TUBE_SIZES[name])
    what = f"no fitting {name} takes tubing of {tube_outer * 1e3:.4g} mm"
    raise DesignError(what, where="fitting", right=f"tubing of {name} is {known} mm")


@dataclass(frozen=True)
class Potentiometer:
    """Potentiometer of conductive plastic with a servo mount, m."""

    designation: str
    body_diameter: float
    body_length: float  # behind the mounting face
    pilot_diameter: float  # that centres it in its plate
    pilot_height: float
    shaft_diameter: float
    shaft_length: float  # from the mounting face
    mass: float  # kg
    source: str


ANGLE_SENSOR = Potentiometer(
    designation="potentiometer 22 mm, conductive plastic, servo mount, shaft 6 mm",
    body_diameter=22.2e-3, body_length=15e-3, pilot_diameter=19.05e-3, pilot_height=1.6e-3,
    shaft_diameter=6e-3, shaft_length=16e-3, mass=22e-3,
    source="data sheets of 7/8 inch precision potentiometers",
)  # fmt: skip
"""Sensor of a joint's angle."""
