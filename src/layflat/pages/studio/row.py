"""Row of one value of a description: name, source, slider, field, and the message about a refused input."""

from collections.abc import Callable
from typing import Any

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from layflat.errors import InputError
from layflat.pages.look import theme
from layflat.pages.studio.design import Design, error_text
from layflat.pages.studio.field import SOURCE_NOTES, Field, describe_value, section_name

MAX_TEXT = 20_000  # characters of a value, such as a long list: a page's message may have a few times as many


class Row:
    """Row of a value that can be edited; `refresh` updates it from the design."""

    def __init__(self, design: Design, field: Field, edited: Callable[[], object], *, place: bool = False) -> None:
        """Make it within the current element.

        Args:
            design: design that is edited.
            field: field of the value.
            edited: called after an edit that was accepted.
            place: whether the section's name precedes the label.
        """
        self.design, self.field, self._edited = design, field, edited
        self._slider: ui.slider | None = None
        self._control: ValueElement[Any] | None = None
        self._shown: Any = None
        self._is_setting = False  # True while `refresh` sets the elements' values
        name = f"{section_name(field.section)}: {field.label}" if place and field.section else field.label
        with ui.element("div").classes("st-row") as self.box:
            with ui.element("div").classes("st-head"):
                ui.label(name).classes("st-name")
                self._source = ui.label().classes("st-source")
                with self._source:
                    self._note = ui.tooltip("")
                self._back = theme.button("", self._revert, icon="undo", kind="flat", hint="Back to what it was")
                self._back.classes("st-back").props("dense round size=sm")
            with ui.element("div").classes("st-body"):
                self._build_control()
            if field.meaning or field.limits:
                ui.label(describe_value(field.meaning, field.limits)).classes("st-meaning")
            self._wrong = ui.label().classes("st-wrong").props("role=alert")
        self.refresh()

    @property
    def has_unaccepted_text(self) -> bool:
        """True while typed text was not accepted yet."""
        return isinstance(self._control, ui.input) and self._control.value != self._text()

    def reset(self) -> None:
        """Show the design's value in place of typed text."""
        self._show_message("")
        self._shown = None
        self.refresh()

    def refresh(self) -> None:
        """Show the design's value, its source, and whether it was changed."""
        path, value = self.field.path, self.design.value(self.field.path)
        source = self.design.source(path)
        changed = path in self.design.changes
        was = self.field.format_value(self.design.opened_value(path)) if changed else ""
        state = (value, source, was)
        if state == self._shown:
            return
        self._shown = state
        self._source.set_text(source.source)
        self._note.set_text(
            f"was {was} {self.field.unit}".rstrip() if changed else source.note or SOURCE_NOTES[source.source]
        )
        if changed != self._back.visible:
            self._back.set_visibility(changed)
            self._back.props["aria-label"] = f"Back to {was} {self.field.unit}: {self._name}"
            self.box.classes(add="st-changed" if changed else "", remove="" if changed else "st-changed")
        self._is_setting = True
        self._show(value)
        self._is_setting = False

    @property
    def _name(self) -> str:
        return f"{section_name(self.field.section)}, {self.field.label}".removeprefix(", ")

    def _text(self) -> str:
        return self.field.format_value(self.design.value(self.field.path))

    def _build_control(self) -> None:
        """Build the control for the shape of the field: text, switch, choice, or a number with a slider."""
        field, value = self.field, self.design.value(self.field.path)
        label = self._name + (f" in {field.unit}" if field.unit else "")
        if field.shape == "fixed":
            ui.label(field.format_value(value)).classes("st-fixed")
            return
        if field.shape == "switch":
            self._control = ui.switch(value=value, on_change=lambda event: self._apply(event.value))
        elif field.shape == "choice":
            self._control = ui.select(
                list(field.choices), value=value, on_change=lambda event: self._apply(event.value)
            )
            self._control.props("outlined dense options-dense")
        else:
            self._build_slider(label)
            self._control = ui.input(value=self._text(), suffix=field.unit or None).props(
                f"outlined dense hide-bottom-space no-error-icon maxlength={MAX_TEXT}"
            )
            self._control.on("blur", self._apply_typed).on("keydown.enter", self._apply_typed).on(
                "keydown.esc", self.reset
            )
            self._control.classes("st-wide" if self._slider is None and not field.unit else "")
        self._control.classes("st-input").props["aria-label"] = label

    def _build_slider(self, label: str) -> None:
        """Build the slider of a number, if its field has a range for one."""
        field, value = self.field, self.design.value(self.field.path)
        slider_range = field.slider(value) if field.shape in {"number", "whole"} else None
        if slider_range is None:
            return
        low, high, step = slider_range
        self._slider = ui.slider(min=low, max=high, step=step, value=field.number(value), on_change=self._slid)
        self._slider.classes("st-slider").props["aria-label"] = f"Slider: {label}"
        self._slider.on("change", self._slider_released)

    def _show(self, value: Any) -> None:
        """Show a value in all controls; a slider gets a new range if the value is outside its own."""
        if self._slider is not None:
            number = self.field.number(value)
            low, high = self._slider.props["min"], self._slider.props["max"]
            if not low <= number <= high and (slider_range := self.field.slider(value)) is not None:
                low, high, step = slider_range
                self._slider.props.update({"min": low, "max": high, "step": step})
            self._slider.set_value(min(max(number, low), high))
        if isinstance(self._control, ui.input):
            self._control.set_value(self.field.format_value(value))
        elif self._control is not None:
            self._control.set_value(value)

    def _slid(self, event: Any) -> None:
        """Apply the value of the moved slider, in one undo step until it is released."""
        if not self._is_setting and event.value is not None:
            self._apply(self.field.read(f"{event.value:.7g}"), going_on=True)

    def _slider_released(self) -> None:
        """End the undo step of the slider, and put it back if its value was refused."""
        self.design.hold()
        if self._wrong.text:  # the slider is where the value can't be
            self._shown = None
            self.refresh()

    def _apply_typed(self) -> None:
        """Apply typed text that differs from the shown value, or show why it is refused; else clear the message."""
        if self.has_unaccepted_text and isinstance(self._control, ui.input):
            self._apply(self.field.read(self._control.value or ""))
        else:
            self._show_message("")

    def _apply(self, value: Any, *, going_on: bool = False) -> None:
        """Set the value in the design, or show why it is refused; `going_on` adds to the present undo step."""
        if self._is_setting:
            return
        try:
            self.design.edit(self.field.path, value, going_on=going_on)
        except InputError as error:
            self._show_message(error_text(error, self.field.path))
            return
        self._show_message("")
        self._shown = None if not going_on else self._shown
        self.refresh()
        self._edited()

    def _revert(self) -> None:
        """Set the value back to that of the opened description."""
        try:
            self.design.revert(self.field.path)
        except InputError as error:
            self._show_message(error_text(error, self.field.path))
            return
        self.reset()
        self._edited()

    def _show_message(self, text: str) -> None:
        """Show a message below the control and mark the control as wrong; an empty text clears both."""
        self._wrong.set_text(text)
        if isinstance(self._control, ui.input):
            self._control.props(add="error" if text else "", remove="" if text else "error")
            self._control.props["aria-invalid"] = "true" if text else "false"
