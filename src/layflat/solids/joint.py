"""The components of one joint at an angle of its output: frame, hoses, output, brake and angle sensor."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from layflat.design import design_joint
from layflat.design.summary import refuse_errors
from layflat.errors import DesignError
from layflat.solids.brake import brake_components
from layflat.solids.frame import frame_components
from layflat.solids.hoses import hose_components
from layflat.solids.output import output_components
from layflat.solids.section import CrossSection
from layflat.solids.sensor import sensor_components, standoff_components
from layflat.solids.sizes import JointSizes, kept_by_sizes
from layflat.solids.sweep import check_sweep

if TYPE_CHECKING:
    from collections.abc import Iterator

    from layflat.machine import Machine
    from layflat.solids.component import Component


def joint_sizes(machine: Machine, name: str) -> JointSizes:
    """Return the sizes of a joint's parts; raise DesignError if its kind has no solids, or no cam can be made."""
    design = design_joint(machine, name)
    refuse_errors(design.findings)
    return JointSizes(design)


def joint_components(sizes: JointSizes, angle: float = 0.0) -> list[Component]:
    """Return the components of a joint in its own frame, mm, in the order in which they are put together.

    Args:
        sizes: sizes of its parts.
        angle: of the output from mid-stroke, rad.

    Raises:
        DesignError: no size keeps a rule; the message says which value would mend it.
    """
    with _locate_errors(sizes.design.label):
        section, still = _still(sizes)
        return [
            *still,
            *output_components(sizes, angle),
            *hose_components(sizes, section, angle),
            *brake_components(sizes, angle),
            *sensor_components(sizes, angle),
        ]


@kept_by_sizes
def _still(sizes: JointSizes) -> tuple[CrossSection, list[Component]]:
    """Return the cross-section of a joint, and the components that stay where they are."""
    check_sweep(sizes)
    section = CrossSection(sizes)
    return section, [*frame_components(sizes, section), *standoff_components(sizes)]


@contextmanager
def _locate_errors(label: str) -> Iterator[None]:
    """Put a label, of file and joint, before design errors from tables of standard parts, which do not know it."""
    try:
        yield
    except DesignError as error:
        if label in error.where:
            raise
        raise DesignError(error.what, where=f"{label}: {error.where}", right=error.right) from None
