"""Libraries of descriptions, built in by name or in files, that may extend each other."""

from dataclasses import dataclass
from functools import cached_property, reduce
from pathlib import Path
from typing import Any

from layflat.description.renamed import refuse_old_keys
from layflat.description.tables import Plain, Sources, overlay, parse_toml, split_provenance
from layflat.description.text import errors_as, exists, read_text
from layflat.description.wrong import nearest
from layflat.errors import InputError

MAX_NAME_LENGTH = 200

MAX_CHAIN = 20  # descriptions below one, of which each extends the next


@dataclass(frozen=True)
class Layer:
    """Content of one description, to be overlaid on those that it extends."""

    where: str  # built-in name or file
    plain: Plain  # values without their sources
    sources: Sources
    omits: tuple[str, ...] = ()  # dotted paths of the lower layers that it leaves out


@dataclass(frozen=True)
class Library:
    """Library of the descriptions of one schema, such as machines."""

    folder: Path  # of the built-in descriptions
    noun: str  # for one of them, in messages and in the table of renamed keys
    listing_advice: str  # advice that tells how to list the built-in names
    example: str  # line of such a file, for messages
    error: type[InputError]  # class of the errors

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the built-in descriptions."""
        return tuple(sorted(path.stem for path in self.folder.glob("*.toml")))

    def text(self, where: str | Path) -> str:
        """Return the text of a description, from a built-in name or a file.

        Raises:
            InputError: of the library's class: it can't be read.
        """
        place = self._check_reference(where)
        path = Path(place)
        if place in self.names:
            return (self.folder / f"{place}.toml").read_text(encoding="utf-8")
        if not path.suffix and len(place) < MAX_NAME_LENGTH and not exists(path):
            near = nearest(path.name, self.names)
            raise self.error(
                f"no such {self.noun}", where=place, right=f"did you mean {near!r}?" if near else self.listing_advice
            )
        right = f"give a TOML file, or a built-in name: {self.listing_advice}"
        return read_text(path, place, right, self.error)

    def _check_reference(self, where: object) -> str:
        """Return a name or path as text; raise the library's error for anything else, and for a blank text."""
        if not isinstance(where, (str, Path)) or not str(where).strip():
            raise self.error(f"{where!r} names no {self.noun}", right=f"give one, or a file: {self.listing_advice}")
        return str(where)

    def raw(self, where: str | Path) -> Plain:
        """Return the tables of one description, without what it extends.

        Raises:
            InputError: of the library's class: it can't be read, is not TOML, or has a key by its old name.
        """
        with errors_as(self.error):
            plain = parse_toml(self.text(where), str(where), self.example)
            refuse_old_keys(self.noun, plain, str(where))
        return plain

    def layers(self, where: str | Path, above: tuple[str, ...] = ()) -> list[Layer]:
        """Return the layers of a description and of those that it extends, the lowest first.

        Args:
            where: a built-in name or a file.
            above: descriptions that extend it.

        Raises:
            InputError: of the library's class: one of them is missing or broken, or they extend each other in a circle
                or are more than `MAX_CHAIN` below the first.
        """
        place = self._check_reference(where)
        layer, base = self._layer(place, above[-1] if above else "")
        key = self._key(place)
        if key in map(self._key, above):
            chain = " -> ".join([*above, place])
            raise self.error(f"extends itself through {chain}", where=above[0], right="break the circle")
        if len(above) > MAX_CHAIN:
            what, right = f"extends more than {MAX_CHAIN} descriptions, one through another", "join some of them"
            raise self.error(what, where=above[0], right=right)
        below = [] if base is None else self.layers(self.resolve(place, base), (*above, place))
        return [*below, layer]

    def tables(self, where: str | Path) -> tuple[Plain, Sources]:
        """Return the plain values of a description, with those that it extends, and their sources.

        Raises:
            InputError: of the library's class: as `layers`, or a part that it omits does not exist.
        """
        with errors_as(self.error):
            empty: tuple[Plain, Sources] = ({}, {})
            return reduce(self.apply_layer, self.layers(where), empty)

    def apply_layer(self, below: tuple[Plain, Sources], layer: Layer) -> tuple[Plain, Sources]:
        """Return values and sources `below` without the parts that a layer omits, and with the layer on top.

        Raises:
            InputError: a part to omit does not exist.
        """
        plain, sources = below
        for path in layer.omits:
            plain, sources = _omit(plain, path, layer.where), _sources_without(sources, path)
        return overlay(plain, layer.plain), sources | layer.sources

    def resolve(self, where: str, name: str) -> str:
        """Return a name in a description `where` resolved: a built-in name, or a path relative to the folder of it."""
        return name if name in self.names else str(Path(where).parent / name)

    def _key(self, place: str) -> str:
        return place if place in self.names else str(Path(place).resolve())

    def _layer(self, where: str, extended_by: str) -> tuple[Layer, str | None]:
        """Return the layer of one description, and the name of the one that it extends, None if it extends none.

        Raises:
            InputError: of the library's class: it is wrong; if it can't be read, of `extended_by`, the one above.
        """
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
        with errors_as(self.error):
            plain, sources = split_provenance(raw, where)
        return Layer(where, plain, sources, tuple(omits)), base


def _omit(plain: Plain, path: str, where: str) -> Plain:
    """Return tables without the part at a dotted path; raise InputError if there is none."""
    head, _, rest = path.partition(".")
    below: Any = plain.get(head)
    if head not in plain or (rest and not isinstance(below, dict)):
        raise InputError(f"{path!r} is not there to omit", where=f"{where}: omits", right='name a part such as "valve"')
    if rest:
        return plain | {head: _omit(below, rest, where)}
    return {key: value for key, value in plain.items() if key != head}


def _sources_without(sources: Sources, path: str) -> Sources:
    return {key: source for key, source in sources.items() if key != path and not key.startswith(f"{path}.")}
