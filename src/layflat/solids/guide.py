"""Assembly guide: an HTML page to be printed, with an exploded picture of each step."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from markupsafe import Markup, escape

from layflat.plot import render_page
from layflat.solids import cad
from layflat.solids.explosion import Moving, explode
from layflat.solids.guide_steps import ARM_STEPS, JOINT_STEPS, Rule, Step
from layflat.solids.guide_text import component_facts, fill_sentence, joint_facts, tightening
from layflat.solids.joint import joint_components
from layflat.solids.kernel import placed
from layflat.solids.line_drawing import DrawnBody, draw, find_lines, prepare

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from layflat.solids.component import Component
    from layflat.solids.parts_list import PartsList
    from layflat.solids.shapes import Shape
    from layflat.solids.sizes import JointSizes

    SolidMaker = Callable[[Component], Any]


MAX_RULES = 99  # of a step


@dataclass(frozen=True)
class Chapter:
    """Assembly that is put together by steps, in a frame of its own."""

    title: str
    components: Sequence[Component]  # in the order of assembly
    steps: Sequence[Step]
    facts: Mapping[str, str]  # values for sentences
    there: Sequence[Component] = ()  # components that are put together already


class Need(NamedTuple):
    """Parts that a step needs."""

    number: int
    quantity: int
    name: str
    detail: str  # designation of bought parts, size of made ones
    torque: str  # to which screws and nuts are tightened


@dataclass(frozen=True)
class Page:
    """Step as it stands in the guide."""

    title: str
    needs: tuple[Need, ...]
    sentences: tuple[Markup, ...]
    picture: Markup


@dataclass(frozen=True)
class StepTask:
    """Step with the components that it adds."""

    step: Step
    adds: tuple[tuple[Component, Rule], ...]


def plan_tasks(components: Iterable[Component], steps: Sequence[Step]) -> list[StepTask]:
    """Return the steps with their components: each stands in one step, one without a rule in that of the one before.

    Args:
        components: in the order of assembly.
        steps: with rules for names.
    """
    rows: dict[str, list[tuple[int, Component, Rule]]] = {step.title: [] for step in steps}
    title = steps[0].title
    for one in components:
        rules = [(step.title, k, rule) for step in steps for k, rule in enumerate(step.rules)
                 if re.fullmatch(rule.pattern, one.name)]  # fmt: skip
        if not rules:
            unknown = Rule(re.escape(one.name), "out" if one.group == "body" else "side")
            rows[title].append((MAX_RULES, one, unknown))
        for title, k, rule in rules:
            places = one.places[slice(*rule.parts)]
            if places:
                rows[title].append((k, replace(one, places=places), rule))
    ordered = {title: sorted(row, key=lambda entry: entry[0]) for title, row in rows.items()}
    return [StepTask(step, tuple((one, rule) for _, one, rule in ordered[step.title])) for step in steps
            if ordered[step.title]]  # fmt: skip


def joint_chapter(name: str, sizes: JointSizes) -> Chapter:
    """Return the chapter of a joint, in its frame and mid-stroke; arguments: its name, sizes of its parts."""
    components = [replace(one, joint=name) for one in joint_components(sizes)]
    return Chapter(f"Joint {name}", components, JOINT_STEPS, component_facts(components) | joint_facts(sizes))


def arm_chapter(components: Sequence[Component], joints: Sequence[Chapter]) -> Chapter:
    """Return the chapter of what is in no joint: foot, links and tool flange, in the frame of the base.

    Args:
        components: of the whole assembly.
        joints: chapters of its joints.
    """
    names = {one.name for chapter in joints for one in chapter.components}
    added = [one for one in components if one.name not in names]
    there = [one for one in components if one.name in names]
    return Chapter("Arm", added, ARM_STEPS, component_facts(added), there)


def chapter_pages(chapter: Chapter, parts: PartsList, solid: SolidMaker) -> Iterator[Page]:
    """Yield the steps of a chapter with their pictures. Needs the extra `cad`.

    Args:
        chapter: the assembly.
        parts: the parts list that has its components.
        solid: function that returns the solid of a component in its own frame.
    """
    numbers: dict[str, list[int]] = {}
    for one in chapter.components:
        number, known = parts.part(one).number, numbers.setdefault(one.name, [])
        known += [number] * (number not in known)
    tasks = plan_tasks(chapter.components, chapter.steps)
    there, prepared = list(chapter.there), set[int]()

    def drawable(component: Component) -> Any:
        body = solid(component)
        if id(body) not in prepared:
            prepare(body)
            prepared.add(id(body))
        return body

    for task in tasks:
        step = task.step
        brought = next((other for other in tasks if step.brings and other.step.title == step.brings[0]), None)
        moving = _moving(task, brought)
        picture = _picture([] if step.apart else there, moving, parts, step, drawable)
        sentences = (fill_sentence(sentence, numbers, chapter.facts) for sentence in step.sentences)
        yield Page(step.title, tuple(_needs(task, parts)), tuple(filter(None, sentences)), picture)
        if not step.apart:
            there += [one.component for one in moving]


def _moving(task: StepTask, brought: StepTask | None) -> list[Moving]:
    """Return the components of a step that move; those of an assembly that it brings in, as one block."""
    adds = [Moving(one, rule.direction, rule.follows) for one, rule in task.adds]
    if brought is None or task.step.brings is None:
        return adds
    title, direction = task.step.brings
    block = [Moving(one, direction, block=title) for one, _ in brought.adds]
    inside = [one for one in adds if direction == "out" and one.direction == "+z"]  # bars between the end plates
    return [*inside, *block, *(one for one in adds if one not in inside)]


def _picture(
    there: Sequence[Component], moving: Sequence[Moving], parts: PartsList, step: Step, solid: SolidMaker
) -> Markup:
    """Return the exploded picture of a step.

    Args:
        there: components that are in place.
        moving: components of the step; blocks have no balloons.
        parts: the parts list.
        step: the step.
        solid: function that returns the solid of a component, with triangles for drawings.
    """
    bodies = [DrawnBody(placed(solid(one), at), faint=True) for one in there for at in one.places]
    for one, places in zip(moving, explode(there, moving), strict=True):
        number = 0 if one.block else parts.part(one.component).number
        bodies += [DrawnBody(placed(solid(one.component), at), number) for at in places]
    find_lines(bodies, step.view)
    return Markup(draw(bodies, str(escape(step.title))))  # drawn here


def _needs(task: StepTask, parts: PartsList) -> Iterator[Need]:
    """Yield the parts of a step, each number once."""
    quantities: dict[int, int] = {}
    first: dict[int, Component] = {}
    for one, _ in task.adds:
        number = parts.part(one).number
        quantities[number] = quantities.get(number, 0) + one.quantity
        first.setdefault(number, one)
    for number, one in sorted(first.items()):
        part = parts.part(one)
        yield Need(number, quantities[number], one.name, part.material if part.bought else f"{part.stock}: {part.size}",
                   tightening(one))  # fmt: skip


def guide_page(
    title: str,
    sizes: Mapping[str, JointSizes],
    components: Sequence[Component],
    parts: PartsList,
    links: Mapping[str, str],
    solid: SolidMaker | None = None,
) -> str:
    """Return the assembly guide as an HTML page in one file. Needs the extra `cad`.

    Args:
        title: of the page.
        sizes: sizes of each joint's parts by its name, from base to tip.
        components: of the whole assembly, in the frame of the base.
        parts: parts list of the whole assembly.
        links: addresses of documents for the first start, by their titles.
        solid: function that returns the solid of a component in its own frame; default: each is made once.
    """
    made: dict[Shape, Any] = {}

    def make(component: Component) -> Any:
        if component.shape not in made:
            made[component.shape] = cad.solid(component.shape)
        return made[component.shape]

    joints = [joint_chapter(name, one) for name, one in sizes.items()]
    chapters = [*_distinct(joints, parts), arm_chapter(components, joints)]
    pages = {
        chapter.title: list(chapter_pages(chapter, parts, solid or make)) for chapter in chapters if chapter.components
    }
    return render_page("layflat.solids", "guide.html.j2", title=title, chapters=pages, links=links)


def _distinct(joints: Iterable[Chapter], parts: PartsList) -> list[Chapter]:
    """Return chapters, one for all joints of equal parts."""
    found: dict[tuple[tuple[str, int], ...], Chapter] = {}
    for chapter in joints:
        key = tuple((one.name, parts.part(one).number) for one in chapter.components)
        if key in found:
            title = f"{found[key].title}, {chapter.title.removeprefix('Joint ')}"
            found[key] = replace(found[key], title=title)
        else:
            found[key] = chapter
    return list(found.values())
