"""Checks of the values that elements of a page send: a value that no browser sends for its element is a problem."""

import json
import sys
from collections.abc import Callable, Mapping
from typing import Any

from nicegui import Client
from nicegui.element import Element
from nicegui.elements.choice_element import ChoiceElement
from nicegui.elements.input import Input
from nicegui.elements.keyboard import Keyboard
from nicegui.elements.mixins.value_element import ValueElement
from nicegui.elements.number import Number
from nicegui.elements.scene import Scene
from nicegui.elements.select import Select
from nicegui.elements.slider import Slider
from nicegui.elements.tabs import TabPanels, Tabs
from nicegui.helpers import event_type_to_camel_case

MAX_NUMBER = sys.float_info.max  # that a field can hold
KEY_FLAGS = ("repeat", "altKey", "ctrlKey", "metaKey", "shiftKey")
KEY_TEXTS = ("action", "key", "code")
CLICK_FLAGS = ("alt_key", "ctrl_key", "meta_key", "shift_key")


def value_problem(event: Mapping[str, Any]) -> str:
    """Return the problem of the value in an event of a page; "" where its element may send it.

    Args:
        event: data of an event that follows the grammar of messages. Events of removed elements pass, since a
            page may not know that yet; no handler receives them.
    """
    client = Client.instances.get(event["client_id"])
    element = None if client is None else client.elements.get(event["id"])
    if element is None:
        return ""
    listener = element._event_listeners.get(event["listener_id"])
    if listener is None:
        return "is for a listener that its element does not have"
    check = _choose_check(element, listener.type)
    if check is None:
        return ""
    args = [None if one is None else json.loads(one) for one in event["args"]]
    return "" if len(args) == 1 and check(args[0]) else f"has no value that a {type(element).__name__.lower()} sends"


def _choose_check(element: Element, kind: str) -> Callable[[Any], bool] | None:
    """Return the check of an element's values for a kind of event; None where no handler reads them."""
    if isinstance(element, Keyboard):
        return _is_key
    if isinstance(element, Scene):
        return _is_click if kind == "click3d" else (lambda _: kind == "init")
    if not isinstance(element, ValueElement) or kind != event_type_to_camel_case(f"update:{element.VALUE_PROP}"):
        return None
    if isinstance(element, ChoiceElement):
        return lambda value: _is_choice(element, value)
    if isinstance(element, (Tabs, TabPanels)):
        return lambda value: value in [child.props.get("name") for child in element.default_slot.children]
    return next((check for of, check in VALUE_CHECKS if isinstance(element, of)), _is_truth)


def _is_truth(value: Any) -> bool:
    return isinstance(value, bool)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= MAX_NUMBER


def _is_slide(value: Any) -> bool:
    return value is None or _is_number(value)


def _is_typed_number(value: Any) -> bool:
    """Return whether a field of numbers sends a value: a number, its text, or nothing where it is empty."""
    if value is None or value == "":
        return True
    if not isinstance(value, str):
        return _is_number(value)
    try:
        return _is_number(float(value))
    except ValueError:
        return False


def _is_text(value: Any) -> bool:
    return value is None or isinstance(value, str)


VALUE_CHECKS: tuple[tuple[type[Element], Callable[[Any], bool]], ...] = (
    (Number, _is_typed_number),
    (Input, _is_text),
    (Slider, _is_slide),
)
"""Checks of values by their elements; all others are on or off."""


def _is_choice(element: ChoiceElement, value: Any) -> bool:
    """Return whether a value is an option under the label that the page shows: options may have changed since."""
    options: list[dict[str, Any]] = element.props.get("options", [])
    if isinstance(element, Select):
        return value is None or (isinstance(value, dict) and _names_option(options, value))
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < len(options)


def _names_option(options: list[dict[str, Any]], value: dict[str, Any]) -> bool:
    return any(one["value"] == value.get("value") and one["label"] == value.get("label") for one in options)


def _is_key(value: Any) -> bool:
    """Return whether a value is that of a key press: flags, texts and the key's location."""
    if not isinstance(value, dict):
        return False
    flags, texts = [value.get(name) for name in KEY_FLAGS], [value.get(name) for name in KEY_TEXTS]
    return all(map(_is_truth, flags)) and all(isinstance(one, str) for one in texts) and "location" in value


def _is_click(value: Any) -> bool:
    """Return whether a value is that of a click in a scene, with its list of hit objects."""
    if not isinstance(value, dict) or not isinstance(value.get("hits"), list):
        return False
    flags = all(_is_truth(value.get(name)) for name in CLICK_FLAGS)
    return flags and "click_type" in value and "button" in value and all(map(_is_hit, value["hits"]))


def _is_hit(hit: Any) -> bool:
    """Return whether a value names an object of a scene that was hit, at a point of three numbers."""
    if not isinstance(hit, dict) or not {"object_id", "object_name"} <= hit.keys():
        return False
    point = hit.get("point")
    return isinstance(point, dict) and all(_is_number(point.get(axis)) for axis in "xyz")
