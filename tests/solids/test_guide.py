"""An assembly guide puts every part in place once, and says with which torque and at which angle."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from functools import cache
from math import degrees
from xml.etree import ElementTree

import pytest

from layflat.machine import load
from layflat.solids.guide import Page, _distinct, arm_chapter, chapter_pages, guide_page, joint_chapter, plan_tasks
from layflat.solids.guide_steps import ARM_STEPS, JOINT_STEPS
from layflat.solids.guide_text import component_facts, fill_sentence, tightening
from layflat.solids.parts_list import list_parts
from tests.solids.joints import components_of, maker_of_solids, mass_by_name, sizes_of

JOINTS = [
    ("paper-arm", "small"),
    ("paper-arm", "large"),
    ("single-joint-lift", next(iter(load("single-joint-lift").joints))),
]
PARTS = list_parts(components_of("paper-arm", "small"), mass_by_name)
SOLID = maker_of_solids()


@pytest.mark.parametrize(("machine", "joint"), JOINTS)
def test_every_part_of_a_joint_is_put_in_place_in_one_step(machine: str, joint: str) -> None:
    components = components_of(machine, joint)
    placed: Counter[str] = Counter()
    for task in plan_tasks(components, JOINT_STEPS):
        for one, _ in task.adds:
            placed[one.name] += one.quantity
    expected: Counter[str] = Counter()
    for one in components:
        expected[one.name] += one.quantity
    assert placed == expected


@pytest.mark.parametrize(("machine", "joint"), JOINTS)
def test_every_component_has_a_rule(machine: str, joint: str) -> None:
    patterns = [rule.pattern for step in JOINT_STEPS for rule in step.rules]
    for one in components_of(machine, joint):
        assert any(re.fullmatch(pattern, one.name) for pattern in patterns), one.name


def test_a_component_without_a_rule_goes_with_the_one_before() -> None:
    first, *others = components_of("paper-arm", "small")
    odd = replace(first, name="name plate")
    tasks = plan_tasks([first, odd, *others], JOINT_STEPS)
    (home,) = [task for task in tasks if any(one.name == "name plate" for one, _ in task.adds)]
    assert any(one.name == first.name for one, _ in home.adds)


@pytest.mark.parametrize(("machine", "joint"), JOINTS)
def test_sentences_name_only_parts_that_the_joint_has(machine: str, joint: str) -> None:
    chapter = joint_chapter(joint, sizes_of(machine, joint))
    numbers = {one.name: [k] for k, one in enumerate(chapter.components)}
    for step in JOINT_STEPS:
        filled = [fill_sentence(sentence, numbers, chapter.facts) for sentence in step.sentences]
        assert any(filled) or not any(
            re.fullmatch(rule.pattern, one.name) for rule in step.rules for one in chapter.components
        )
        assert not any(mark in text for text in filled if text for mark in "[]{}|")
        single = sizes_of(machine, joint).double is False
        assert not (single and any("hose B" in text for text in filled if text))


def test_screws_are_tightened_to_seven_tenths_of_their_yield() -> None:
    screw = next(one for one in components_of("paper-arm", "small") if one.designation.startswith("ISO 4762 M5"))
    assert tightening(screw) == f"{0.2 * 0.7 * 450e6 * 14.2e-6 * 5e-3:.2g} N m"
    assert tightening(replace(screw, designation="DIN 471 - 10 x 1")) == ""


def test_the_strap_is_adjusted_where_the_hose_is_empty_before_the_stop() -> None:
    sizes = sizes_of("paper-arm", "small")
    facts = joint_chapter("small", sizes).facts
    assert facts["collapsed A"].startswith(f"-{degrees(sizes.stroke / 2):.1f} deg")
    assert float(facts["margin"].split()[0]) == pytest.approx(degrees(sizes.swing - sizes.stroke / 2), abs=0.05)


@pytest.mark.parametrize(
    ("sentence", "expected"),
    [
        ("Turn [nut|the nuts] to {torque}.", "Turn the nuts <b>(7, 8)</b> to 5 N m."),
        ("{?double}Both.", "Both."),
        ("{?single}One.", None),
        ("A [bolt].", None),
        ("A [{kind} of it].", "A cam of it <b>(3)</b>."),
    ],
)
def test_sentences_are_filled_or_left_out(sentence: str, expected: str | None) -> None:
    facts = {"torque": "5 N m", "double": "", "kind": "cam"}
    assert fill_sentence(sentence, {"nut": [7, 8], "cam of it": [3]}, facts) == expected


def test_facts_of_several_sizes_list_them() -> None:
    pair = [one for joint in ("small", "large") for one in components_of("paper-arm", joint) if "end plate" in one.name]
    assert component_facts(pair)["torque screw of an end plate"] == "4.5 N m or 7.6 N m"


@cache
def pages() -> list[Page]:
    pytest.importorskip("OCP")
    return list(chapter_pages(joint_chapter("small", sizes_of("paper-arm", "small")), PARTS, SOLID))


def test_the_steps_need_the_parts_of_the_list() -> None:
    needed: Counter[int] = Counter()
    for page in pages():
        for need in page.needs:
            needed[need.number] += need.quantity
    assert needed == {part.number: part.quantity for part in PARTS.parts}


def test_pictures_are_small_and_have_a_balloon_for_each_part_that_shows() -> None:
    hidden = 0
    for page in pages():
        assert len(page.picture) < 150_000
        tree = ElementTree.fromstring(page.picture)
        balloons = {int(text.text or 0) for text in tree.iter("{http://www.w3.org/2000/svg}text")}
        numbers = {need.number for need in page.needs}
        assert balloons <= numbers
        hidden += len(numbers - balloons)
    assert hidden <= 1


def test_the_page_is_one_file_with_links_for_the_first_start() -> None:
    pytest.importorskip("OCP")
    foot = replace(components_of("paper-arm", "small")[0], name="foot plate")
    components = [*components_of("paper-arm", "small"), foot]
    parts = list_parts(components, mass_by_name)
    sizes = {"small": sizes_of("paper-arm", "small")}
    page = guide_page("Assembly of <arm>", sizes, components, parts, {"First start": "arm-commissioning.html"}, SOLID)
    assert len(page) < 4_000_000
    assert "Assembly of &lt;arm&gt;" in page
    assert '<a href="arm-commissioning.html">First start</a>' in page
    assert page.count("<svg") == len(pages()) + 1
    assert not re.search(r"(src|href)=\"(?!arm-commissioning)", page)


def test_the_arms_chapter_has_what_is_in_no_joint() -> None:
    joint = joint_chapter("small", sizes_of("paper-arm", "small"))
    foot = replace(joint.components[0], name="foot plate")
    chapter = arm_chapter([*joint.components, foot], [joint])
    assert chapter.components == [foot]
    assert len(chapter.there) == len(joint.components)
    assert chapter.steps == ARM_STEPS


def test_joints_of_equal_parts_share_a_chapter() -> None:
    twins = [joint_chapter(name, sizes_of("paper-arm", "small")) for name in ("a", "b")]
    both = list_parts([one for chapter in twins for one in chapter.components], mass_by_name)
    (found,) = _distinct(twins, both)
    assert found.title == "Joint a, b"


def test_every_component_between_joints_has_a_rule() -> None:
    pytest.importorskip("OCP")
    from layflat.solids.assembly import assemble

    assembly = assemble(load("paper-arm"))
    chapter = arm_chapter(assembly.components, [joint_chapter(name, one) for name, one in assembly.sizes.items()])
    patterns = [rule.pattern for step in ARM_STEPS for rule in step.rules]
    assert {one.joint for one in chapter.components} == set(assembly.sizes)
    for one in chapter.components:
        assert any(re.fullmatch(pattern, one.name) for pattern in patterns), one.name
    adds = sum(one.quantity for task in plan_tasks(chapter.components, ARM_STEPS) for one, _ in task.adds)
    assert adds == sum(one.quantity for one in chapter.components)
    assert len(chapter.components) + len(chapter.there) == len(assembly.components)
