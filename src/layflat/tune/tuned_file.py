"""Gains that were found, as a description that extends the one they were found for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from layflat.description.change import value_at
from layflat.description.provenance import Provenance
from layflat.machine import Machine
from layflat.machine.derived import write_derived
from layflat.tune.knobs import INTEGRAL_LIMIT, Knob


def write_tuned(
    given: str, base: Machine, knobs: Sequence[Knob], values: Sequence[float], note: str, path: Path
) -> Machine:
    """Write the gains and load what was written.

    Args:
        given: built-in name or file of the base.
        base: the machine that it describes, which may lack gains.
        knobs: what was turned.
        values: in the knobs' units.
        note: how they were found.
        path: from `derived_path`.

    Raises:
        OutputError: it can't be written there.
    """
    texts = {knob.paths[0]: str(knob.text(value)) for knob, value in zip(knobs, values, strict=True)}
    sources = dict.fromkeys(texts, Provenance("calibrated", note))
    for name in base.joints:
        if base.joint[name].gains is None:
            limit = f"joint.{name}.gains.integral_limit"
            texts[limit] = f"{INTEGRAL_LIMIT * value_at(base, 'valve.volts_to_full'):g} V"
            sources[limit] = Provenance("assumed", f"{100 * INTEGRAL_LIMIT:g} % of full opening")
    return write_derived(given, f"{base.title}, tuned", texts, sources, path)
