"""Curves over one axis, with lines across them that may be dragged: range profiles and histograms."""

from collections.abc import Callable, Sequence
from typing import Literal

import msgspec
from nicegui.element import Element

from ods.workbench.web.time_view import Colour


class Axis(msgspec.Struct, frozen=True):
    """One of the two."""

    label: str
    """With the unit."""
    low: float
    high: float
    log: bool = False
    """Values are logarithms to the base of 10, and are written as what they are of."""


class EvenCurve(msgspec.Struct, frozen=True):
    """Values at even steps; None interrupts the line."""

    role: Colour
    label: str
    x0: float
    dx: float
    values: Sequence[float | None]
    filled: bool = False
    """As bars, of which each begins at its x."""


class Line(msgspec.Struct, frozen=True):
    """A value of one axis, marked across the whole diagram."""

    name: str
    axis: Literal["x", "y"]
    value: float
    role: Colour
    draggable: bool = False


class CurveView(Element, component="curve_view.js", esm={"ods-charts": "charts"}):
    """One diagram."""

    def __init__(self, *, height: str = "14rem") -> None:
        super().__init__()
        self._props["shown"] = "{}"
        self.style(f"height: {height}")

    def show(
        self, title: str, axes: tuple[Axis, Axis], curves: Sequence[EvenCurve], lines: Sequence[Line] = ()
    ) -> None:
        """Show these; axes: x and y."""
        x, y = axes
        shown = msgspec.json.encode({"title": title, "x": x, "y": y, "curves": curves, "lines": lines}).decode()
        if self._props["shown"] == shown:
            return
        with self._props.suspend_updates():  # only the script gets it: NiceGUI would send all again
            self._props["shown"] = shown
        self.run_method("show", shown)

    def on_drag(self, callback: Callable[[str, float], None]) -> None:
        """Call `callback` with the name of a line that is dragged, and its new value."""
        self.on("drag", lambda event: callback(str(event.args["name"]), float(event.args["value"])))
