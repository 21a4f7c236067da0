"""Values over time in panels, and the states of objects' lives as strips, under one cursor."""

from collections.abc import Callable, Sequence
from typing import Literal

import msgspec
from nicegui.element import Element

from ods.workbench.web.plan_view import Role

Series = Sequence[float | None]
Colour = Role | Literal["first", "second", "third", "quiet"]


class Curve(msgspec.Struct, frozen=True):
    """Values over time; None interrupts the line."""

    role: Colour
    label: str
    t_s: Sequence[float]
    values: Series


class Band(msgspec.Struct, frozen=True):
    """What lies between two curves."""

    role: Colour
    t_s: Sequence[float]
    low: Series
    high: Series


class Panel(msgspec.Struct, frozen=True):
    """One diagram."""

    title: str
    """With the unit."""
    lines: Sequence[Curve]
    bands: Sequence[Band] = ()
    least: float = 0.2
    """Least span of its axis."""


class Strip(msgspec.Struct, frozen=True):
    """The life of one object."""

    id: str
    """Id reported when it is clicked on."""
    label: str
    spans: Sequence[tuple[Role, float, float]]
    """State, from, to, s."""
    marked: bool = False


class TimeView(Element, component="time_view.js", esm={"ods-charts": "charts"}):
    """Strips over panels. Click or drag: the cursor's time; a strip: its object; wheel: zoom; double click: all."""

    def __init__(self, *, title: str = "", columns: int = 2, height: str = "60vh") -> None:
        super().__init__()
        self._props.update({"shown": "{}", "columns": columns, "title": title, "busy": "", "cursor": 0.0})
        self.style(f"height: {height}; width: 100%")

    def show(self, span_s: tuple[float, float], panels: Sequence[Panel], strips: Sequence[Strip] = ()) -> None:
        """Show these over a span of time, from and to, s."""
        shown = msgspec.json.encode({"span": span_s, "panels": panels, "strips": strips}).decode()
        self._set("shown", shown)  # as text: NiceGUI would watch each number for changes

    def set_cursor(self, t_s: float) -> None:
        """Mark a time, s."""
        self._set("cursor", t_s)

    def set_title(self, title: str) -> None:
        """Write something over it."""
        self._set("title", title)

    def set_busy(self, why: str) -> None:
        """Dim it and say why, while a newer one is computed; empty: it is the newest."""
        self._set("busy", why)

    def on_time(self, callback: Callable[[float], None]) -> None:
        """Call `callback` with the time that is clicked or dragged to, s."""
        self.on("pick", lambda event: callback(float(event.args["t_s"])))

    def on_mark(self, callback: Callable[[str], None]) -> None:
        """Call `callback` with the id of a strip that is clicked at."""
        self.on("mark", lambda event: callback(str(event.args["id"])))

    def _set(self, name: str, value: object) -> None:
        """Send the script one property; NiceGUI would send all of them."""
        if self._props.get(name) != value:
            with self._props.suspend_updates():
                self._props[name] = value
            self.run_method("set", name, value)
