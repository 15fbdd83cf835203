"""One value of the description on the page: name, source, slider, field, and what is wrong with what was typed."""

from collections.abc import Callable
from typing import Any

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from layflat.errors import InputError
from layflat.pages.look import theme
from layflat.pages.studio.design import Design, message
from layflat.pages.studio.field import NOTES, Field, place_of, sentence

MAX_TEXT = 20_000  # characters of a value, such as a long list: a message of a page holds a few times as many


class Row:
    """A value that can be edited. `refresh` brings it up to date with the design."""

    def __init__(self, design: Design, field: Field, edited: Callable[[], object], *, place: bool = False) -> None:
        """Make it within the current element.

        Args:
            design: that is edited.
            field: of the value.
            edited: called after an edit that was taken.
            place: whether the section's name stands before the label.
        """
        self.design, self.field, self._edited = design, field, edited
        self._slider: ui.slider | None = None
        self._control: ValueElement[Any] | None = None
        self._shown: Any = None
        self._own = False  # while values are set from here
        name = f"{place_of(field.section)}: {field.label}" if place and field.section else field.label
        with ui.element("div").classes("st-row") as self.box:
            with ui.element("div").classes("st-head"):
                ui.label(name).classes("st-name")
                self._source = ui.label().classes("st-source")
                with self._source:
                    self._note = ui.tooltip("")
                self._back = theme.button("", self._go_back, icon="undo", kind="flat", hint="Back to what it was")
                self._back.classes("st-back").props("dense round size=sm")
            with ui.element("div").classes("st-body"):
                self._build()
            if field.meaning or field.limits:
                ui.label(sentence(field.meaning, field.limits)).classes("st-meaning")
            self._wrong = ui.label().classes("st-wrong").props("role=alert")
        self.refresh()

    @property
    def dirty(self) -> bool:
        """True where typed text was not taken yet."""
        return isinstance(self._control, ui.input) and self._control.value != self._text()

    def reset(self) -> None:
        """Show what the design has, in place of what was typed."""
        self._say("")
        self._shown = None
        self.refresh()

    def refresh(self) -> None:
        """Show what the design has."""
        path, value = self.field.path, self.design.value(self.field.path)
        source = self.design.source(path)
        changed = path in self.design.changes
        was = self.field.shown(self.design.was(path)) if changed else ""
        state = (value, source, was)
        if state == self._shown:
            return
        self._shown = state
        self._source.set_text(source.source)
        self._note.set_text(f"was {was} {self.field.unit}".rstrip() if changed else source.note or NOTES[source.source])
        if changed != self._back.visible:
            self._back.set_visibility(changed)
            self._back.props["aria-label"] = f"Back to {was} {self.field.unit}: {self._name}"
            self.box.classes(add="st-changed" if changed else "", remove="" if changed else "st-changed")
        self._own = True
        self._show(value)
        self._own = False

    @property
    def _name(self) -> str:
        return f"{place_of(self.field.section)}, {self.field.label}".removeprefix(", ")

    def _text(self) -> str:
        return self.field.shown(self.design.value(self.field.path))

    def _build(self) -> None:
        field, value = self.field, self.design.value(self.field.path)
        label = self._name + (f" in {field.unit}" if field.unit else "")
        if field.shape == "fixed":
            ui.label(field.shown(value)).classes("st-fixed")
            return
        if field.shape == "switch":
            self._control = ui.switch(value=value, on_change=lambda event: self._take(event.value))
        elif field.shape == "choice":
            self._control = ui.select(list(field.choices), value=value, on_change=lambda event: self._take(event.value))
            self._control.props("outlined dense options-dense")
        else:
            self._build_number(label)
            self._control = ui.input(value=self._text(), suffix=field.unit or None).props(
                f"outlined dense hide-bottom-space no-error-icon maxlength={MAX_TEXT}"
            )
            self._control.on("blur", self._typed).on("keydown.enter", self._typed).on("keydown.esc", self.reset)
            self._control.classes("st-wide" if self._slider is None and not field.unit else "")
        self._control.classes("st-input").props["aria-label"] = label

    def _build_number(self, label: str) -> None:
        field, value = self.field, self.design.value(self.field.path)
        around = field.slider(value) if field.shape in {"number", "whole"} else None
        if around is None:
            return
        low, high, step = around
        self._slider = ui.slider(min=low, max=high, step=step, value=field.number(value), on_change=self._slid)
        self._slider.classes("st-slider").props["aria-label"] = f"Slider: {label}"
        self._slider.on("change", self._let_go)

    def _show(self, value: Any) -> None:
        if self._slider is not None:
            number = self.field.number(value)
            low, high = self._slider.props["min"], self._slider.props["max"]
            if not low <= number <= high and (around := self.field.slider(value)) is not None:
                low, high, step = around
                self._slider.props.update({"min": low, "max": high, "step": step})
            self._slider.set_value(min(max(number, low), high))
        if isinstance(self._control, ui.input):
            self._control.set_value(self.field.shown(value))
        elif self._control is not None:
            self._control.set_value(value)

    def _slid(self, event: Any) -> None:
        if not self._own and event.value is not None:
            self._take(self.field.read(f"{event.value:.7g}"), going_on=True)

    def _let_go(self) -> None:
        self.design.hold()
        if self._wrong.text:  # the slider stands where the value can't
            self._shown = None
            self.refresh()

    def _typed(self) -> None:
        if self.dirty and isinstance(self._control, ui.input):
            self._take(self.field.read(self._control.value or ""))
        else:
            self._say("")

    def _take(self, value: Any, *, going_on: bool = False) -> None:
        if self._own:
            return
        try:
            self.design.edit(self.field.path, value, going_on=going_on)
        except InputError as error:
            self._say(message(error, self.field.path))
            return
        self._say("")
        self._shown = None if not going_on else self._shown
        self.refresh()
        self._edited()

    def _go_back(self) -> None:
        try:
            self.design.back(self.field.path)
        except InputError as error:
            self._say(message(error, self.field.path))
            return
        self.reset()
        self._edited()

    def _say(self, text: str) -> None:
        self._wrong.set_text(text)
        if isinstance(self._control, ui.input):
            self._control.props(add="error" if text else "", remove="" if text else "error")
            self._control.props["aria-invalid"] = "true" if text else "false"
