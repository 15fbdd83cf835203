"""Masses of solids against an independent reader of their triangles, and in a description that is written."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from layflat import extras
from layflat.description.change import value_at
from layflat.machine import load
from layflat.physics.arms.bodies import inertia_matrix, lump_bodies
from layflat.solids.assembly import assemble
from layflat.solids.checks.frames import belongs_to_link
from layflat.solids.checks.masses import mass_changes, mass_findings, mass_rows, write_masses
from layflat.solids.checks.meshes import MeshStore
from tests.solids.checks.builds import built

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")


def test_mass_of_joint_and_link_is_that_of_their_parts() -> None:
    assembly, values = built(), mass_changes(built())
    total = sum(assembly.mass_of(one) * one.quantity for one in assembly.components if "foot" not in one.tags)
    together = values["joint.small.body.mass"] + values["joint.small.link.mass"]
    assert together == pytest.approx(total, rel=1e-3)


def test_a_links_centre_and_inertia_are_those_of_its_triangles() -> None:
    trimesh = pytest.importorskip("trimesh")
    assembly, store = built("single-joint-lift"), MeshStore()
    link = [one for one in assembly.components if belongs_to_link(one)]
    assert {"strut 1", "screw of a strut", "tool flange"} <= {one.name for one in link}
    bodies = []
    for one in link:
        for mesh in store.parts([one]):
            count = len(mesh.triangles)
            solid = trimesh.Trimesh(1e-3 * mesh.triangles.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))
            solid.density = assembly.mass_of(one) / solid.volume
            bodies.append((assembly.mass_of(one), np.array(solid.center_mass), np.array(solid.moment_inertia)))
    mass, centre, inertia = lump_bodies(bodies)
    (axes, origin), values = _pose(), mass_changes(assembly)
    assert values["arm.link.small.mass"] == pytest.approx(mass, rel=1e-3)
    assert values["arm.link.small.centre"] == pytest.approx(axes.T @ (centre - origin), abs=2e-4)
    turned = axes.T @ inertia @ axes
    assert inertia_matrix(values["arm.link.small.inertia"]) == pytest.approx(turned, abs=1e-2 * turned.max())


def _pose() -> tuple[np.ndarray, np.ndarray]:
    """Return axes and origin (m) of the link of single-joint-lift: turned about -y, 500 mm up, as its file says."""
    return np.eye(3), np.array([0.0, 0.0, 0.5])


def test_the_rotors_inertia_does_not_hang_on_the_angle() -> None:
    assembly = built()
    turned = assemble(assembly.machine, [0.8])
    path = "joint.small.link.rotor_inertia"
    assert mass_changes(turned)[path] == pytest.approx(mass_changes(assembly)[path], rel=1e-3)


@pytest.mark.parametrize("name", ["paper-small-joint", "single-joint-lift"])
def test_a_written_description_has_the_masses_and_says_where_from(name: str, tmp_path: Path) -> None:
    assembly, path = built(name), tmp_path / "own.toml"
    values = mass_changes(assembly)
    written = write_masses(assembly, path)
    again = load(path)
    assert again == written
    for key, value in values.items():
        assert (
            value_at(again, key)[: len(value)] == value if isinstance(value, tuple) else value_at(again, key) == value
        )
        assert (again.provenance[key].source, again.provenance[key].note) == ("derived", "from solids")
    assert assembly.machine == load(name)
    assert mass_findings(replace(assembly, machine=again), mass_rows(replace(assembly, machine=again))) == []


def test_a_deviation_above_five_percent_is_a_finding_with_both_values() -> None:
    rows = mass_rows(built())
    (row,) = [one for one in rows if one.path == "joint.small.body.mass"]
    texts = {str(one) for one in mass_findings(built(), [replace(row, deviation=-0.06), replace(row, deviation=0.04)])}
    (text,) = texts
    assert "joint.small.body.mass: is described as 2 kg, the solids have" in text
    assert row.texts[2] in text
