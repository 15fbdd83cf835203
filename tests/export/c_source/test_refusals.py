"""Constructs without a counterpart in C: one line with file, line, construct and what would be right."""

# mypy: disable-error-code="no-untyped-def"
# Laws are untyped.

import inspect
import math
import re
from pathlib import Path
from typing import Any

import pytest

from layflat.errors import KindError
from layflat.export import export
from layflat.export.c_source.c_types import REAL_TYPE, Items, Type
from layflat.jit import law
from layflat.lanes import each
from tests.export.c_source.programs import translated


@law
def calls_sine(a):
    return math.sin(a)


@law
def calls_plain_python(a):
    return inspect.cleandoc(a)


@law
def uses_a_list(a):
    return [a][0]


@law
def uses_try(a):
    try:
        return a
    finally:
        pass


@law
def iterates(a):
    result = 0.0
    for x in a:
        result = result + x
    return result


@law
def divides_down(a):
    return a // 2.0


@law
def takes_a_root(a):
    return a**0.5


@law
def changes_type(a):
    b = a
    for i in range(3):
        b = (b, i)
    return b


@law
def calls_itself(a):
    return calls_itself(a - 1.0)


@law
def zips(a):
    return each(calls_sine, a, (1.0,))


@law
def returns_nothing(a):
    return


THREE = Items((REAL_TYPE,) * 3)
CASES: list[tuple[Any, Type, str]] = [
    (calls_sine, REAL_TYPE, "'sin' has no counterpart in C; use abs, min, max"),
    (calls_plain_python, REAL_TYPE, "'cleandoc' has no counterpart in C"),
    (uses_a_list, REAL_TYPE, "'[a]' has no counterpart in C; use arithmetic, tuples and calls of laws"),
    (uses_try, REAL_TYPE, "'try' has no counterpart in C; use if, for, while and names"),
    (iterates, THREE, "for ... in a has no counterpart in C; use for i in range(n)"),
    (divides_down, REAL_TYPE, "// and % of floats have no counterpart in C; use x - y * floor(x / y)"),
    (takes_a_root, REAL_TYPE, "powers other than whole ones have no counterpart in C; use x ** 2 to x ** 16"),
    (changes_type, REAL_TYPE, "'b' changes its type; use another name for the other value"),
    (calls_itself, REAL_TYPE, "'calls_itself' calls itself; use a loop"),
    (zips, THREE, "each takes tuples with as many items; give it tuples of one length"),
    (returns_nothing, REAL_TYPE, "a law returns nothing; return numbers or named tuples"),
]


@pytest.mark.parametrize(("refused", "kind", "text"), CASES, ids=[case[0].__name__ for case in CASES])
def test_the_message_names_place_construct_and_remedy(refused: Any, kind: Type, text: str) -> None:
    with pytest.raises(KindError) as error:
        translated(refused, [kind])
    message = str(error.value)
    assert text in message
    assert "\n" not in message
    place = re.match(rf"{re.escape(__file__)}:(\d+): ", message)
    assert place is not None
    first = refused.py_func.__code__.co_firstlineno
    assert first < int(place[1]) <= first + 6


SINE_KIND = """
from math import sin
from typing import Literal, NamedTuple

from layflat.control import CONTROL_LAWS, ControlKind, ControllerPart, voltages_alone
from layflat.jit import law
from layflat.lanes import each


class SinePart(ControllerPart):
    kind: Literal["sine"]


class Sine(NamedTuple):
    centre: float


class Nothing(NamedTuple):
    zero: float


class SineReport(NamedTuple):
    error: float


@law
def follow(settings, angle):
    return settings.centre + sin(angle)


@law
def report(angle):
    return SineReport(angle)


@law
def wake(settings, sensed):
    return Nothing(0.0)


@law
def step(settings, memory, sensed, demand, elapsed):
    return memory, voltages_alone(each(follow, settings, sensed.angle)), each(report, sensed.angle)


CONTROL_LAWS.register(ControlKind(
    name="sine", description=SinePart, parameters=lambda described, machine: Sine(5.0), parameter_types=(Sine,),
    wake=wake, step=step, report=SineReport, signals={"error": ("rad", "none")},
))
"""


def test_a_law_that_is_refused_leaves_no_folder(tmp_path: Path) -> None:
    (tmp_path / "sine.py").write_text(SINE_KIND)
    description = (
        'extends = "paper-small-joint"\nname = "sine-joint"\nkinds = ["sine.py"]\n[controller]\nkind = "sine"\n'
    )
    (tmp_path / "sine.toml").write_text(description)
    with pytest.raises(KindError, match=r"sine\.py:\d+: 'sin' has no counterpart in C"):
        export(tmp_path / "sine.toml", "c-source", tmp_path / "out")
    assert not (tmp_path / "out").exists()
