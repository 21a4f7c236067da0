"""One setting as a row: name, slider with a field beside it, switch, choice or text."""

from collections.abc import Callable
from typing import Any

from nicegui import ui

from ods.workbench.model.sliders import Choice, Control, Number, Switch, text_of, value_of
from ods.workbench.model.words import sentence

Changed = Callable[[Any], object]


class _Slider(ui.slider):
    """The browser moves it at once; for an answer it would go through all of the page before the picture."""

    LOOPBACK = False


class ControlRow:
    """Widgets of one setting. `changed` gets the value that the user gives; `show` takes what the state has."""

    def __init__(self, control: Control, value: Any, changed: Changed) -> None:
        self._control, self._changed = control, changed
        self._value = value
        self._slider: ui.slider | None = None
        self._field: Any
        with ui.row().classes("w-full items-center no-wrap gap-2 h-8") as self.element:
            label = ui.label(control.name).classes("text-sm leading-none w-28 shrink-0")
            label.tooltip(f"{sentence(control.meaning)} ({control.path})" if control.meaning else control.path)
            self._build()
            ui.label(control.unit).classes("text-xs opacity-70 w-14 shrink-0 truncate")
        self.show(value)

    @property
    def default(self) -> Any:
        """Value where the configuration has none."""
        return self._control.default

    def show(self, value: Any) -> None:
        """Show a value, whoever gave it."""
        self._value = value
        by = self._control.by
        if isinstance(by, Number):
            assert self._slider is not None
            self._slider.set_value(by.place_of(float(value)))
            self._field.set_value(_rounded(value))
        elif isinstance(by, Switch | Choice):
            self._field.set_value(value)
        else:
            self._field.set_value(text_of(value))

    def _build(self) -> None:
        by, marker, name = self._control.by, self._control.path, f'aria-label="{self._control.name}"'
        if isinstance(by, Number):
            self._slider = _Slider(min=0, max=by.places - 1, step=1, value=0, on_change=self._slid)
            self._slider.props(f"dense {name}").classes("grow min-w-16 mr-2").mark(f"slider {marker}")
            self._field = ui.number(value=None).props("dense borderless").classes("w-16 shrink-0")
            self._field.on("change", self._written).on("keydown.enter", self._written)
        elif isinstance(by, Switch):
            self._field = ui.switch(on_change=lambda event: self._give(event.value)).props("dense")
            ui.space()
        elif isinstance(by, Choice):
            self._field = ui.select(list(by.options), on_change=lambda event: self._give(event.value))
            self._field.props("dense options-dense borderless").classes("grow")
        else:
            self._field = ui.input().props("dense borderless").classes("grow")
            self._field.on("change", self._written).on("keydown.enter", self._written)
        self._field.props(name).mark(f"value {marker}")

    def _slid(self) -> None:
        by = self._control.by
        assert isinstance(by, Number)
        assert self._slider is not None
        place = round(self._slider.value)
        if place != by.place_of(float(self._value)):  # else it follows what was written
            self._give(by.value_at(place))

    def _written(self) -> None:
        by, value = self._control.by, self._field.value
        if isinstance(by, Number):
            if value is None:  # emptied, or no number
                self.show(self._value)
            elif value != _rounded(self._value):
                self._give(round(value) if by.whole and value == round(value) else value)
        else:
            self._give(value_of(value))

    def _give(self, value: Any) -> None:
        if value != self._value and value is not None:
            self._changed(value)


def _rounded(value: float) -> float:
    """Return a number as its field shows it: what was dragged has more digits than a field has room for."""
    return value if isinstance(value, int) else float(f"{value:.6g}")
