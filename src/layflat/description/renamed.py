"""Table of the keys that were renamed, from old to present names, and renaming in paths and whole descriptions.

A row has a table's place: a dotted path in present names, in which `*` is any name or number and `valve=spool` a table
whose `kind` is "spool". Users' kinds may have keys of any name, so that those rows hold for the package's kinds alone.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from typing import Any, NamedTuple

from layflat.description.tables import Plain
from layflat.errors import InputError

Steps = tuple[str | int, ...]  # keys, and numbers of items, from the outside in
KindAt = Callable[[Steps], str | None]  # from the old steps of a table to its `kind`; ANY_KIND: that of any row

ANY_KIND = ""

_RANGE_KEYS = {"least": "min", "most": "max"}
_DISTRIBUTION_KEYS = _RANGE_KEYS | {"spread": "std"}
_POSE_KEYS = {"place": "position", "turn": "rotation"}

RENAMED_KEYS: Mapping[str, Mapping[str, Mapping[str, str]]] = {
    "machine": {
        "joint.*.hose": {"loss_share": "loss_fraction"},
        "joint.*.strap": {"loss_share": "loss_fraction"},
        "joint.*.deflecting_roller": {"friction_share": "friction_fraction", "bending_share": "bending_fraction"},
        "joint.*.losses=parallel": {"shares": "fractions"},
        "joint.*.friction=stribeck": {"load_share": "load_ratio"},
        "joint.*.brake.calliper": {"least": "released_fraction"},
        "joint.*.regulator": {"least": "min_fraction"},
        "arm=chain": {"tool_turn": "tool_rotation"},
        "arm=chain.link.*": _POSE_KEYS,
        "arm=chain.link.*.shapes.*": _POSE_KEYS,
        "valve=spool.dither": {"least": "min"},
        "valve=switching": {"least_pulse": "min_pulse"},
        "controller=paper": {"known_load": "load_compensation"},
        "controller=tracking": {
            "pressure_trust": "observer_gain",
            "valve_share": "valve_fraction",
            "quickest": "min_duration",
            "payload_spread": "payload_std",
            "load_spread": "load_std",
            "load_wander": "load_drift",
            "friction_spread": "friction_std",
            "without": "disabled",
        },
        "safety": {"demand_lead": "demand_step"},
    },
    "test bench": {"friction": {"film_share": "film_fraction"}},
    "cell": {
        "cup": {"air": "air_consumption"},
        "limits": {"press": "contact_force"},
        "camera": {"pixel": "pixel_pitch"},
        "overview": {"field": "field_of_view"},
        "ambient": _DISTRIBUTION_KEYS,
        "light.*": {"wander": "position_std", "tint": "colour_std"},
        "light.*.brightness": _DISTRIBUTION_KEYS,
        "produce.*": {"known": "recognised"},
        "produce.*.diameter": _DISTRIBUTION_KEYS,
        "produce.*.flattening": _DISTRIBUTION_KEYS,
        "produce.*.density": _DISTRIBUTION_KEYS,
        "produce.*.colour.*": {"spread": "std", "share": "fraction"},
        "produce.*.grade.*": _RANGE_KEYS,
        "tray.*": {"touching": "touching_fraction"},
        "tray.*.count": _RANGE_KEYS,
        "conveyor": {"patience": "idle_timeout"},
        "conveyor.count": _RANGE_KEYS,
        "clutter.*": {"spread": "std"},
        "clutter.*.count": _RANGE_KEYS,
    },
    "arm task": {"": {"turn": "rotation", "poses": "configurations"}},
    "study": {"vary.*": {"deviation": "std"}, "variant.*": {"times": "factors"}},
    "learnt motion": {"history.*": {"most": "max", "landed": "arrival"}},
}
"""Keys that this version has renamed, by noun of the description and table: old name to present name."""

EARLIER_KEYS: Mapping[str, Mapping[str, Mapping[str, str]]] = {
    "machine": {"safety": {"surplus": "air_residual"}},
    "cell": {
        "": {"pack": "container"},
        "camera": {"turn": "rotation"},
        "tray.*": {"turn": "rotation"},
        "container.*": {"turn": "rotation"},
        "base_markers.marker.*": {"turn": "rotation"},
    },
}
"""Keys that earlier versions have renamed, likewise."""

INNER_DESCRIPTIONS = {
    "study": {"variant.*.set": "machine", "variant.*.factors": "machine"},
    "cloud": {"bases.*": "machine"},
}
"""Tables that are laid out as another description, by noun and place."""

PATH_KEYS = {"study": {"vary": "machine"}}  # tables whose keys are dotted paths of another description

PATH_LISTS = {"study": {"vary.*.also": "machine"}, "cloud": {"columns.*.paths": "machine"}}
"""Lists of dotted paths of another description; `omits` has those of its own."""


class RenamedKey(NamedTuple):
    """Key or dotted path of a description that has another name now."""

    steps: Steps  # in old names; of a path in a list, those of the item
    present: str  # name or path


def present_path(noun: str, path: str) -> str:
    """Return a dotted path with present names; keys of kinds are renamed as if these were the package's.

    Args:
        noun: of the description, such as "machine".
        path: dotted path.
    """
    return ".".join(map(str, present_steps(noun, tuple(path.split(".")), lambda _: ANY_KIND)))


def present_steps(noun: str, steps: Steps, kind_at: KindAt) -> Steps:
    """Return steps with present names, as many as given.

    Args:
        noun: of the description.
        steps: in old or present names.
        kind_at: kind of a table, by its steps as given.
    """
    present: Steps = ()
    for i, step in enumerate(steps):
        inner = _place(INNER_DESCRIPTIONS.get(noun, {}), present)
        if inner is not None:
            return present + present_steps(inner, steps[i:], partial(_kind_below, kind_at, steps[:i]))
        named = _place(PATH_KEYS.get(noun, {}), present)
        if named is not None and isinstance(step, str):
            step = present_path(named, step)  # noqa: PLW2901
        for place, name in _rows(noun).get(step, ()):
            if _is_at(place, present, steps, kind_at):
                step = name  # noqa: PLW2901
                break
        present = (*present, step)
    return present


def _kind_below(kind_at: KindAt, above: Steps, steps: Steps) -> str | None:
    return kind_at(above + steps)


def with_present_keys(
    noun: str, plain: Plain, where: str = "", *, certain: bool = True
) -> tuple[Plain, list[RenamedKey]]:
    """Return a copy of a description with present keys and paths, and the keys and paths that were renamed in it.

    Args:
        noun: of the description.
        plain: nested tables.
        where: the file, for messages.
        certain: rename no keys of a table that may have several kinds and does not name its own.

    Raises:
        InputError: a table has a key by both names.
    """
    kind_at = _kinds_in(plain, None if certain else ANY_KIND)
    renamed: list[RenamedKey] = []

    def walk(part: Any, steps: Steps) -> Any:
        """Return the part at these old steps with present names, and add what is renamed to `renamed`."""
        if isinstance(part, dict):
            table: Plain = {}
            for key, value in part.items():
                name = str(present_steps(noun, (*steps, key), kind_at)[-1]) if _may_be_old(noun, key) else key
                if name != key:
                    renamed.append(RenamedKey((*steps, key), name))
                if name != key and name in part:
                    at = ": ".join(filter(None, (where, _dotted(steps))))
                    raise InputError(f"has {key} and {name}, its new name", where=at, right="keep one")
                table[name] = walk(value, (*steps, key))
            return table
        if isinstance(part, list):
            return [walk(item, (*steps, i)) for i, item in enumerate(part)]
        described = listed_noun(noun, steps, kind_at) if isinstance(part, str) else None
        if described is None or (path := present_path(described, part)) == part:
            return part
        renamed.append(RenamedKey(steps, path))
        return path

    return walk(plain, ()), renamed


def listed_noun(noun: str, steps: Steps, kind_at: KindAt) -> str | None:
    """Return the noun of the description that a list's item is a path of; None for any other text.

    Args:
        noun: of the description that holds the list.
        steps: of the item.
        kind_at: as in `present_steps`.
    """
    if not (steps and isinstance(steps[-1], int)):
        return None
    if steps[:-1] == ("omits",):
        return noun
    return _place(PATH_LISTS.get(noun, {}), present_steps(noun, steps[:-1], kind_at))


def refuse_old_keys(noun: str, plain: Plain, where: str) -> None:
    """Raise InputError for the first key or path of a file that is renamed.

    Args:
        noun: of the description.
        plain: its tables, as in the file.
        where: the file.
    """
    _, renamed = with_present_keys(noun, plain, where)
    if renamed:
        first = renamed[0]
        raise InputError(
            f"is called {first.present} now", where=f"{where}: {_dotted(first.steps)}", right=migration_advice(where)
        )


def migration_advice(where: str) -> str:
    """Return the advice about an old key in a file."""
    return f"`layflat migrate {where}` rewrites the file"


def with_former_keys(noun: str, plain: Plain) -> Plain:
    """Return a description with the keys of the last version, in the same order; paths in its texts stay.

    Args:
        noun: of the description, with a table in `RENAMED_KEYS`.
        plain: nested tables with present keys.
    """
    kind_at = _kinds_in(plain, None)

    def walk(part: Any, steps: Steps) -> Any:
        if isinstance(part, dict):
            return {former(steps, key): walk(value, (*steps, key)) for key, value in part.items()}
        return [walk(item, (*steps, i)) for i, item in enumerate(part)] if isinstance(part, list) else part

    def former(steps: Steps, key: str) -> str:
        """Return the key of the last version of a key in the table at these steps."""
        for place, names in RENAMED_KEYS[noun].items():
            old = next((old for old, name in names.items() if name == key), None)
            if old is not None and _is_at(place, steps, steps, kind_at):
                return old
        return key

    return walk(plain, ())  # type: ignore[no-any-return]


def _kinds_in(plain: Plain, unnamed: str | None) -> KindAt:
    """Return the function that reads the kind of a table; it returns `unnamed` where the table has none."""

    def kind_at(steps: Steps) -> str | None:
        part: Any = plain
        for step in steps:
            part = part[step]
        kind = part.get("kind") if isinstance(part, dict) else None
        kind = kind.get("value") if isinstance(kind, dict) else kind
        return kind if isinstance(kind, str) else unnamed

    return kind_at


@lru_cache
def _rows(noun: str) -> dict[str | int, list[tuple[str, str]]]:
    """Return place and present name of each row, by the old name."""
    rows: dict[str | int, list[tuple[str, str]]] = {}
    for table in (RENAMED_KEYS, EARLIER_KEYS):
        for place, names in table.get(noun, {}).items():
            for old, name in names.items():
                rows.setdefault(old, []).append((place, name))
    return rows


def _may_be_old(noun: str, key: str) -> bool:
    """Return whether a key has another name now in some table of a description."""
    return key in _rows(noun) or noun in INNER_DESCRIPTIONS or noun in PATH_KEYS


def _is_at(place: str, present: Steps, steps: Steps, kind_at: KindAt) -> bool:
    """Return whether a table, by its present steps and those given, is at a row's place."""
    parts = place.split(".") if place else []
    if len(parts) != len(present):
        return False
    for i, (part, step) in enumerate(zip(parts, present, strict=True), start=1):
        name, _, kind = part.partition("=")
        if name not in ("*", str(step)) or (kind and kind_at(steps[:i]) not in (kind, ANY_KIND)):
            return False
    return True


def _place(places: Mapping[str, str], present: Steps) -> str | None:
    """Return the noun of the first place that steps are at; None if they are at none."""
    return next((noun for place, noun in places.items() if _is_at(place, present, present, lambda _: None)), None)


def _dotted(steps: Steps) -> str:
    return ".".join(map(str, steps))


__all__ = ["RENAMED_KEYS", "refuse_old_keys", "with_former_keys", "with_present_keys"]
