"""Time loops with a control law that may be plain Python."""

from collections.abc import Callable
from typing import Any

from layflat.control.kind import ControlKind
from layflat.jit.outside import blame_outside


def running(law: ControlKind, loop: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel that is a time loop, such that it runs a law: compiled, or in Python for a law that is plain Python."""
    function = loop if law.compiled else getattr(loop, "py_func", loop)

    def run(*args: Any) -> Any:
        with blame_outside():
            return function(*args)

    return run
