"""Table `gains` of a joint, whose keys the machine's control law defines."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler
from pydantic_core import core_schema

from layflat.control import CONTROL_LAWS
from layflat.description.wrong import value_error
from layflat.errors import MachineError

_law: ContextVar[object] = ContextVar("control law", default=None)


@contextmanager
def gains_of_law(kind: object) -> Iterator[None]:
    """Validate gains in this block as those of a control law, by its name; None: the default law."""
    token = _law.set(kind)
    try:
        yield
    finally:
        _law.reset(token)


def check_papers_law(machine: Any, doing: str) -> None:
    """Raise MachineError if a machine has not the paper's control law, which `doing` (for the message) needs."""
    name = machine.control_law.name
    if name != CONTROL_LAWS.usual:
        raise MachineError(
            f"is {name!r}, but {doing} needs the gains of the paper's law",
            where=f"{machine.origin}: controller.kind",
            right=f'give a machine whose controller is "{CONTROL_LAWS.usual}"',
        )


class _GainsSchema:
    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        choices = {law.name: handler.generate_schema(law.gains) for law in CONTROL_LAWS if law.gains is not None}
        tagged = core_schema.tagged_union_schema(choices, _law_of)
        return core_schema.no_info_before_validator_function(_check_allowed_by_law, tagged)


def _law_of(value: object) -> str:
    """Return the name of the control law of some gains: by their class, or else that of the machine being validated."""
    for law in CONTROL_LAWS:
        if law.gains is not None and isinstance(value, law.gains):
            return law.name
    named = _law.get()
    # An unknown law is reported at the key that names it.
    return str(named) if any(law.name == named for law in CONTROL_LAWS) else CONTROL_LAWS.usual


def _check_allowed_by_law(value: object) -> object:
    """Return the gains; refuse any if the machine's control law has none."""
    name = _law_of(value)
    if any(law.name == name and law.gains is None for law in CONTROL_LAWS):
        raise value_error(f"is not known to the control law {name!r}", "leave it out")
    return value


Gains = Annotated[Any, _GainsSchema()]  # gains of a joint: of the class that the machine's control law names
