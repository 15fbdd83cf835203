"""Descriptions of one sort: those that are built in, by name, and those in files; what extends what."""

from dataclasses import dataclass
from functools import cached_property, reduce
from pathlib import Path
from typing import Any

from layflat.description.hints import nearest
from layflat.description.provenance import Sources, split
from layflat.description.tables import Plain, laid_over, parsed
from layflat.description.text import exists, read_text, told_as
from layflat.errors import InputError

LONGEST_NAME = 200

LONGEST_CHAIN = 20  # files that extend each other


@dataclass(frozen=True)
class Layer:
    """What one file says: its plain values, their sources, and what it leaves out of the layers below."""

    where: str
    plain: Plain
    sources: Sources
    omits: tuple[str, ...] = ()


@dataclass(frozen=True)
class Library:
    """Where descriptions of one sort are found."""

    folder: Path  # of those that are built in
    noun: str  # what one of them is called
    shown_by: str  # where the names of those that are built in are shown
    example: str  # what a value looks like in such a file
    error: type[InputError]  # class of what is raised

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the built-in descriptions."""
        return tuple(sorted(path.stem for path in self.folder.glob("*.toml")))

    def text(self, where: str | Path) -> str:
        """Return a description as it is written, of a built-in name or a file.

        Raises:
            InputError: of the library's class: it can't be read.
        """
        place = self._name(where)
        path = Path(place)
        if place in self.names:
            return (self.folder / f"{place}.toml").read_text(encoding="utf-8")
        if not path.suffix and len(place) < LONGEST_NAME and not exists(path):
            near = nearest(path.name, self.names)
            raise self.error(
                f"no such {self.noun}", where=place, right=f"did you mean {near!r}?" if near else self.shown_by
            )
        right = f"give a TOML file, or a built-in name: {self.shown_by}"
        return read_text(path, place, right, self.error)

    def _name(self, where: object) -> str:
        if not isinstance(where, (str, Path)) or not str(where).strip():
            raise self.error(f"{where!r} is no name of a {self.noun}", right=f"give one, or a file: {self.shown_by}")
        return str(where)

    def raw(self, where: str | Path) -> Plain:
        """Return the tables of one description, without what it extends.

        Raises:
            InputError: of the library's class: it can't be read or is not TOML.
        """
        with told_as(self.error):
            return parsed(self.text(where), str(where), self.example)

    def layers(self, where: str | Path, above: tuple[str, ...] = ()) -> list[Layer]:
        """Return what a description and those that it extends say, the lowest first.

        Args:
            where: a built-in name or a file.
            above: those that extend it.

        Raises:
            InputError: of the library's class: one of them is missing or broken, or they extend each other in a circle.
        """
        place = self._name(where)
        layer, base = self._layer(place, above[-1] if above else "")
        key = self._key(place)
        if key in map(self._key, above) or len(above) > LONGEST_CHAIN:
            chain = " -> ".join([*above, place])
            raise self.error(f"extends itself through {chain}", where=above[0], right="break the circle")
        below = [] if base is None else self.layers(self.beside(place, base), (*above, place))
        return [*below, layer]

    def tables(self, where: str | Path) -> tuple[Plain, Sources]:
        """Return the plain values of a description as they are written, what it extends included, and their sources.

        Raises:
            InputError: of the library's class: as `layers`, or what it omits is not there.
        """
        with told_as(self.error):
            nothing: tuple[Plain, Sources] = ({}, {})
            return reduce(self.laid, self.layers(where), nothing)

    def laid(self, under: tuple[Plain, Sources], layer: Layer) -> tuple[Plain, Sources]:
        """Return what a layer makes of what is below it."""
        plain, sources = under
        for path in layer.omits:
            plain, sources = _without(plain, path, layer.where), _sources_without(sources, path)
        return laid_over(plain, layer.plain), sources | layer.sources

    def beside(self, where: str, name: str) -> str:
        """Return a name as seen from a description: built-in names as they are, files from its own folder."""
        return name if name in self.names else str(Path(where).parent / name)

    def _key(self, place: str) -> str:
        return place if place in self.names else str(Path(place).resolve())

    def _layer(self, where: str, extended_by: str) -> tuple[Layer, str | None]:
        """Read one description, and name the one that it extends."""
        try:
            raw = self.raw(where)
        except InputError as error:
            if not extended_by:
                raise
            raise self.error(
                f"{error.where}: {error.what}", where=f"{extended_by}: extends", right=error.right
            ) from None
        base, omits = raw.pop("extends", None), raw.pop("omits", [])
        if not isinstance(base, str | None) or base == "":
            right = f'give one such as "{self.names[0]}"'
            raise self.error(f"{base!r} is not a name", where=f"{where}: extends", right=right)
        if not isinstance(omits, list) or not all(isinstance(path, str) for path in omits):
            raise self.error(
                f"{omits!r} is not a list of names", where=f"{where}: omits", right='give one such as ["x"]'
            )
        with told_as(self.error):
            plain, sources = split(raw, where)
        return Layer(where, plain, sources, tuple(omits)), base


def _without(plain: Plain, path: str, where: str) -> Plain:
    """Return tables without a part, by its dotted path."""
    head, _, rest = path.partition(".")
    below: Any = plain.get(head)
    if head not in plain or (rest and not isinstance(below, dict)):
        raise InputError(f"{path!r} is not there to omit", where=f"{where}: omits", right='name a part such as "valve"')
    if rest:
        return plain | {head: _without(below, rest, where)}
    return {key: value for key, value in plain.items() if key != head}


def _sources_without(sources: Sources, path: str) -> Sources:
    return {key: source for key, source in sources.items() if key != path and not key.startswith(f"{path}.")}
