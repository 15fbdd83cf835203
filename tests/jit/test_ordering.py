import itertools
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.jit.ordering import (
    LOOKAHEAD_INSTRUCTIONS,
    MAX_BLOCK_LENGTH,
    MAX_VECTOR_BITS,
    MIN_BLOCK_LENGTH,
    order_instructions,
)

OPERATIONS = ("fadd", "fsub", "fmul", "fdiv")


def module(body: list[str], end: str = "ret void") -> str:
    lines = [f"  {line}" for line in (*body, end)]
    return "\n".join(["define void @run(double %x, ptr %place) {", "begin:", *lines, "}", ""])


def chain(name: str, count: int) -> list[str]:
    links = ["%x", *(f"%{name}{i}" for i in range(count))]
    return [f"{after} = fmul double {before}, 3.0" for before, after in itertools.pairwise(links)]


def body_of(text: str) -> list[str]:
    return [line.strip() for line in text.split("\n") if line.startswith("  ")]


def test_chains_that_stand_one_after_the_other_go_side_by_side() -> None:
    first, second = chain("a", 100), chain("b", 120)
    body = body_of(order_instructions(module([*first, *second])))
    assert sorted(body) == sorted([*first, *second, "ret void"])
    assert [line for line in body if line in first] == first
    assert [line for line in body if line in second] == second
    # The longer one is what the end waits for.
    assert body[:100:2] == second[:50]
    assert body[1:100:2] == first[:50]


def test_nothing_goes_far_ahead_of_what_waits() -> None:
    first, second = chain("a", 2 * LOOKAHEAD_INSTRUCTIONS), chain("b", 3 * LOOKAHEAD_INSTRUCTIONS)
    body = body_of(order_instructions(module([*first, *second])))
    for place, line in enumerate(second):
        before = body[: body.index(line)]
        missing = [other for other in first if other not in before]
        assert not missing or len(first) + place < first.index(missing[0]) + LOOKAHEAD_INSTRUCTIONS


@pytest.mark.parametrize(
    ("count", "kind"),
    [(MIN_BLOCK_LENGTH // 3, "double"), (MAX_BLOCK_LENGTH, f"<{MAX_VECTOR_BITS // 64 + 1} x double>")],
)
def test_short_blocks_and_very_long_ones_of_wide_numbers_stay_as_they_are(count: int, kind: str) -> None:
    text = module([*chain("a", count), f"%wide = fneg {kind} zeroinitializer", *chain("b", count)])
    assert order_instructions(text) == text


@pytest.mark.parametrize(
    ("count", "lanes"), [(MAX_BLOCK_LENGTH, MAX_VECTOR_BITS // 64), (MAX_BLOCK_LENGTH // 3, MAX_VECTOR_BITS // 8)]
)
def test_very_long_blocks_are_put_in_order_where_no_number_is_wide_and_others_in_any_case(
    count: int, lanes: int
) -> None:
    text = module([*chain("a", count), f"%wide = fneg <{lanes} x double> zeroinitializer", *chain("b", count)])
    assert order_instructions(text) != text


def test_numbers_for_names_are_as_good() -> None:
    body = [f"%{i + 1} = fmul double %{i or 'x'}, 3.0" for i in range(MIN_BLOCK_LENGTH)]
    found = body_of(order_instructions(module(body)))
    assert found[:3] == ["%n0 = fmul double %x, 3.0", "%n1 = fmul double %n0, 3.0", "%n2 = fmul double %n1, 3.0"]


def test_names_that_are_there_are_not_given_again() -> None:
    body = [*chain("n", MIN_BLOCK_LENGTH), *(f"%{i} = fadd double %n1, %x" for i in range(3))]
    found = body_of(order_instructions(module(body)))
    assert [line for line in found if "fadd" in line] == [f"%nn{i} = fadd double %n1, %x" for i in range(3)]


def test_long_names_become_short() -> None:
    name = "long" * 100
    end = f"br label %{name}s"
    text = order_instructions(
        module([f"%{name} = fmul double %x, 3.0", f"%y = fmul double %{name}, 3.0", *chain("a", MIN_BLOCK_LENGTH)], end)
    )
    assert {"%n0 = fmul double %x, 3.0", "%y = fmul double %n0, 3.0", "br label %n1"} <= set(body_of(text))
    assert order_instructions(text.replace("begin:", f"{name}:")).split("\n")[1] == "nn0:"


def test_a_switch_stays_in_one_piece() -> None:
    end = "switch i64 0, label %begin [\n    i64 1, label %begin\n  ]"
    found = order_instructions(module([*chain("a", MIN_BLOCK_LENGTH), *chain("b", MIN_BLOCK_LENGTH)], end))
    assert found.endswith(f"  {end}\n}}\n")


@st.composite
def blocks(draw: st.DrawFn) -> list[str]:
    names, body = ["%x"], list[str]()
    for i in range(MIN_BLOCK_LENGTH + draw(st.integers(0, 60))):
        kind = draw(st.sampled_from((*OPERATIONS, "load", "store", "call")))
        one, other = draw(st.sampled_from(names[-40:])), draw(st.sampled_from(names))
        if kind == "store":
            body.append(f"store double {one}, ptr %place")
        elif kind == "load":
            body.append(f"%v{i} = load double, ptr %place")
        elif kind == "call":
            body.append(f"%v{i} = call double @llvm.sqrt.f64(double {one})")
        else:
            body.append(f"%v{i} = {kind} double {one}, {other}")
        names += [f"%v{i}"] if kind != "store" else []
    return body


@given(blocks())
def test_what_is_used_stands_before_and_memory_keeps_its_order(block: list[str]) -> None:
    found = body_of(order_instructions(module(block)))
    assert sorted(found) == sorted([*block, "ret void"])
    made = {"%x", "%place"}
    for line in found:
        name, _, rest = line.rpartition(" = ")
        assert set(re.findall(r"%\w+", rest)) <= made
        made.add(name)
    # A load may pass another, but no store.
    for text in (block, found):
        assert [line for line in text if "store" in line] == [line for line in block if "store" in line]
    stores = [-1, *(i for i, line in enumerate(block) if "store" in line), len(block)]
    for before, after in itertools.pairwise(stores):
        for load in (line for line in block[before + 1 : after] if "load" in line):
            where = [found.index(line) for line in found if line == load]
            count = sum("store" in line for line in found[: where[0]])
            assert count == sum("store" in line for line in block[: max(before, 0) + 1])
