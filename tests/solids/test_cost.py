"""Costs are sums of prices that a user gives: of stock, of work and of bought parts; a mistake is one line."""

from dataclasses import replace
from math import pi
from pathlib import Path

import pytest

from layflat.errors import InputError
from layflat.solids.component import Component
from layflat.solids.cost import Price, Prices, cost_of, cut_length, read_prices
from layflat.solids.loops import circle, rectangle
from layflat.solids.parts_list import PartsList, list_parts
from layflat.solids.shapes import Hole, Prism, Turned, joined, place
from layflat.solids.standard.materials import MATERIALS
from tests.solids.joints import components_of, mass_by_name

TEXT = """
[stock]
aluminium = "12 /kg"
"aluminium-sheet" = "0.01 /g"

[process]
"laser cutting" = "3 /m"
turning = 2
milling = "0.5"

[bought]
"ISO 4762 *" = "0.1"
"ISO 4762 M5*" = "0.25"
"""
PLATE = Prism(rectangle(100.0, 50.0), 5.0, holes=(Hole((0.0, 0.0), 10.0),), openings=(rectangle(20.0, 10.0),))
PLATE_CUT = 2 * (100 + 50) + 2 * (20 + 10) + pi * 10  # mm


def prices_in(folder: Path, text: str = TEXT) -> Prices:
    path = folder / "prices.toml"
    path.write_text(text, encoding="utf-8")
    return read_prices(path)


def part(name: str, making: str, quantity: int = 1, **other: object) -> Component:
    one = Component(name, "body", PLATE, "aluminium", making, (place(),) * quantity)  # type: ignore[arg-type]
    return replace(one, **other)  # type: ignore[arg-type]


PLATES = part("plate", "laser cutting", 2, joint="small")
MORE_PLATES = replace(PLATES, joint="large", places=(place(),))
BAR = part("bar", "turning", joint="large")
SCREWS = [part(size, "bought", 10, designation=f"ISO 4762 {size}", joint="small") for size in ("M5 x 20", "M3 x 8")]
HOSE = part("hose", "cutting", material="hose")
MASSES = {"plate": 0.1, "bar": 0.3, "hose": 0.05}


def listed() -> PartsList:
    return list_parts([PLATES, MORE_PLATES, BAR, *SCREWS, HOSE], lambda one: MASSES.get(one.name, 0.01))


def test_parts_cost_stock_and_work_and_screws_what_the_nearest_pattern_says(tmp_path: Path) -> None:
    parts = listed()
    cost = cost_of(parts, prices_in(tmp_path))
    plate, bar = 0.1 * 12 + 1e-3 * PLATE_CUT * 3, 0.3 * 12 + 2
    each = {row.name: cost.each.get(row.number) for row in parts.parts}
    assert each == pytest.approx({"plate": plate, "bar": bar, "M5 x 20": 0.25, "M3 x 8": 0.1, "hose": None})
    assert cost.joints == pytest.approx({"small": 2 * plate + 2.5 + 1.0, "large": plate + bar, "": 0.0})
    assert cost.total == pytest.approx(sum(row.quantity * (each[row.name] or 0.0) for row in parts.parts))
    assert [row.name for row in cost.unpriced] == ["hose"]


def test_twice_the_prices_cost_twice_as_much_for_a_whole_joint(tmp_path: Path) -> None:
    parts = list_parts(components_of("paper-arm", "small"), mass_by_name)
    tables = {"stock": dict.fromkeys(MATERIALS, "8 /kg"), "bought": {"*": "0.4"}}
    work = dict.fromkeys(("laser cutting", "milling", "turning", "bending", "sawing", "printing", "cutting"), "3")
    once = cost_of(parts, Prices.model_validate(tables | {"process": work}))
    assert once.unpriced == ()
    bought = sum(row.quantity for row in parts.parts if row.bought)
    made = sum(row.quantity for row in parts.parts if not row.bought)
    assert once.total == pytest.approx(8 * parts.made_mass + 3 * made + 0.4 * bought)
    double = {"stock": dict.fromkeys(MATERIALS, "16 /kg"), "bought": {"*": "0.8"}, "process": dict.fromkeys(work, "6")}
    assert cost_of(parts, Prices.model_validate(double)).total == pytest.approx(2 * once.total)


def test_prices_are_written_as_they_are_read(tmp_path: Path) -> None:
    prices = prices_in(tmp_path)
    assert prices.stock["aluminium-sheet"] == Price(10.0, "1/kg")
    assert prices.process["turning"] == Price(2.0)
    assert Prices.model_validate(prices.model_dump(mode="json")) == prices


def test_cuts_are_those_through_flat_parts() -> None:
    assert cut_length(PLATE) == pytest.approx(PLATE_CUT)
    turned = Turned(rectangle(5.0, 9.0, (2.5, 0.0)))
    assert cut_length(turned) == 0.0
    assert cut_length(joined((PLATE, place()), (turned, place()), (PLATE, place(z=9.0)))) == pytest.approx(
        2 * PLATE_CUT
    )
    assert circle(1.0, 2.0, 10.0).perimeter == pytest.approx(20 * pi, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[stock]\nsteal = "2 /kg"', r"prices.toml: stock: unknown material 'steal'; known are aluminium, .*, hose$"),
        (
            "[process]\nglueing = 2",
            r"prices.toml: process: unknown process 'glueing'; known are laser cutting, milling",
        ),
        ('[stock]\nsteel = "2"', r"prices.toml: stock.steel: '2' is not a price of this form; .*, without a currency"),
        ('[stock]\nsteel = "2 EUR/kg"', r"stock.steel: '2 EUR/kg' is not a price of this form"),
        ('[stock]\nsteel = "-2 /kg"', r"stock.steel: '-2 /kg' is out of range; give 0 or more"),
        ('[bought]\n"ISO*" = "nan"', r"bought.ISO\*: 'nan' is out of range"),
        ('[bought]\n"ISO*" = true', r"bought.ISO\*: True is not a price"),
        ('[process]\nmilling = "2 /m"', r"process.milling: only laser cutting has a price by length"),
        ('[process]\n"laser cutting" = "2 /kg"', r"process.laser cutting: '2 /kg' is not a price of this form"),
        ("stock = 3", r"prices.toml: stock: 3 is not a table"),
        ("[stok]", r"prices.toml: stok: unknown key; did you mean 'stock'"),
        ("[stock", r"prices.toml: is not TOML"),
    ],
)
def test_mistakes_are_one_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        prices_in(tmp_path, text)
    assert "\n" not in str(caught.value)


def test_the_example_of_the_page_is_a_file_of_prices(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs/building.md").read_text(encoding="utf-8")
    block = page.partition("```toml\n")[2].partition("```")[0]
    prices = prices_in(tmp_path, block)
    assert all((prices.stock, prices.process, prices.bought))


def test_a_missing_file_is_named() -> None:
    with pytest.raises(InputError, match=r"no-such\.toml"):
        read_prices("no-such.toml")
