"""Exchangeable kinds: several laws for the same thing, of which a machine's description names one (`kind = "..."`).

A kind is one object with its description class, the parameters of its laws, and the laws. A table holds the kinds of
one thing. Code looks kinds up in the table, so that a further kind is one file and one line, or no line at all where a
user registers one (see docs/kinds.md). An incomplete kind is refused when it is constructed.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from pydantic import BaseModel, GetCoreSchemaHandler
from pydantic_core import core_schema

from layflat.description import Part
from layflat.description.wrong import did_you_mean
from layflat.errors import KindError
from layflat.jit import ByKind, Law, by_kind
from layflat.kind_checks import naming_law, place_of
from layflat.lanes import leaves, mapped
from layflat.lazy import numpy as np

REQUIRED_ENTRY: Any = object()  # default of an entry that a kind has to define


class KindPart(Part):
    """Base of descriptions of a thing with several kinds; each kind adds its own keys."""

    if TYPE_CHECKING:
        kind: str

        def __getattr__(self, key: str) -> Any: ...


@dataclass(frozen=True, kw_only=True)
class Kind:
    """Base of all kinds.

    Raises:
        KindError: an entry is missing or of a wrong type.
    """

    LAWS: ClassVar[tuple[str, ...]] = ()  # entries that have to be laws (compiled)

    CALLED: ClassVar[tuple[str, ...]] = ()  # entries that have to be functions, compiled or not

    name: str = REQUIRED_ENTRY  # value of `kind` in a file
    description: type[BaseModel] = REQUIRED_ENTRY  # description class, with a field `kind: Literal[name]`
    parameters: Callable[..., Any] = REQUIRED_ENTRY
    """Function from a description to the parameters of the laws (named tuples of floats)."""
    parameter_types: tuple[type, ...] = REQUIRED_ENTRY
    """Named tuple classes that `parameters` may return; no other kind may have them."""

    def __post_init__(self) -> None:
        """Raise KindError if an entry is missing or of a wrong type, or the description's `kind` is not the name."""
        missing = [entry.name for entry in fields(self) if getattr(self, entry.name) is REQUIRED_ENTRY]
        if missing:
            what = f"kind {self.name!r} lacks {', '.join(missing)}"
            raise KindError(what, where=type(self).__name__, right="give them as keyword arguments")
        for entry in ("parameters", *self.CALLED):
            if not callable(getattr(self, entry)):
                what = f"{entry} of kind {self.name!r} is no function"
                raise KindError(what, where=type(self).__name__, right="give a function")
        types = self.parameter_types
        if not isinstance(types, tuple) or not types or not all(isinstance(cls, type) for cls in types):
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
        """Call the laws of a user's kind once, as plain Python, and check their results; the base class does nothing.

        Args:
            parameters: of its laws, for one machine.
            described: descriptions that the parameters were computed from.

        Raises:
            KindError: a law fails, or returns a wrong result.
        """
        return

    def guarded(self) -> "Kind":
        """Return the kind with laws that return nan, which ends a run, in place of wrong values; by default itself.

        Only users' kinds are guarded, since the laws of the package are tested.
        """
        return self

    def laws_by_parameter_type(self) -> Mapping[type, Any]:
        """Return the objects with the compiled laws, by type of the laws' parameters."""
        return dict.fromkeys(self.parameter_types, self)


K = TypeVar("K", bound=Kind)


def _names(types: Iterable[type]) -> str:
    return " or ".join(cls.__name__ for cls in types)


def _misfit(kind: Kind, what: str, right: str) -> KindError:
    return KindError(f"`parameters` of kind {kind.name!r} {what}", where=place_of(kind.parameters), right=right)


