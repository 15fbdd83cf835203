"""Pages about FMUs: one in each archive, and one beside them."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from layflat._version import __version__
from layflat.export.fmu.model import FmuModel
from layflat.export.templates import fill_template


class FmuFile(NamedTuple):
    """FMU in the folder."""

    name: str
    content: str  # parts of the machine
    version: str  # of FMI
    size: int  # kB


def documentation_page(model: FmuModel, version: str, title: str) -> bytes:
    """Return documentation/index.html of an FMU.

    Args:
        model: the model.
        version: "2.0" or "3.0".
        title: description of the model.
    """
    variables = [variable for _, variable in model.variables]
    tables = [(use.title() + "s", [one for one in variables if one.use == use]) for use in ("input", "output")]
    fixed = sum(one.use == "fixed" for one in variables) + (2 if model.has_plant else 0)  # with seed and noise
    text = fill_template(
        "fmu_index.html", title=title, version=__version__, fmi=version, rules=[*usage_rules(model)], tables=tables,
        parameters=sum(one.use == "tunable" for one in variables) + fixed, fixed=fixed,
    )  # fmt: skip
    return text.encode()


def folder_page(model: FmuModel, files: Iterable[FmuFile], systems: Sequence[str]) -> str:
    """Return the page of a folder of FMUs.

    Args:
        model: the model of the whole machine.
        files: the FMUs.
        systems: titles of the systems that they run on.
    """
    *others, last = systems
    return fill_template(
        "fmu_readme.md", title=model.machine.name, version=__version__, files=[*files],
        systems=f"{', '.join(others)} and {last}" if others else last, rules=[*usage_rules(model)],
    )  # fmt: skip


def usage_rules(model: FmuModel) -> Iterator[str]:
    """Yield what a user of an FMU has to know, a sentence or two each."""
    cycle, step = 1e3 * model.plant.cycle, 1e3 * model.plant.cycle / model.plant.steps
    yield f"A control cycle lasts {cycle:g} ms. A step is a multiple of {step:g} ms, from the end of the last."
    if model.has_plant:
        yield "Inputs act from the next control cycle on, loads at once."
        yield "The sensors have the noise of a simulation run with the same seed; the parameter noise switches it off."
    else:
        yield "Inputs act from the next control cycle on; the law wakes at the readings that are set before the steps."
    if model.has_control:
        yield "Voltages and signals of the control law are those of the cycle that has ended."
    yield "Plant and control law as two FMUs repeat those in one, bit for bit, if the control law steps first."
    yield "Wrong values, steps and calls out of order return an error with a message."
