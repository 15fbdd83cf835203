"""What is wrong in a description, in our own words: no type of pydantic's errors lets its words through."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

import pytest
from pydantic import Discriminator, Field, Tag, ValidationError, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.explain import explain_error
from layflat.description.names import Key


class Round(Part):
    kind: Literal["round"] = "round"
    radius: u.Length


ONE = Round.model_validate({"radius": "1 m"})


class Square(Part):
    kind: Literal["square"]
    side: Annotated[u.Length, Field(lt=2)]
    corners: tuple[u.Angle, u.Angle] = (0.0, 0.0)


def _kind(value: Any) -> Any:
    return value.get("kind", "round") if isinstance(value, dict) else getattr(value, "kind", None)


Shape = Annotated[Annotated[Round, Tag("round")] | Annotated[Square, Tag("square")], Discriminator(_kind)]


class Whole(Part):
    name: str = "x"
    count: Annotated[int, Field(ge=1, le=9)] = 1
    share: u.Share = 0.5
    on: bool = True
    way: Literal["left", "right"] = "left"
    code: Annotated[str, Field(pattern="^[a-z]+$", max_length=3)] = "a"
    items: Annotated[tuple[float, ...], Field(min_length=1, max_length=2)] = (1.0,)
    names: list[str] = Field(default_factory=list)
    shape: Shape = ONE
    plain: Annotated[Round | Square, Field(discriminator="kind")] = ONE
    maybe: Round | None = None
    shapes: dict[Key, Shape] = Field(default_factory=dict)
    row: tuple[Shape, ...] = ()
    low: float = 0.0
    high: float = 1.0

    @model_validator(mode="after")
    def _ordered(self) -> Whole:
        if self.low > self.high:
            raise ValueError("low is above high; give less")
        return self


def line(plain: dict[str, Any]) -> str:
    try:
        Whole.model_validate(plain)
    except ValidationError as error:
        return str(explain_error(error, "f.toml", Whole, complete="see one"))
    raise AssertionError(plain)


GOOD = {"kind": "round", "radius": "1 m"}
CASES: list[tuple[dict[str, Any], str]] = [
    ({"nam": "x"}, "f.toml: nam: unknown key; did you mean 'name'?"),
    ({"zebra": 1}, "f.toml: zebra: unknown key; known keys are name, count,"),
    ({"name": 3}, "f.toml: name: 3 is not a text; put it in quotes"),
    ({"count": 2.5}, "f.toml: count: 2.5 is not a whole number; give one such as 12"),
    ({"count": "many"}, "f.toml: count: 'many' is not a whole number"),
    ({"count": 0}, "f.toml: count: 0 is out of range; give at least 1"),
    ({"count": 10}, "f.toml: count: 10 is out of range; give at most 9"),
    ({"count": float("inf")}, "f.toml: count: inf is not a finite number"),
    ({"share": "much"}, "f.toml: share: 'much' is not a number"),
    ({"share": float("nan")}, "f.toml: share: nan is not a finite number"),
    ({"share": [1]}, "f.toml: share: [1] is not a number"),
    ({"on": "perhaps"}, "f.toml: on: 'perhaps' is not true or false"),
    ({"on": {}}, "f.toml: on: {} is not true or false"),
    ({"way": "lef"}, "f.toml: way: 'lef' is not known; did you mean 'left'?"),
    ({"way": 3}, "f.toml: way: 3 is not known; give 'left' or 'right'"),
    ({"code": "A"}, "f.toml: code: 'A' has the wrong form; it must match ^[a-z]+$"),
    ({"code": "abcd"}, "f.toml: code: has 4 characters; give at most 3"),
    ({"items": []}, "f.toml: items: has 0 values; give at least 1"),
    ({"items": [1, 2, 3]}, "f.toml: items: has 3 values; give at most 2"),
    ({"items": [1, "a"]}, "f.toml: items.1: 'a' is not a number"),
    ({"items": 3}, "f.toml: items: 3 is not a list; put its values in brackets"),
    ({"names": "a"}, "f.toml: names: 'a' is not a list"),
    ({"names": [1]}, "f.toml: names.0: 1 is not a text"),
    ({"shape": "round"}, "f.toml: shape"),
    (
        {"shape": {"kind": "rund", "radius": "1 m"}},
        """f.toml: shape.kind: 'rund' is not a known kind; did you mean "round"? known kinds are "round", "square\"""",
    ),
    ({"shape": {"radius": "1 kg"}}, "f.toml: shape.radius: '1 kg' is not a length"),
    ({"shape": {}}, "f.toml: shape.radius: is missing; see one"),
    ({"shape": {"kind": "square", "sid": "1 m"}}, "f.toml: shape.sid: unknown key; did you mean 'side'?"),
    ({"shape": {"kind": "square", "side": "3 m"}}, "f.toml: shape.side: '3 m' is out of range; give less than 2 m"),
    (
        {"shape": {"kind": "square", "side": "1 m", "corners": ["1 deg"]}},
        "f.toml: shape.corners: has too few values; give 2",
    ),
    (
        {"shape": {"kind": "square", "side": "1 m", "corners": ["1 deg"] * 3}},
        "f.toml: shape.corners: has 3 values; give at most 2",
    ),
    (
        {"shape": {"kind": "square", "side": "1 m", "corners": ["1 deg", "1 m"]}},
        "f.toml: shape.corners.1: '1 m' is not an angle",
    ),
    ({"plain": {"kind": "oval"}}, "f.toml: plain.kind: 'oval' is not a known kind; known kinds are"),
    ({"plain": {"radius": "1 m"}}, "f.toml: plain.kind: is missing"),
    ({"plain": 3}, "f.toml: plain: 3 is not a table"),
    ({"plain": [{"kind": "round"}]}, "f.toml: plain: [{'kind': 'round'}] is not a table"),
    ({"plain": {"kind": "round", "radius": 3}}, "f.toml: plain.radius: 3 is a bare number"),
    ({"maybe": {"radius": "-1 m"}}, "f.toml: maybe.radius: '-1 m' is out of range; give more than 0"),
    ({"maybe": 3}, "f.toml: maybe: 3 is not a table"),
    ({"shapes": {"a": {"kind": "square", "side": "x"}}}, "f.toml: shapes.a.side: 'x' is not one number with one unit"),
    ({"shapes": {"a.b": GOOD}}, "f.toml: shapes.a.b: 'a.b' can't be a name"),
    ({"shapes": 3}, "f.toml: shapes: 3 is not a table"),
    ({"row": [GOOD, {"kind": "square", "side": "3 m"}]}, "f.toml: row.1.side: '3 m' is out of range"),
    ({"low": 2}, "f.toml: low is above high; give less"),
    ({"name": "x" * 500 + "\n", "count": "y" * 500}, "f.toml: count: 'yyy"),
]


@pytest.mark.parametrize(("plain", "said"), CASES)
def test_every_mistake_in_our_own_words(plain: dict[str, Any], said: str) -> None:
    found = line(plain)
    assert found.startswith(said)
    assert "\n" not in found
    assert len(found) < 400
    assert not re.search(r"(?i)input|pydantic|should|type=|valid |instance|dictionary|tuple|\bstr\b", found)


def test_a_tag_that_is_also_a_key_of_a_table_is_kept() -> None:
    assert line({"shapes": {"round": {"radius": "x"}}}).startswith("f.toml: shapes.round.radius: 'x'")