class KindTable(Generic[K]):
    """The kinds of one thing, by name.

    Args:
        thing: name of the thing, for messages.
        kinds: built-in kinds; the first is the default of files that name none.
    """

    registered: ClassVar[int] = 0  # kinds in all tables; models that were built from tables are stale once it changes

    def __init__(self, thing: str, *kinds: K) -> None:
        self.thing, self.usual = thing, kinds[0].name
        self._kinds: dict[str, K] = {}
        self._choices: dict[Callable[[Any], Any], dict[type, Any]] = {}
        self._tried: dict[str, Any] = {}  # parameters with which users' kinds were tried last, by name
        self._from_outside = False
        for kind in kinds:
            self.register(kind)
        self._from_outside = True

    def __iter__(self) -> Iterator[K]:
        """Iterate over all kinds in the order of their registration."""
        return iter(self._kinds.values())

    def register(self, kind: K) -> K:
        """Add a kind, also to laws that `law` has returned, and return it.

        Raises:
            KindError: its name, or a class of its parameters, is taken.
        """
        if kind.name in self._kinds:
            what = f"there is a kind {kind.name!r} of {self.thing} already"
            raise KindError(what, where="kinds", right="choose another name")
        taken = [other.__name__ for other in kind.parameter_types if self._owner(other) is not None]
        if taken:
            what = f"{taken[0]} holds the parameters of another kind of {self.thing}"
            raise KindError(what, where=kind.name, right="give it a class of parameters of its own")
        self._kinds[kind.name] = kind
        if self._from_outside:
            self._tried[kind.name] = None
        KindTable.registered += 1
        for find, laws in self._choices.items():
            laws.update({cls: find(entry) for cls, entry in self._entries(kind)})
        return kind

    def _entries(self, kind: K) -> Iterable[tuple[type, Any]]:
        """Return pairs of a parameter class and the object with its laws, which are guarded for a user's kind."""
        return (kind.guarded() if self.is_from_outside(kind) else kind).laws_by_parameter_type().items()

    def named(self, name: object) -> K:
        """Return the kind of a name; raise KindError, with the known names, if there is none."""
        if isinstance(name, str) and name in self._kinds:
            return self._kinds[name]
        raise KindError(
            f"{name!r} is not a kind of {self.thing}", right=did_you_mean(name, list(self._kinds), "known kinds are {}")
        )

    def parameters(self, described: Any, *others: Any) -> Any:
        """Return the parameters of the laws for a description, by the kind that it names.

        With new parameters, a user's kind is tried by `try_laws` first.

        Args:
            described: description with a field `kind`.
            others: further arguments of the kind's `parameters`.

        Raises:
            KindError: the kind is unknown, its parameters are of another class than it declares or no numbers, or a
                law fails.
        """
        kind = self.named(described.kind)
        if kind.name in self._tried:
            with naming_law(f"{self.thing} {kind.name!r}", "parameters", kind.parameters):
                parameters = kind.parameters(described, *others)
        else:
            parameters = kind.parameters(described, *others)
        if type(parameters) not in kind.parameter_types:
            raise _misfit(kind, f"yields {type(parameters).__name__}", f"give {_names(kind.parameter_types)}")
        for leaf in leaves(parameters):
            if isinstance(leaf, bool) or (not isinstance(leaf, (int, float)) and not hasattr(leaf, "dtype")):
                raise _misfit(kind, f"yields {leaf!r} among its numbers", "give floats in SI units")
        if kind.name in self._tried:
            self._try(kind, parameters, described, *others)
        return parameters

    def _try(self, kind: K, parameters: Any, *described: Any) -> None:
        """Try the laws of a user's kind with the first item of array parameters, unless the last try was with the same.

        Raise KindError if a parameter is nan or a law fails.
        """
        single = mapped(parameters, lambda leaf: leaf if np.ndim(leaf) == 0 else np.ravel(leaf)[0])
        if any(leaf != leaf for leaf in leaves(single)):  # noqa: PLR0124
            raise _misfit(kind, "yields a number that is none (nan)", "give floats in SI units")
        shown = repr(single)  # exact, and comparable whatever numbers it holds
        if self._tried[kind.name] != shown:
            kind.try_laws(single, *described)
            self._tried[kind.name] = shown

    def is_from_outside(self, kind: K) -> bool:
        """Return whether a kind was registered by a user."""
        return kind.name in self._tried

    def kind_of(self, parameters: Any) -> K:
        """Return the kind that parameters belong to; raise KindError if there is none."""
        owner = self._owner(type(parameters))
        if owner is None:
            what = f"{type(parameters).__name__} belongs to no kind of {self.thing}"
            raise KindError(what, where="kinds", right="register a kind with it among its parameter_types")
        return owner

    def _owner(self, cls: type) -> K | None:
        return next((kind for kind in self if cls in kind.parameter_types), None)

    def law(self, find: str | Callable[[Any], Any]) -> Callable[..., Any]:
        """Return a law that selects its implementation by its first argument, the parameters of a kind.

        Args:
            find: name of the law in a kind, or a function from the holder of a kind's laws to the law.
        """
        finder: Callable[[Any], Any] = (lambda entry: getattr(entry, find)) if isinstance(find, str) else find
        laws = {cls: finder(entry) for kind in self for cls, entry in self._entries(kind)}
        self._choices[finder] = laws
        return by_kind(laws)


@dataclass(frozen=True)
class AnyKindOf:
    """Annotation of a described part that may be of any kind in a table.

    A class with such a field is rebuilt (`model_rebuild(force=True)`) once another kind is registered.
    """

    table: KindTable[Any]
    but: str = ""  # name of a kind that is excluded

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Return the schema that validates a value by the kind it names, a table without `kind` by the usual one."""
        kinds = [kind for kind in self.table if kind.name != self.but]
        choices = {kind.name: handler.generate_schema(kind.description) for kind in kinds}
        return core_schema.tagged_union_schema(choices, self._named)

    def _named(self, value: object) -> object:
        return value.get("kind", self.table.usual) if isinstance(value, dict) else getattr(value, "kind", None)
