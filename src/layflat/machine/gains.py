"""The table `gains` of a joint: what may stand there is said by the machine's control law."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler
from pydantic_core import core_schema

from layflat.control import CONTROL_LAWS
from layflat.description.wrong import wrong
from layflat.errors import MachineError

_law: ContextVar[object] = ContextVar("control law", default=None)


@contextmanager
def gains_of_law(kind: object) -> Iterator[None]:
    """Validate gains as those of a control law, by its name; None: the usual one."""
    token = _law.set(kind)
    try:
        yield
    finally:
        _law.reset(token)


def check_papers_law(machine: Any, doing: str) -> None:
    """Make sure that a machine has the paper's control law, for what is being done; raise MachineError if not."""
    name = machine.control_law.name
    if name != CONTROL_LAWS.usual:
        raise MachineError(
            f"is {name!r}, but {doing} needs the gains of the paper's",
            where=f"{machine.origin}: controller.kind",
            right=f'give a machine whose controller is "{CONTROL_LAWS.usual}"',
        )


class _OfTheLaw:
    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        choices = {law.name: handler.generate_schema(law.gains) for law in CONTROL_LAWS if law.gains is not None}
        tagged = core_schema.tagged_union_schema(choices, _law_of)
        return core_schema.no_info_before_validator_function(_known_to_the_law, tagged)


def _law_of(value: object) -> str:
    for law in CONTROL_LAWS:
        if law.gains is not None and isinstance(value, law.gains):
            return law.name
    named = _law.get()
    # A law that is not known is told where it is named.
    return str(named) if any(law.name == named for law in CONTROL_LAWS) else CONTROL_LAWS.usual


def _known_to_the_law(value: object) -> object:
    name = _law_of(value)
    if any(law.name == name and law.gains is None for law in CONTROL_LAWS):
        raise wrong(f"is not known to the control law {name!r}", "leave it out")
    return value


Gains = Annotated[Any, _OfTheLaw()]  # gains of a joint: of the class that the machine's control law names
