"""Rules that parts of descriptions share."""

import ast
import re
from pathlib import Path

import pytest
from pydantic import ValidationError

import layflat
from layflat.description import Part, ordered


class Below(Part):
    """Two values in order."""

    low: float
    high: float
    _ordered = ordered("low", "high", "low must be below high")


class AtMost(Below):
    """The same, where they may be equal."""

    _ordered = ordered("low", "high", "low must not be above high", may_equal=True)


@pytest.mark.parametrize(("part", "low", "high", "problem"), [
    (Below, 1.0, 2.0, None), (Below, 2.0, 2.0, "low must be below high"), (Below, 3.0, 2.0, "low must be below high"),
    (AtMost, 1.0, 2.0, None), (AtMost, 2.0, 2.0, None), (AtMost, 3.0, 2.0, "low must not be above high"),
])  # fmt: skip
def test_values_out_of_order_are_refused(part: type[Below], low: float, high: float, problem: str | None) -> None:
    if problem is None:
        assert part(low=low, high=high).high == high
    else:
        with pytest.raises(ValidationError, match=problem):
            part(low=low, high=high)


EVERYDAY = re.compile(
    r"\b(turn\w*|shares?|nobody|ways?|told|tells?|asked|wanted|gone|puts?|brings?|swings?|calm|led|own)\b"
)


def test_descriptions_of_keys_use_words_of_the_field() -> None:
    texts = []
    for path in sorted(Path(layflat.__file__).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Field":
                described = [keyword.value for keyword in node.keywords if keyword.arg == "description"]
                texts += [text.value for text in described if isinstance(text, ast.Constant)]
    assert len(texts) > 200
    assert [text for text in texts if EVERYDAY.search(str(text))] == []
