"""Every value of every built-in machine can be edited, in its unit, within its limits."""

import pytest

from layflat.description.change import paths, value_at
from layflat.machine import names
from layflat.pages.studio.design import Change, Design, open_description
from layflat.pages.studio.field import Field, describe_value, fields_of, key_title, section_name


@pytest.mark.parametrize("name", names())
def test_what_is_shown_is_read_as_it_was(name: str) -> None:
    opened = open_description(name)
    design = Design(opened)
    fields = [field for field in design.fields if field.shape not in {"fixed", "switch"}]
    design.edit_all({one.path: Change(one.read(one.format_value(design.value(one.path)))) for one in fields})
    for field in fields:
        value, was = design.value(field.path), design.opened_value(field.path)
        assert value == (pytest.approx(was, rel=1e-6) if field.shape in {"number", "whole", "list"} else was)


@pytest.mark.parametrize("name", ["paper-arm", "picking-arm", "rig-kevlar"])
def test_there_is_a_field_for_every_number_that_counts(name: str) -> None:
    opened = open_description(name)
    machine = opened.machine
    shown = {field.path for field in fields_of(machine, opened.plain)}
    used = [f"joint.{joint}." for joint in machine.joints]
    for path in paths(machine):
        counts = not path.startswith("joint.") or any(path.startswith(one) for one in used)
        whole = path.rpartition(".")[0] if path.rpartition(".")[2].isdigit() else path
        assert not counts or ".shapes." in path or whole in shown, path


@pytest.mark.parametrize("name", ["paper-arm", "picking-arm", "earlier-actuator"])
def test_a_slider_holds_the_value_within_the_limits(name: str) -> None:
    opened = open_description(name)
    for field in fields_of(opened.machine, opened.plain):
        value = value_at(opened.machine, field.path)
        if field.shape not in {"number", "whole"} or (around := field.slider(value)) is None:
            continue
        low, high, step = around
        least, _, most, _ = field.bounds
        assert low - step <= field.number(value) <= high + step
        assert low >= least or field.quantity is not None
        assert high <= most or field.quantity is not None
        assert 10 <= (high - low) / step <= 600 or field.shape == "whole"


def field_at(design: Design, path: str) -> Field:
    return next(field for field in design.fields if field.path == path)


@pytest.mark.parametrize(
    ("path", "typed", "meant"),
    [
        ("joint.large.hose.width", "170", "170 mm"),
        ("joint.large.hose.width", "17 cm", "170 mm"),
        ("joint.large.hose.width", "banana", "banana"),
        ("joint.large.hose.torque_factor", "0.9", 0.9),
        ("joint.large.strap.layers", "3", 3),
        ("joint.large.losses.deflections", "1, 2 deg", ["1 deg", "2 deg"]),
        ("joint.large.strap.material", " brass ", "brass"),
    ],
)
def test_a_bare_number_has_the_unit_of_the_field(design: Design, path: str, typed: str, meant: object) -> None:
    assert field_at(design, path).read(typed) == meant


def test_limits_are_said_in_the_unit_that_is_shown(design: Design) -> None:
    assert field_at(design, "joint.large.hose.wrap").limits == "above 0 to 720 deg"
    assert field_at(design, "joint.large.hose.loss_fraction").limits == "0 to 1"
    assert field_at(design, "joint.large.hose.width").limits == "0.001 to 20 m"
    assert field_at(design, "valve.critical_ratio").limits == "0 to below 0.99"


def test_names_are_as_people_write_them(design: Design) -> None:
    assert key_title("pressure_gauge") == "Pressure (gauge)"
    assert field_at(design, "joint.large.gains.far.error").label == "Far error"
    assert field_at(design, "joint.large.gains.far.error").section == "joint.large.gains"
    assert field_at(design, "joint.large.valve_size").section == "joint.large"
    assert field_at(design, "title").section == ""
    places = ["joint.large.link", "joint.large", "arm.link.base", "angle_sensor", ""]
    assert [section_name(one) for one in places] == [
        "Joint large, link",
        "Joint large",
        "Arm, link base",
        "Angle sensor",
        "",
    ]
    assert describe_value("of `valve`", "0 to 1") == "Of valve; 0 to 1"
