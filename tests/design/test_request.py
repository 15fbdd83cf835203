"""Hoses and cylinders that are tried, straps that are chosen, and the request they are for."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise
from math import cos, inf, pi, radians
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from layflat.design import HOSE_WIDTHS, SizingRequest
from layflat.design.request import (
    CHOSEN_RATIO,
    CONTACT_SHARE,
    FIELD_RANGES,
    GIVEN_RATIO,
    TRAVEL_RESERVE,
    hoses_and_cylinders,
)
from layflat.design.strength import (
    LEAST_WIDTH,
    STRIP_LAYERS,
    STRIP_THICKNESSES,
    WIDTH_SHARE,
    choose_strap,
    strap_stress,
)
from layflat.errors import DesignError, InputError
from layflat.machine import load

PEEL = 1.2631
STEEL = load("paper-small-joint").joint["small"].strap
SMALL = SizingRequest(25.0, radians(120), 4e5)


def asking(**values: Any) -> SizingRequest:
    return replace(SMALL, **values)


requests = st.builds(
    SizingRequest,
    torque=st.floats(1.0, 300.0),
    stroke=st.floats(radians(60), radians(160)),
    supply=st.floats(1e5, 8e5),
    wrap=st.floats(radians(80), radians(130)),
)


def swept(request: SizingRequest, width: float, diameter: float) -> float:
    """Volume by integrating the force of Eq. (1) over the travel, apart from the package."""
    R, gamma = diameter / 2, request.wrap

    def force(alpha: float) -> float:
        return R / (2 * cos((pi - gamma) / 2)) * (width - R * (gamma - alpha) / 2) * (1 - cos(alpha))

    return float(quad(force, CONTACT_SHARE * gamma, gamma)[0]) * PEEL * R


@settings(deadline=None, max_examples=40)
@given(request=requests)
def test_every_candidate_sweeps_enough_and_a_millimetre_less_does_not(request: SizingRequest) -> None:
    needed = request.torque * (request.stroke + TRAVEL_RESERVE) / request.supply
    found = list(hoses_and_cylinders(request, PEEL))
    for width, diameter in found:
        assert width in HOSE_WIDTHS
        assert swept(request, width, diameter) >= needed * (1 - 1e-9)
        slimmest = CHOSEN_RATIO[0] * width
        assert diameter <= slimmest + 1e-3 or swept(request, width, diameter - 1e-3) < needed
        assert CHOSEN_RATIO[0] - 1e-9 <= diameter / width <= CHOSEN_RATIO[1] + 1e-3 / width
    assert all(one[0] < other[0] for one, other in pairwise(found))


@settings(deadline=None, max_examples=20)
@given(request=requests, width=st.floats(0.05, 0.3), diameter=st.floats(0.03, 0.4))
def test_given_sizes_are_kept_within_what_a_hose_can_wrap(
    request: SizingRequest, width: float, diameter: float
) -> None:
    for kept in (replace(request, hose_width=width), replace(request, cylinder_diameter=diameter)):
        for w, D in hoses_and_cylinders(kept, PEEL):
            assert w == width or kept.hose_width is None
            assert D == diameter or kept.cylinder_diameter is None
            assert GIVEN_RATIO[0] - 1e-9 <= D / w <= GIVEN_RATIO[1] + 1e-3 / w
    both = replace(request, hose_width=width, cylinder_diameter=diameter)
    assert list(hoses_and_cylinders(both, PEEL)) in ([], [(width, diameter)])


@given(tension=st.floats(10.0, 2e4), bend=st.floats(0.005, 0.1), margin=st.floats(1.0, 3.0))
def test_a_chosen_strap_bears_its_load_and_a_narrower_one_does_not(tension: float, bend: float, margin: float) -> None:
    request = replace(SMALL, stress_margin=margin)
    try:
        strap = choose_strap(request, STEEL, 0.11, tension, bend)
    except DesignError:
        widest = [
            {"width": 0.049, "thickness": t, "layers": layers} for t in STRIP_THICKNESSES for layers in STRIP_LAYERS
        ]
        tried = [strap_stress(STEEL.model_copy(update=size), "cam", bend, tension).safety for size in widest]
        assert max(tried) < margin * (1 + 1e-9)
        return
    assert strap.width <= WIDTH_SHARE * 0.11
    assert strap.layers in STRIP_LAYERS
    assert strap_stress(strap, "cam", bend, tension).safety >= margin * (1 - 1e-9)
    narrower = strap.model_copy(update={"width": strap.width - 1e-3})
    assert strap.width == LEAST_WIDTH or strap_stress(narrower, "cam", bend, tension).safety < margin


def test_a_given_strap_is_kept_where_it_bears() -> None:
    request = replace(SMALL, strap_width=0.04, strap_thickness=1e-4)
    strap = choose_strap(request, STEEL, 0.11, 1000.0, 0.015)
    assert (strap.width, strap.thickness) == (0.04, 1e-4)
    with pytest.raises(DesignError, match="no strap up to 40 mm wide bears"):
        choose_strap(request, STEEL, 0.11, 1e6, 0.015)


def test_every_quantity_of_a_request_has_a_range_that_its_default_keeps() -> None:
    numbers = {field.name for field in fields(SizingRequest)} - {"name"}
    assert set(FIELD_RANGES) == numbers
    assert all(0 < least < greatest < inf for _, least, greatest in FIELD_RANGES.values())


@pytest.mark.parametrize("key", FIELD_RANGES)
@pytest.mark.parametrize("beyond", [0.99, 1.01])
def test_a_value_beyond_its_range_is_named_with_both_ends(key: str, beyond: float) -> None:
    _, least, greatest = FIELD_RANGES[key]
    value = beyond * (least if beyond < 1 else greatest)
    with pytest.raises(DesignError, match=rf"^size: {key}: .*; give .+ to .+") as caught:
        asking(**{key: value})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("end", ["least", "greatest"])
def test_both_ends_of_a_range_are_accepted(end: str) -> None:
    for key, (_, least, greatest) in FIELD_RANGES.items():
        asking(**{key: least if end == "least" else greatest})


@pytest.mark.parametrize("name", ["", " ", "../evil", "a/b", "a\0b", ".hidden"])
def test_a_name_must_do_for_a_file(name: str) -> None:
    with pytest.raises(InputError, match="size: name: "):
        replace(SMALL, name=name)


@pytest.mark.parametrize("odd", ["5 s", None, 1j, True, b"x", [], {}, object()])
@pytest.mark.parametrize("key", ["torque", "stroke", "supply", "wrap", "strap_width", "name"])
def test_what_is_no_number_is_named(key: str, odd: object) -> None:
    if (odd is None and key == "strap_width") or (key == "name" and isinstance(odd, str)):
        return
    wrong: Any = {"torque": 5.0, "stroke": 1.5, "supply": 4e5} | {key: odd}
    with pytest.raises(InputError, match=f"size: {key}: (.* is no|is missing)"):
        SizingRequest(**wrong)
