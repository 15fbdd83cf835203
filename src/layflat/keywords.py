"""Signatures of functions that pass keyword arguments on: with all keywords, for help and completion."""

from collections.abc import Callable
from inspect import Parameter, signature
from typing import Any, TypeVar

AnyFunction = TypeVar("AnyFunction", bound=Callable[..., Any])


def with_keywords_of(described: Callable[..., Any]) -> Callable[[AnyFunction], AnyFunction]:
    """Return a decorator that writes out a function's `**` in its signature: the parameters of a callable, as keywords.

    Parameters that the function has itself are not repeated. How it is called does not change.
    """

    def decorate(function: AnyFunction) -> AnyFunction:
        own = signature(function)
        shown = [one for one in own.parameters.values() if one.kind is not Parameter.VAR_KEYWORD]
        known = {one.name for one in shown}
        further = [one for one in signature(described).parameters.values() if one.name not in known]
        shown += [one.replace(kind=Parameter.KEYWORD_ONLY) for one in further]
        function.__signature__ = own.replace(parameters=shown)  # type: ignore[attr-defined]
        return function

    return decorate
