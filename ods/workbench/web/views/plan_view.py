"""A plan in metres, north up: paths, objects, ellipses; with handles that can be dragged."""

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import msgspec
from nicegui.element import Element
from nicegui.events import GenericEventArguments

Place = tuple[float, float]
"""North and east, m."""
Role = Literal[
    "vehicle", "truth", "tentative", "active", "stand_by", "hibernated", "terminated", "uncertainty", "prediction",
    "approach", "goal", "sector", "object", "path", "veto",
]  # fmt: skip
"""What a shape stands for; says its colour and its line in the legend."""


class Line(msgspec.Struct, frozen=True, tag_field="kind", tag="line"):
    """Places joined by straight lines."""

    points: Sequence[Place]
    role: Role
    label: str = ""
    """At its last point."""
    dashed: bool = False
    marked: bool = False
    """Drawn strongly."""


class Area(msgspec.Struct, frozen=True, tag_field="kind", tag="area"):
    """What lies within a line around it."""

    points: Sequence[Place]
    role: Role
    label: str = ""
    dashed: bool = False
    marked: bool = False


class Circle(msgspec.Struct, frozen=True, tag_field="kind", tag="circle"):
    """Something round."""

    at: Place
    radius_m: float
    role: Role
    label: str = ""
    id: str = ""
    """Id reported when it is clicked on; empty: it cannot be."""
    dashed: bool = False
    marked: bool = False


class Ellipse(msgspec.Struct, frozen=True, tag_field="kind", tag="ellipse"):
    """How well a place is known."""

    at: Place
    semi_m: tuple[float, float]
    """Half axes."""
    turn_rad: float
    """Of the first axis, from north to east."""
    role: Role = "uncertainty"


class Mark(msgspec.Struct, frozen=True, tag_field="kind", tag="mark"):
    """A cross, or an arrow head that shows a heading; as large at every scale."""

    at: Place
    role: Role
    heading_rad: float | None = None
    """None: a cross."""
    label: str = ""
    id: str = ""


class Handle(msgspec.Struct, frozen=True, tag_field="kind", tag="handle"):
    """Something to drag."""

    id: str
    at: Place
    role: Role
    label: str = ""
    marked: bool = False


Shape = Line | Area | Circle | Ellipse | Mark | Handle


class Pick(NamedTuple):
    """A click."""

    id: str | None
    """Of the shape that was hit; None: beside all."""
    place: Place


class Drag(NamedTuple):
    """Where a handle is dragged to."""

    id: str
    place: Place
    done: bool
    """It was let go there."""


class PlanView(Element, component="plan_view.js", esm={"ods-charts": "charts"}):
    """Shapes in layers, drawn in the order in which the layers came first; a layer set again is replaced alone.

    Wheel: zoom; drag: pan; double click: all of it again; ruler (M), or Shift and drag: measure. It fills the width
    that it is given; `height` as in CSS.
    """

    def __init__(self, *, title: str = "", height: str = "60vh", follows: bool = False) -> None:
        """follows: show all of it whenever something is out of view, until it is zoomed or panned."""
        super().__init__()
        self._layers: dict[str, str] = {}
        self._props.update({"layers": {}, "title": title, "busy": "", "fitted": 0, "follows": follows})
        self.style(f"height: {height}; width: 100%")

    def show(self, layer: str, shapes: Sequence[Shape]) -> None:
        """Show these shapes as a layer, in place of those it had."""
        encoded = msgspec.json.encode(shapes).decode()  # as text: NiceGUI would watch each number for changes
        if encoded != self._layers.get(layer):
            self._layers[layer] = encoded
            with self._props.suspend_updates():  # for pages that come later; this one gets what is new only
                self._props["layers"] = dict(self._layers)
            self.run_method("setLayer", layer, encoded)

    def fit(self) -> None:
        """Show all of it: after another scene was opened."""
        self._set("fitted", self._props["fitted"] + 1)

    def set_title(self, title: str) -> None:
        """Write something over it."""
        self._set("title", title)

    def set_busy(self, why: str) -> None:
        """Dim the plan and say why, while a newer one is computed; empty: it is the newest."""
        self._set("busy", why)

    def on_pick(self, callback: Callable[[Pick], None]) -> None:
        """Call `callback` with each click."""
        self.on("pick", lambda event: callback(_pick(event)))

    def on_drag(self, callback: Callable[[Drag], None]) -> None:
        """Call `callback` as a handle is dragged, some times a second, and when it is let go."""
        self.on("drag", lambda event: callback(_drag(event)))

    def on_look(self, callback: Callable[[Place], None]) -> None:
        """Call `callback` with the middle of what is shown, once it was panned or zoomed."""
        self.on("look", lambda event: callback((float(event.args["north"]), float(event.args["east"]))))

    def _set(self, name: str, value: object) -> None:
        """Send the script one property; NiceGUI would send all of them."""
        if self._props.get(name) != value:
            with self._props.suspend_updates():
                self._props[name] = value
            self.run_method("set", name, value)


def _pick(event: GenericEventArguments) -> Pick:
    args = event.args
    return Pick(None if args["id"] is None else str(args["id"]), (float(args["north"]), float(args["east"])))


def _drag(event: GenericEventArguments) -> Drag:
    args = event.args
    return Drag(str(args["id"]), (float(args["north"]), float(args["east"])), bool(args["done"]))
