"""Materials of parts: density, strength and stiffness, each with the standard or class of data sheet it stands in."""

from dataclasses import dataclass

from layflat.errors import DesignError


@dataclass(frozen=True)
class Material:
    """Material in the state in which it is bought or made."""

    name: str  # in descriptions and lists
    grade: str  # designation by which it is ordered
    density: float  # kg/m3; of webbing: over width and thickness
    yield_stress: float  # Rp0.2 or yield, Pa; breaking stress of rubber and webbing
    modulus: float  # of elasticity, Pa
    source: str  # standard or class of data sheet


_MATERIAL_ROWS = (
    # name, grade, kg/m3, MPa, GPa, source
    ("aluminium", "EN AW-6082 T651", 2700, 240, 70, "EN 485-2, plate of 12.5 to 60 mm"),
    ("aluminium-sheet", "EN AW-5754 H111", 2670, 80, 70, "EN 485-2"),
    ("aluminium-tube", "EN AW-6060 T66", 2700, 150, 69.5, "EN 755-2, walls up to 25 mm"),
    ("steel-strip", "1.4310 +C1700", 7900, 1500, 190, "EN 10151 (T301, full hard)"),
    ("steel", "S235JR", 7850, 235, 210, "EN 10025-2"),
    ("shaft-steel", "C45 +QT", 7850, 490, 210, "ISO 683-1, up to 16 mm; 430 MPa up to 40 mm"),
    ("stainless-steel", "1.4301", 7900, 190, 200, "EN 10088-3"),
    ("screw-steel", "A2-70", 7900, 450, 200, "ISO 3506-1"),
    ("bearing-steel", "100Cr6", 7810, 1700, 210, "ISO 683-17"),
    ("spring-steel", "EN 10270-1 SH", 7850, 1500, 206, "EN 10270-1, wire of about 2 mm"),
    ("brass", "CW614N", 8470, 250, 97, "EN 12164, R430"),
    ("POM", "POM-C", 1410, 65, 2.8, "data sheets of rods and plates"),
    ("PA6", "PA6, conditioned", 1140, 45, 1.4, "data sheets of rods and plates; brake pads"),
    ("PETG", "PETG, printed", 1270, 30, 2.0, "data sheets of filament, across the layers"),
    ("PLA", "PLA, printed", 1240, 35, 3.0, "data sheets of filament, across the layers"),
    ("polyurethane", "PUR 98 Shore A", 1200, 25, 0.1, "data sheets of tubing"),
    ("rubber", "NR 60 Shore A", 1100, 15, 0.0045, "data sheets of bump stops; modulus for 60 IRHD"),
    ("webbing", "polyester webbing", 1000, 300, 3.0, "data sheets of lashing webbing, EN 12195-2"),
    ("hose", "PVC-nitrile on polyester", 1250, 50, 0.5, "data sheets of layflat hose, ISO 1403"),
)

MATERIALS = {
    row[0]: Material(row[0], row[1], float(row[2]), row[3] * 1e6, row[4] * 1e9, row[5]) for row in _MATERIAL_ROWS
}
"""Known materials by name."""


def material(name: str) -> Material:
    """Return a known material.

    Raises:
        DesignError: the material is unknown; the message lists the known ones.
    """
    if name not in MATERIALS:
        raise DesignError(f"unknown material {name!r}", where="material", right=f"known are {', '.join(MATERIALS)}")
    return MATERIALS[name]
