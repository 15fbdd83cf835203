"""Exchangeable kinds: several laws for the same thing, of which a machine's description names one (`kind = "..."`).

A kind is one object that holds all there is to it: what a file says of it, the parameters of its laws, and the laws. A
table holds the kinds of one thing. Code asks the table, so that a further kind is one file and one line, or no line at
all where a user registers one from outside (see docs/kinds.md). A kind that lacks something is refused when it is made.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np
from pydantic import BaseModel, GetCoreSchemaHandler
from pydantic_core import core_schema

from layflat.description import Part
from layflat.description.hints import did_you_mean
from layflat.errors import KindError
from layflat.jit import ByKind, Law, by_kind
from layflat.kind_checks import naming_law, place_of
from layflat.lanes import leaves, mapped

REQUIRED: Any = object()  # stands where a kind has to say something


class KindPart(Part):
    """Base of what files say of a thing that there are several kinds of; each kind adds its own keys."""

    if TYPE_CHECKING:
        kind: str

        def __getattr__(self, key: str) -> Any: ...


@dataclass(frozen=True, kw_only=True)
class Kind:
    """Base of all kinds.

    Raises:
        KindError: something is missing, by name.
    """

    LAWS: ClassVar[tuple[str, ...]] = ()  # entries that have to be laws, which the compiler takes

    CALLED: ClassVar[tuple[str, ...]] = ()  # entries that have to be functions, compiled or not

    name: str = REQUIRED  # what stands behind `kind =` in a file
    description: type[BaseModel] = REQUIRED  # what a file says of it, with a field `kind: Literal[name]`
    parameters: Callable[..., Any] = REQUIRED
    """From what is described to the parameters of the laws (named tuples of floats)."""
    parameter_types: tuple[type, ...] = REQUIRED
    """The named tuple classes that `parameters` may yield; they are the kind's own."""

    def __post_init__(self) -> None:
        """Refuse a kind that is not whole."""
        missing = [entry.name for entry in fields(self) if getattr(self, entry.name) is REQUIRED]
        if missing:
            raise KindError(f"kind {self.name!r} lacks {', '.join(missing)}", where=type(self).__name__)
        for entry in ("parameters", *self.CALLED):
            if not callable(getattr(self, entry)):
                what = f"{entry} of kind {self.name!r} is no function"
                raise KindError(what, where=type(self).__name__, right="give a function")
        types = self.parameter_types
        if not isinstance(types, tuple) or not types or not all(isinstance(one, type) for one in types):
            what = f"parameter_types of kind {self.name!r} is no tuple of named tuple classes"
            raise KindError(what, where=type(self).__name__, right="give such as (Relay,)")
        for entry in self.LAWS:
            if not isinstance(getattr(self, entry), Law | ByKind):
                raise KindError(
                    f"{entry} of kind {self.name!r} is not a law",
                    where=type(self).__name__,
                    right="decorate it with layflat.jit.law",
                )
        if not (isinstance(self.description, type) and issubclass(self.description, BaseModel)):
            what = f"description of kind {self.name!r} is no class of a described part"
            raise KindError(what, where=type(self).__name__, right="give a class with a base such as ControllerPart")
        field = self.description.model_fields.get("kind")
        if field is None or self.name not in getattr(field.annotation, "__args__", ()):
            raise KindError(
                f"the description of kind {self.name!r} does not bear its name",
                where=type(self).__name__,
                right=f'give {self.description.__name__} a field kind: Literal["{self.name}"]',
            )

    def try_laws(self, parameters: Any, *described: Any) -> None:  # noqa: ARG002
        """Call the laws of a kind from outside once, as plain Python, and check what they return.

        Args:
            parameters: of its laws, for one machine.
            described: what these were made of.

        Raises:
            KindError: a law fails, or returns what it may not.
        """
        return

    def guarded(self) -> "Kind":
        """Return the kind with laws that return not a number, which ends a run, where they return what they may not.

        It is asked of kinds from outside alone, since the laws of the package return what they should.
        """
        return self

    def entries(self) -> Mapping[type, Any]:
        """Return the holder of the laws by class of the parameters."""
        return dict.fromkeys(self.parameter_types, self)


K = TypeVar("K", bound=Kind)


def _names(types: Iterable[type]) -> str:
    return " or ".join(one.__name__ for one in types)


def _misfit(kind: Kind, what: str, right: str) -> KindError:
    return KindError(f"`parameters` of kind {kind.name!r} {what}", where=place_of(kind.parameters), right=right)


