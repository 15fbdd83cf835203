"""Materials of parts."""

import pytest

from layflat.errors import DesignError
from layflat.solids.standard.materials import MATERIALS, material


def test_an_unknown_material_lists_the_known_ones_in_one_line() -> None:
    with pytest.raises(
        DesignError, match=r"unknown material 'unobtainium'; known are aluminium, .*steel.*webbing"
    ) as e:
        material("unobtainium")
    assert "\n" not in str(e.value)


@pytest.mark.parametrize("name", MATERIALS)
def test_every_material_has_a_source_and_yields_far_below_its_modulus(name: str) -> None:
    entry = material(name)
    assert entry.name == name
    assert entry.source
    assert 800 < entry.density < 9000
    if name != "rubber":
        assert entry.yield_stress < 0.3 * entry.modulus


def test_metals_have_the_density_and_stiffness_of_textbooks() -> None:
    # Eurocodes 9 and 3: aluminium 2700 kg/m3 and 70 GPa; steel 7850 kg/m3 and 210 GPa
    assert (material("aluminium").density, material("aluminium").modulus) == (2700, 70e9)
    assert (material("steel").density, material("steel").modulus) == (7850, 210e9)
