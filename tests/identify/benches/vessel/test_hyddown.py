from math import pi
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.benches.loader import load_bench
from layflat.physics.flow import sonic_conductance

RIG = """
vessel: {length: 1.0, diameter: 0.2, thickness: 0.01, density: 7800.0, heat_capacity: 500, orientation: vertical}
initial: {fluid: N2, pressure: 10.0e5, temperature: 290.0}
valve: {flow: discharge, type: orifice, diameter: 0.003, discharge_coef: 0.8, back_pressure: 101300.0}
heat_transfer: {type: specified_h, h_outer: 5, h_inner: calc, temp_ambient: 295.0}
"""


def rig_file(folder: Path, text: str = RIG) -> Path:
    path = folder / "mine.rig.yml"
    path.write_text(text)
    return path


def test_a_rig_is_read_with_its_wall(tmp_path: Path) -> None:
    rig = load_bench(rig_file(tmp_path))
    assert (rig.name, rig.gas.name) == ("mine", "nitrogen")
    assert rig.space.volume == pytest.approx(pi / 4 * 0.04)
    assert rig.space.area == pytest.approx(pi * 0.2 + pi / 2 * 0.04)
    shell = pi / 4 * (0.22**2 * 1.02 - 0.04)
    assert rig.wall.heat_capacity == pytest.approx(shell * 7800.0 * 500.0)
    assert rig.wall.outer_conductance == pytest.approx(5.0 * (pi * 0.22 * 1.02 + pi / 2 * 0.22**2))
    assert rig.path.conductance == pytest.approx(sonic_conductance(pi / 4 * 9e-6, 0.8))
    assert (rig.outside.pressure, rig.ambient.temperature, rig.start.temperature) == (101300.0, 295.0, 290.0)


def test_round_ends_and_control_valves(tmp_path: Path) -> None:
    round_ends = RIG.replace("orientation: vertical", "type: hemispherical")
    assert load_bench(rig_file(tmp_path, round_ends)).space.volume == pytest.approx(pi / 4 * 0.04 + pi / 6 * 0.008)
    valve = RIG.replace("type: orifice, diameter: 0.003, discharge_coef: 0.8", "type: controlvalve, Cv: 2")
    rig = load_bench(rig_file(tmp_path, valve))
    # IEC 60534-2-1: choked air, 1 bar and 1.185 kg/m3, x_T = 0.7, in kg/h.
    flow = 27.3 * 2.0 * (2.0 / 3.0) * np.sqrt(0.7 * 1.0 * 1.185) / 3600.0
    assert rig.path.conductance == pytest.approx(flow / 1.185 / 1e5, rel=0.01)
    assert rig.path.hole is None


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("fluid: N2", "fluid: steam", "initial.fluid: 'steam' is an unknown gas; use air, argon"),
        ("diameter: 0.2,", "", "vessel.diameter: None is not a number"),
        (
            "discharge_coef: 0.8",
            "discharge_coef: x",
            "valve.discharge_coef: 'x' is not a number; give a number in SI units",
        ),
        ("type: orifice", "type: mdot", "valve.type: 'mdot' has no conductance"),
        ("initial:", "first:", "has no initial"),
        ("orientation: vertical", "type: cube", "vessel.type: 'cube' is not known"),
        ("vessel: {", "vessel: {{", "can't be read"),
        ("pressure: 10.0e5", "pressure: -1", "start.pressure"),
    ],
)
def test_a_field_that_cannot_be_used_is_one_line(old: str, new: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        load_bench(rig_file(tmp_path, RIG.replace(old, new)))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="can't be read"):
        load_bench(tmp_path / "none.yml")