class Table(Generic[K]):
    """The kinds of one thing, by name.

    Args:
        thing: what they are kinds of, for messages.
        kinds: those that are built in; the first is meant where a file names none.
    """

    registered: ClassVar[int] = 0  # kinds in all tables: what is built from tables is stale once it changes

    def __init__(self, thing: str, *kinds: K) -> None:
        self.thing, self.usual = thing, kinds[0].name
        self._kinds: dict[str, K] = {}
        self._choices: dict[Callable[[Any], Any], dict[type, Any]] = {}
        self._tried: dict[str, Any] = {}  # parameters with which kinds from outside were tried last, by name
        self._from_outside = False
        for kind in kinds:
            self.register(kind)
        self._from_outside = True

    def __iter__(self) -> Iterator[K]:
        """All kinds, as they were registered."""
        return iter(self._kinds.values())

    def register(self, kind: K) -> K:
        """Add a kind; raise KindError if there is one of this name, or one with the same class of parameters."""
        if kind.name in self._kinds:
            raise KindError(f"there is a kind {kind.name!r} of {self.thing} already", where="kinds")
        taken = [other.__name__ for other in kind.parameter_types if self._owner(other) is not None]
        if taken:
            raise KindError(f"{taken[0]} holds the parameters of another kind of {self.thing}", where=kind.name)
        self._kinds[kind.name] = kind
        if self._from_outside:
            self._tried[kind.name] = None
        Table.registered += 1
        for find, laws in self._choices.items():
            laws.update({cls: find(entry) for cls, entry in self._entries(kind)})
        return kind

    def _entries(self, kind: K) -> Iterable[tuple[type, Any]]:
        """Return what holds the laws that are run, by class of the parameters."""
        return (kind.guarded() if self.is_from_outside(kind) else kind).entries().items()

    def named(self, name: object) -> K:
        """The kind of a name; raise KindError if there is none; names the known ones and the nearest."""
        if isinstance(name, str) and name in self._kinds:
            return self._kinds[name]
        raise KindError(
            f"{name!r} is not a kind of {self.thing}", right=did_you_mean(name, list(self._kinds), "known kinds are {}")
        )

    def parameters(self, described: Any, *others: Any) -> Any:
        """Parameters of the laws for what is described, by the kind that it names.

        Raises:
            KindError: they are not what the kind says that they are.
        """
        kind = self.named(described.kind)
        if kind.name in self._tried:
            with naming_law(f"{self.thing} {kind.name!r}", "parameters", kind.parameters):
                found = kind.parameters(described, *others)
        else:
            found = kind.parameters(described, *others)
        if type(found) not in kind.parameter_types:
            raise _misfit(kind, f"yields {type(found).__name__}", f"give {_names(kind.parameter_types)}")
        for leaf in leaves(found):
            if isinstance(leaf, bool) or (not isinstance(leaf, (int, float)) and not hasattr(leaf, "dtype")):
                raise _misfit(kind, f"yields {leaf!r} among its numbers", "give floats in SI units")
        if kind.name in self._tried:
            self._try(kind, found, described, *others)
        return found

    def _try(self, kind: K, parameters: Any, *described: Any) -> None:
        """Try the laws of a kind from outside, unless they were tried with these parameters; of many the first."""
        single = mapped(parameters, lambda leaf: leaf if np.ndim(leaf) == 0 else np.ravel(leaf)[0])
        if any(leaf != leaf for leaf in leaves(single)):  # noqa: PLR0124
            raise _misfit(kind, "yields a number that is none (nan)", "give floats in SI units")
        shown = repr(single)  # exact, and comparable whatever numbers it holds
        if self._tried[kind.name] != shown:
            kind.try_laws(single, *described)
            self._tried[kind.name] = shown

    def is_from_outside(self, kind: K) -> bool:
        """Return whether a kind was registered later than those that are built in."""
        return kind.name in self._tried

    def of(self, parameters: Any) -> K:
        """The kind that parameters belong to."""
        owner = self._owner(type(parameters))
        if owner is None:
            raise KindError(f"{type(parameters).__name__} belongs to no kind of {self.thing}", where="kinds")
        return owner

    def _owner(self, cls: type) -> K | None:
        return next((kind for kind in self if cls in kind.parameter_types), None)

    def law(self, find: str | Callable[[Any], Any]) -> Callable[..., Any]:
        """A law that picks its implementation by its first argument, the parameters of a kind.

        Args:
            find: name of the law in a kind, or what yields it from what holds a kind's laws.
        """
        finder: Callable[[Any], Any] = (lambda entry: getattr(entry, find)) if isinstance(find, str) else find
        laws = {cls: finder(entry) for kind in self for cls, entry in self._entries(kind)}
        self._choices[finder] = laws
        return by_kind(laws)


@dataclass(frozen=True)
class AnyOf:
    """Annotation of a described part that may be of any kind in a table.

    A class with such a field is rebuilt (`model_rebuild(force=True)`) once another kind is registered.
    """

    table: Table[Any]
    but: str = ""  # name of a kind that may not stand there

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Validate what stands there by the kind that it names."""
        kinds = [kind for kind in self.table if kind.name != self.but]
        choices = {kind.name: handler.generate_schema(kind.description) for kind in kinds}
        return core_schema.tagged_union_schema(choices, self._named)

    def _named(self, value: object) -> object:
        return value.get("kind", self.table.usual) if isinstance(value, dict) else getattr(value, "kind", None)
