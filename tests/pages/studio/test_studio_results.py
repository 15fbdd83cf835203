"""Figures of a design follow from it, and are those of `layflat joint design`."""

import numpy as np
import pytest

from layflat.design import design_joint
from layflat.pages.studio.design import Design
from layflat.pages.studio.results import Designer, DesignQuantity, design_drawing, differences, relative_difference

WIDTH = "joint.large.hose.width"


def test_a_wider_hose_has_more_torque(design: Design) -> None:
    designer = Designer()
    before = designer.figures(design.machine, "large").torque[1].max()
    design.edit(WIDTH, "200 mm")
    figures = designer.figures(design.machine, "large")
    made = design_joint(design.machine, "large")
    assert figures.torque[1].max() > 1.2 * before
    assert np.array_equal(figures.torque[1], made.torque[1])
    assert abs(figures.torque[0]).max() == pytest.approx(np.degrees(made.stroke) / 2)


def test_only_joints_that_changed_are_designed_anew(design: Design) -> None:
    designer = Designer()
    first = designer.figures(design.machine, "small")
    design.edit(WIDTH, "200 mm")
    assert designer.figures(design.machine, "small").design is first.design
    design.edit("supply.pressure_gauge", "5 bar")
    assert designer.figures(design.machine, "small").design is not first.design


def test_what_breaks_is_found_in_all_joints(design: Design) -> None:
    design.edit("joint.small.strap.width", "150 mm")
    figures = Designer().figures(design.machine, "large")
    assert any(one.rule == "strap width" and "joint.small" in one.where for one in figures.findings)


def test_a_joint_that_can_not_be_made_is_a_finding(design: Design) -> None:
    design.edit("joint.large.output.radius", "10 mm")
    figures = Designer().figures(design.machine, "large")
    assert figures.design is None
    assert (figures.findings[0].severity, figures.findings[0].rule) == ("error", "design")
    assert not design_drawing(figures)
    assert not figures.quantities
    assert not len(figures.torque[0])


def test_drawings_show_a_cam_beside_another(design: Design) -> None:
    designer = Designer()
    before = designer.figures(design.machine, "large")
    design.edit(WIDTH, "200 mm")
    after = designer.figures(design.machine, "large")
    assert design_drawing(after, before).count("<path") == design_drawing(after).count("<path") + 1
    assert "cylinder" in design_drawing(after, layout=True)
    design.edit("joint.large.output.kind", "roller")
    assert not design_drawing(designer.figures(design.machine, "large"))


def test_differences_are_said_with_their_share() -> None:
    now, other = [DesignQuantity("mass", 6.0, "kg")], [DesignQuantity("mass", 5.0, "kg")]
    assert differences(now, other)[0][2] == "+1 kg (+20 %)"
    assert differences(now, now)[0][2] == "same"
    assert differences(now, [])[0][1:] == (None, "")
    assert relative_difference(now[0], other[0]) == "+20.0 % against A"
    assert relative_difference(now[0], now[0]) == "as A"
    assert relative_difference(now[0], DesignQuantity("mass", np.nan, "kg")) == ""
    assert DesignQuantity("radius", np.nan, "mm").text == "none"


@pytest.mark.parametrize("field", ["pressure_gauge", "temperature", "ambient_pressure", "ambient_temperature"])
def test_figures_follow_all_of_the_supply(design: Design, field: str) -> None:
    designer, supply = Designer(), design.machine.supply
    before = designer.figures(design.machine, "large").quantities
    changed = supply.model_copy(update={field: 0.9 * getattr(supply, field)})
    machine = design.machine.model_copy(update={"supply": changed})
    figures = designer.figures(machine, "large")
    assert figures.quantities == Designer().figures(machine, "large").quantities
    assert (figures.quantities != before) == (field != "ambient_temperature")


def test_figures_name_the_machine_of_now(design: Design) -> None:
    design.edit("joint.small.strap.width", "150 mm")
    designer, other = Designer(), design.machine.model_copy(update={"name": "other"})
    designer.figures(design.machine, "small")
    figures = designer.figures(other, "small")
    assert "other" in design_drawing(figures)
    other._origin = "other.toml"
    assert all(one.where.startswith("other.toml") for one in designer.figures(other, "small").findings)
