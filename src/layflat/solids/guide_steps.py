"""Steps in which a joint is put together: components, directions from which they come, and instructions.

In a sentence, [name] or [name|words] stands for a component with its number in the parts list, {fact} for a value, and
{?fact} for a condition; a sentence is left out for a joint that has not all of them. {kind} is cam or roller.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from layflat.solids.explosion import Direction

FRONT_VIEW = (0.55, 1.0, 0.5)  # direction to the eye: the output is in front, the angle sensor above
BACK_VIEW = (0.6, -1.0, 0.55)  # the clamp of the hoses is in front
BELOW_VIEW = (0.6, 1.0, -0.6)


class Rule(NamedTuple):
    """Components of a step by a pattern of their names, and the direction from which they come."""

    pattern: str
    direction: Direction
    follows: str = ""  # component of the step that takes them along
    parts: tuple[int, int] = (0, 999)  # first, and after the last: parts of one component that come one after another


class Step(NamedTuple):
    """Step of an assembly."""

    title: str
    rules: tuple[Rule, ...]
    sentences: tuple[str, ...]
    view: tuple[float, float, float] = FRONT_VIEW
    apart: bool = False  # an assembly of its own, which a later step brings in
    brings: tuple[str, Direction] | None = None  # title of an earlier step, and from where its assembly comes


JOINT_STEPS = (
    Step(
        "End plates",
        (
            Rule("(lower|upper) end plate", ""),
            Rule("bush", "in"),
            Rule("stud of a bump stop", "in"),
            Rule("bump stop", "in"),
            Rule("standoff", "+z"),
            Rule("lower screw of a standoff", "head"),
        ),
        (
            "Press a [bush] into the [lower end plate] and the [upper end plate], each from its inner face: the "
            "flange lies between plate and output.",
            "Screw the [stud of a bump stop|studs of the bump stops] into their threads with threadlocker, level "
            "with the outer faces, and push a [bump stop|rubber sleeve] over each.",
            "Screw the [standoff|standoffs] on the upper end plate from inside with [lower screw of a "
            "standoff|screws {thread lower screw of a standoff}], to {torque lower screw of a standoff}.",
        ),
        apart=True,
    ),
    Step(
        "Hoses",
        (
            Rule("cylinder", ""),
            Rule("hose [AB]", "-y"),
            Rule("hinge of hose [AB]", "-y"),
            Rule("clamp bar", "+z"),
            Rule("washer of the clamp", "head", "clamp bar"),
            Rule("screw of the clamp", "head", "clamp bar"),
            Rule("nut of the clamp", "head", "clamp bar"),
            Rule("inlet of hose [AB]", "+z"),
        ),
        (
            "Cut [hose A]: {size hose A}.",
            "Cut [hose B]: {size hose B}.",
            "{?folded}Fold each hose in the middle of its length: both ends come into the clamp, the fold to the "
            "shell's end.",
            "Lay hose A, both hinges ([hinge of hose A|A], [hinge of hose B|B]) and hose B on each other with their "
            "ends level, and punch the holes of the screws with a [clamp bar] as the template.",
            "{?single}Lay hose and [hinge of hose A|hinge] on each other with their ends level, and punch the holes "
            "of the screws with a [clamp bar] as the template.",
            "Put the [inlet of hose A|inlet] into each hose: its stem comes through a hole in the inner wall "
            "and through the cylinder, its nut and elbow sit inside the cylinder.",
            "Push the ends from outside through the slot of the [cylinder], put a [clamp bar] on either side, and "
            "tighten [screw of the clamp|screws {thread screw of the clamp}] and [nut of the clamp|nuts], with "
            "[washer of the clamp|washers] below both, crosswise "
            "in three rounds, to {torque screw of the clamp} in the last one.",
            "Blow each hose up to 0.5 bar and brush soapy water on the clamp: no bubbles may grow.",
        ),
        view=BACK_VIEW,
    ),
    Step(
        "Frame",
        (Rule("tie bar", "+z"), Rule("washer of an end plate", "head"), Rule("screw of an end plate", "head")),
        (
            "Stand the [tie bar|tie bars] in the cylinder; set both end plates against it, with bushes and bump "
            "stops inside and the holes over the ends of clamp bars and tie bars.",
            "Turn in all [screw of an end plate|screws {thread screw of an end plate}] with their "
            "[washer of an end plate|washers] by hand, lay the frame on a "
            "flat table until it does not rock, and tighten them to {torque screw of an end plate}.",
        ),
        brings=("End plates", "out"),
    ),
    Step(
        "Output",
        (
            Rule("(cam|roller) of hose A", ""),
            Rule("spacer", "out", parts=(0, 2)),
            Rule("(cam|roller) of hose B", "out"),
            Rule("spacer", "out", parts=(2, 999)),
            Rule("arm plate", "out"),
            Rule("rod of the output", "+z"),
            Rule("nut of the output", "head"),
        ),
        (
            "Stack from the middle out, on the [shaft] as a gauge: [{kind} of hose A], [spacer|spacers], [{kind} of "
            "hose B|the halves for hose B] turned over, more spacers, and [arm plate|arm plates].",
            "{?single}Stack from the middle out, on the [shaft] as a gauge: [{kind} of hose A], [spacer|spacers], "
            "and [arm plate|arm plates].",
            "Push the [rod of the output|threaded rods] through, and tighten [nut of the output|the nuts] on both "
            "ends to {torque nut of the output} while the shaft still turns easily in all bores. Take the shaft out "
            "again.",
        ),
        apart=True,
    ),
    Step(
        "Output in the frame",
        (Rule("retaining ring", "+y"), Rule("shaft", "+z")),
        (
            "Hold the output in the window, arm outwards. Wet the bores of cams and arm plates with retaining "
            "compound (shear strength of 15 N/mm2 or more by ISO 10123): it carries the brake's torque from the "
            "shaft.",
            "Push the [shaft] from above through bush, [retaining ring], output, second ring and lower bush, and "
            "snap the rings into place. Keep the compound out of the bushes; wait as long as its data sheet says.",
            "Turn the output by hand from stop to stop, {limit} to either side: it moves freely and touches only the "
            "bump stops.",
        ),
        brings=("Output", "+y"),
    ),
    Step(
        "Shells and straps",
        (
            Rule("shell [AB]", "side"),
            Rule("outer inlet of hose [AB]", "side"),
            Rule("bar of shell [AB]", "side"),
            Rule("strap of hose [AB]", "+y"),
            Rule("strap clamp on shell [AB]", "side"),
            Rule("screw of the strap clamp on shell [AB]", "side"),
            Rule("strap clamp on the (cam|roller) of hose [AB]", "+y"),
            Rule("screw of the strap clamp on the (cam|roller) of hose [AB]", "+y"),
        ),
        (
            "{?double}Glue or rivet the free lap of each hinge to its shell ([shell A|A], [shell B|B]), so that the "
            "shell lies on the empty hose.",
            "{?single}Glue or rivet the free lap of the hinge to the [shell A|shell], so that the shell lies on the "
            "empty hose.",
            "Lead the stem of each [outer inlet of hose A|inlet] through its shell, and put nut and barb on.",
            "Put the [bar of shell A|bar] under the end of each shell, threads in line with its holes.",
            "Cut the straps with 15 mm to spare: [strap of hose A|hose A] {size strap of hose A}. Strip has sharp "
            "edges: wear gloves, and break them with a stone.",
            "Clamp each strap on the output first: [strap clamp on the {kind} of hose A|clamp] with [screw of the "
            "strap clamp on the {kind} of hose A|screws {thread screw of the strap clamp on the {kind} of hose A}], "
            "to {torque screw of the strap clamp on the {kind} of hose A}.",
            "{?double}The strap of hose B has two strips, one on either side of that of hose A: [strap clamp on the "
            "{kind} of hose B|clamps], [screw of the strap clamp on the {kind} of hose B|screws].",
            "Adjust the [strap of hose A]: turn the output to {collapsed A}, pull the strap tight over the end of "
            "the shell until the shell lies flat on the empty hose, and tighten its [strap clamp on shell A|clamp] "
            "with [screw of the strap clamp on shell A|screws {thread screw of the strap clamp on shell A}] to "
            "{torque screw of the strap clamp on shell A}.",
            "Do the same for the [strap of hose B] at {collapsed B}, with both strips equally tight ([strap clamp on "
            "shell B|clamps]).",
            "Check: as the output turns on to the bump stop at {limit}, the shell begins to press the empty hose "
            "{margin} before the stop. If the stop comes first, the strap is too long.",
        ),
    ),
    Step(
        "Brake",
        (
            Rule("brake pad", "-z", parts=(0, 1)),
            Rule("brake disc", "-z"),
            Rule("set screw of the disc", "head", "brake disc"),
            Rule("brake pad", "-z", parts=(1, 2)),
            Rule("stud of the brake", "-z"),
            Rule("brake beam", "-z"),
            Rule("brake cylinder", "-z"),
            Rule("bridge of the brake", "-z"),
            Rule("brake spring", "-z"),
            Rule("washer of a brake spring", "-z"),
            Rule("nut of the brake", "-z"),
        ),
        (
            "Glue one [brake pad] on the lower end plate, the other one on the [brake beam].",
            "Screw the [stud of the brake|studs] into the end plate with threadlocker.",
            "Push the [brake disc] on the shaft until it touches the pad, and tighten its [set screw of the disc|set "
            "screw] with threadlocker.",
            "Put on the beam with its pad, [brake spring|springs] and [washer of a brake spring|washers], and turn "
            "the [nut of the brake|nuts] evenly: springs {size brake spring}.",
            "Put on beam, [brake cylinder|cylinder] and [bridge of the brake|bridge], and turn the [nut of the "
            "brake|nuts] until the disc just turns freely without air.",
            "Measure the torque at which the output slips with a spring balance on the arm: {slip}, within a tenth.",
        ),
        view=BELOW_VIEW,
    ),
    Step(
        "Angle sensor",
        (
            Rule("coupling", "+z"),
            Rule("set screw of the coupling", "head", "coupling"),
            Rule("sensor plate", "+z"),
            Rule("upper screw of a standoff", "+z"),
            Rule("angle sensor", "+z"),
        ),
        (
            "Clamp the [coupling] on the shaft with one [set screw of the coupling|set screw].",
            "Fix the [angle sensor] ({size angle sensor}) on the [sensor plate], put both on the standoffs and "
            "tighten the [upper screw of a standoff|screws {thread upper screw of a standoff}] to {torque upper "
            "screw of a standoff}.",
            "With the output in mid-stroke and the sensor in the middle of its track, tighten the second set screw.",
        ),
    ),
)
"""Steps of a joint, in order."""

ARM_STEPS = (
    Step(
        "Foot",
        (
            Rule("distance tube of the foot", "tail"),
            Rule("foot plate", "tail"),
            Rule("stud of the foot", "tail"),
            Rule("nut of the foot", "head"),
        ),
        (
            "Screw the [stud of the foot|studs] into the lower end plate of the first joint with threadlocker.",
            "Put on the [distance tube of the foot|distance tubes] and the [foot plate], and tighten the [nut of the "
            "foot|nuts] to {torque nut of the foot}. Bolt the foot plate to a table that bears the arm's torque.",
        ),
    ),
    Step(
        "Links",
        (
            Rule("strut.*", ""),
            Rule("tool flange", ""),
            Rule("distance tube of the arm", ""),
            Rule("stud of the arm", "head"),
            Rule("nut of the arm", "head"),
            Rule("screw of a strut", "head"),
            Rule("nut of a strut", "head"),
        ),
        (
            "Put the [distance tube of the arm|distance tubes] on [stud of the arm|studs] between the arm plates; "
            "tighten [nut of the arm|their nuts] to {torque nut of the arm}.",
            "Bolt the struts to arm plates and tongues with [screw of a strut|screws] and [nut of a strut|nuts], two "
            "at each end, to {torque screw of a strut}; tighten them when all are in place.",
            "Bolt the [tool flange] to the last struts in the same way.",
        ),
    ),
)
"""Steps of an arm whose joints are put together, in order."""
