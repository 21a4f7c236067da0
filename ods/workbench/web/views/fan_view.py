"""A sonar image in the browser, as a fan or as beams beside each other, with its detections, axes and colour scale."""

from collections.abc import Callable
from typing import NamedTuple

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from ods.workbench.model.state import State, View
from ods.workbench.session import Session
from ods.workbench.web.follow import follow
from ods.workbench.web.frames import Channel, FrameSource

HOVER_S = 0.05
"""Between two events of a moving pointer."""


class Spot(NamedTuple):
    """A place in the image."""

    range_m: float
    bearing_rad: float
    beam: int
    sample: int
    level_db: float


class FanView(Element, component="fan_view.js", esm={"ods-charts": "charts", "ods-fan": "fan"}):
    """One picture. It asks for its frames by itself; show them in its source, or call `frames.wake`.

    Presentation, palette, attention and the pinned beam are the session's (`State.view`). Views of one page share the
    pointer: where it is in one of them is marked in all, each with its own level. Wheel: zoom; drag: pan; double click:
    the whole image again; ruler (M), or Shift and drag: measure. It fills the width it is given; `height` as in CSS.
    """

    def __init__(
        self, session: Session, source: FrameSource, view: str, *, title: str = "", height: str = "60vh"
    ) -> None:
        super().__init__()
        self._channel = Channel(source, view)
        self._props.update({"channel": self._channel.key, "title": title, **_shown(session.state.view)})
        self.style(f"height: {height}")
        follow(session, self, self._follow)

    @property
    def view(self) -> str:
        """What it shows of its source."""
        return self._channel.view

    def switch(self, view: str) -> None:
        """Show another view of the source, as blinking between A and B does."""
        self._channel.switch(view)

    def set_title(self, title: str) -> None:
        """Show another title."""
        self._set("title", title)

    def set_limits(self, limits_db: tuple[float, float] | None) -> None:
        """Set the ends of the colour scale, dB; None: the frame's own."""
        self._set("limits", limits_db)

    def set_busy(self, why: str) -> None:
        """Dim the picture and say why, while a newer one is computed; empty: it is the newest."""
        self._set("busy", why)

    def set_drawing(self, shape: str) -> None:
        """Let a drag draw a label: "rectangle" or "ellipse"; empty: it pans."""
        self._set("draws", shape)

    def on_drawn(self, callback: Callable[[tuple[int, int], tuple[int, int]], None]) -> None:
        """Call `callback` with first and last beam, and first and last sample, of what was drawn."""
        self.on("drawn", lambda event: callback(_ends(event.args["beams"]), _ends(event.args["samples"])))

    def set_cursor(self, range_m: float, bearing_rad: float) -> None:
        """Mark a place in this view and all others of the page."""
        self.run_method("point", range_m, bearing_rad)

    def on_hover(self, callback: Callable[[Spot], None]) -> None:
        """Call `callback` with the place under the pointer, as it moves."""
        self.on("hover", lambda event: callback(_spot(event)), throttle=HOVER_S)

    def on_pick(self, callback: Callable[[Spot], None]) -> None:
        """Call `callback` with the place of a click; pages do `SetView("pinned_beam", spot.beam)`."""
        self.on("pick", lambda event: callback(_spot(event)))

    def _follow(self, before: State, after: State) -> None:
        shown = _shown(after.view)
        if shown != _shown(before.view):
            self._props.update(shown)
            self.update()

    def _set(self, name: str, value: object) -> None:
        if self._props.get(name) != value:
            self._props[name] = value
            self.update()


def _shown(view: View) -> dict[str, object]:
    return {
        "presentation": view.presentation,
        "palette": view.palette,
        "attention": view.attention,
        "pinned": -1 if view.pinned_beam is None else view.pinned_beam,
    }


def _ends(pair: object) -> tuple[int, int]:
    assert isinstance(pair, list)
    first, last = (int(each) for each in pair)
    return first, last


def _spot(event: GenericEventArguments) -> Spot:
    args = event.args
    return Spot(
        float(args["range_m"]), float(args["bearing_rad"]), int(args["beam"]), int(args["sample"]),
        float(args["level_db"]),
    )  # fmt: skip
