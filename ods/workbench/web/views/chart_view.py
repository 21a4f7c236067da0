"""Charts: curves in panels over one axis, and strips of states; zoomed, pointed at and downloaded in the browser."""

import base64
from collections.abc import Callable, Sequence
from typing import Any, Literal

import msgspec
import numpy as np
from nicegui.element import Element
from nicegui.elements import echart as _echart  # noqa: F401  its script is what ours draws with

from ods.base.arrays import AnyArray
from ods.workbench.web.views.plan_view import Role

Colour = Role | Literal["first", "second", "third", "fourth", "quiet"]
Style = Literal["line", "dotted", "steps", "bars", "points", "diamonds"]


class Axis(msgspec.Struct, frozen=True):
    """One of a panel's two."""

    label: str
    """With the unit."""
    low: float | None = None
    high: float | None = None
    """None: what the values need."""
    log: bool = False
    inverse: bool = False
    """Values rise downwards."""
    span: float = 0.0
    """Least that is shown where values need less."""
    cursor: str = ""
    """Views that have an axis of this name show the place that is pointed at in one of them."""


class Even(msgspec.Struct, frozen=True):
    """Numbers at even steps."""

    x0: float
    dx: float


class Curve(msgspec.Struct, frozen=True, eq=False):
    """Values over rising x; NaN interrupts the line."""

    role: Colour
    label: str
    """In the legend; empty: not there."""
    x: AnyArray | Even
    y: AnyArray
    style: Style = "line"
    names: Sequence[str] = ()
    """Of the points, written beside the panel."""


class Band(msgspec.Struct, frozen=True, eq=False):
    """What lies between two curves."""

    role: Colour
    label: str
    x: AnyArray
    low: AnyArray
    high: AnyArray


class Line(msgspec.Struct, frozen=True):
    """A value of one axis, marked across the whole panel."""

    name: str
    axis: Literal["x", "y"]
    value: float
    role: Colour
    draggable: bool = False


class Panel(msgspec.Struct, frozen=True, eq=False):
    """One diagram."""

    y: Axis
    curves: Sequence[Curve]
    bands: Sequence[Band] = ()
    lines: Sequence[Line] = ()
    title: str = ""
    """Over it, in place of its axis's label."""


class Strip(msgspec.Struct, frozen=True):
    """The life of one object."""

    id: str
    """Id reported when it is clicked on."""
    label: str
    spans: Sequence[tuple[Role, float, float]]
    """State, from, to, s."""
    marked: bool = False


class ChartView(Element, component="chart_view.js", esm={"ods-charts": "charts"}):
    """Strips over panels, all over the same axis. Wheel: zoom; drag: a box to zoom into; double click: all."""

    def __init__(self, *, title: str = "", height: str = "14rem") -> None:
        super().__init__()
        self._props.update({"shown": "{}", "title": title, "busy": "", "cursor": None, "picks": False})
        self.style(f"height: {height}; width: 100%")
        self.on("mounted", self._tell_all)

    def show(self, x: Axis, panels: Sequence[Panel], strips: Sequence[Strip] = (), *, columns: int = 1) -> None:
        """Show these, the panels in so many columns."""
        content = {"x": x, "panels": panels, "strips": strips, "columns": columns}
        text = msgspec.json.encode(content, enc_hook=_packed).decode()
        self._set("shown", text)  # as text: NiceGUI would watch each number for changes

    def set_cursor(self, x: float) -> None:
        """Mark a place of the axis."""
        self._set("cursor", x)

    def set_title(self, title: str) -> None:
        """Write something over it."""
        self._set("title", title)

    def set_busy(self, why: str) -> None:
        """Dim it and say why, while a newer one is computed; empty: it is the newest."""
        self._set("busy", why)

    def on_drag(self, callback: Callable[[str, float], None]) -> None:
        """Call `callback` with the name of a line that is dragged, and its new value."""
        self.on("drag", lambda event: callback(str(event.args["name"]), float(event.args["value"])))

    def on_pick(self, callback: Callable[[float], None]) -> None:
        """Call `callback` with the place that is clicked or dragged to; a box to zoom into then needs Shift."""
        self._props["picks"] = True
        self.on("pick", lambda event: callback(float(event.args["x"])))

    def on_mark(self, callback: Callable[[str], None]) -> None:
        """Call `callback` with the id of a strip that is clicked at."""
        self.on("mark", lambda event: callback(str(event.args["id"])))

    def _set(self, name: str, value: object) -> None:
        """Send the script one property; NiceGUI would send all of them."""
        if self._props.get(name) != value:
            with self._props.suspend_updates():
                self._props[name] = value
            self.run_method("set", name, value)

    def _tell_all(self) -> None:
        """Send a script that is built again, or late, what the others were sent."""
        for name in ("title", "busy", "cursor", "shown"):
            self.run_method("set", name, self._props[name])


def _packed(value: Any) -> str:
    """Return the base64 of numbers as float32: the browser reads it many times quicker than their digits."""
    return base64.b64encode(np.ascontiguousarray(value, "<f4").tobytes()).decode()
